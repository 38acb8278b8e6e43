# A robot that reads a file in its folder while it is running, by a relative path.
from walker import Walker


class Robot(Walker):
    def __init__(self, maze_dim):
        with open("turns.txt") as turns:
            Walker.__init__(self, maze_dim, tuple(int(turn) for turn in turns))
