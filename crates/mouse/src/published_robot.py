"""Runs the robot in a robot.py of the project "plot and navigate a virtual maze" in `mmsim trial`.

`mmsim trial MAZE --published robot.py WORD...` starts this adapter with the path of the robot and the
words. It uses the published interface: `Robot(maze_dim)`, and `next_move(sensors)`, which returns a
rotation in degrees and a movement in cells, or 'Reset', 'Reset'. It runs in Python 2.7 and 3.
"""
import os
import sys


def load(path):
    """Loads the file as the module robot."""
    # The published tester runs in the folder of the robot, as `python tester.py maze.txt WORD...`.
    sys.argv[:2] = ["tester.py", "maze.txt"]
    os.chdir(os.path.dirname(path))
    sys.path.insert(0, os.getcwd())
    try:
        from importlib.machinery import SourceFileLoader
        from importlib.util import module_from_spec, spec_from_loader
    except ImportError:  # Python 2
        import imp

        return imp.load_source("robot", path)
    spec = spec_from_loader("robot", SourceFileLoader("robot", path))
    module = sys.modules["robot"] = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def answer(rotation, movement):
    """Returns a move as the published tester would execute it."""
    if (rotation, movement) == ("Reset", "Reset"):
        return "reset"
    degrees = int(rotation) if rotation in (-90, 0, 90) else 0
    cells = 3 if abs(movement) > 3 else abs(int(movement))
    return "%d %d" % (degrees, cells if movement > 0 else -cells)


def main():
    # Whatever the robot prints goes to stderr, and whatever it reads is empty.
    lines, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    width, height = lines.readline().split()[1:3]
    if width != height:
        sys.exit("the published interface has only square mazes, found %sx%s" % (width, height))
    robot = load(os.path.abspath(sys.argv[1])).Robot(int(width))
    for line in iter(lines.readline, ""):
        rotation, movement = robot.next_move([int(word) for word in line.split()])
        answers.write(answer(rotation, movement) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
