# A robot that reads a word from the command line of the tester: python tester.py maze.txt right
import sys

from walker import Walker


class Robot(Walker):
    def __init__(self, maze_dim):
        turns = {"left": (-90, 0, 90), "right": (90, 0, -90)}
        Walker.__init__(self, maze_dim, turns[sys.argv[2]])
