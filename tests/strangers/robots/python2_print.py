# A robot in Python 2, the language of the course: Python 3 refuses its syntax.
from walker import Walker


class Robot(Walker):
    def __init__(self, maze_dim):
        Walker.__init__(self, maze_dim)
        print "a robot for", maze_dim
