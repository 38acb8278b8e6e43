# A robot whose own file is Python 2 and 3, and which imports a module in Python 2.
import python2_print


class Robot(python2_print.Robot):
    pass
