# A robot with the syntax of both Pythons, but a module, a function and a method of Python 2.
import Queue

from walker import Walker


class Robot(Walker):
    def __init__(self, maze_dim):
        Walker.__init__(self, maze_dim)
        self.cells = Queue.PriorityQueue()
        for x in xrange(maze_dim / 2):
            self.cells.put(x)

    def next_move(self, sensors):
        if self.visits.has_key((0, 0)) and not self.cells.empty():
            self.cells.get()
        return Walker.next_move(self, sensors)
