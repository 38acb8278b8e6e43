# A robot in Python 3.
from walker import Walker


class Robot(Walker):
    def __init__(self, maze_dim: int):
        super().__init__(maze_dim)
        print(f"a robot for {maze_dim}")
