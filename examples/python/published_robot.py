"""Runs the robot in a robot.py of the project "plot and navigate a virtual maze" in `mmsim trial`.

`mmsim trial MAZE --published robot.py` starts this adapter with the path of the robot. It uses the
published interface: `Robot(maze_dim)`, and `next_move(sensors)`, which returns a rotation in degrees
and a movement in cells, or 'Reset', 'Reset'.
"""

import runpy
import sys
from pathlib import Path
from typing import Any


def answer(rotation: Any, movement: Any) -> str:
    """Returns a move as the published tester would execute it."""
    if (rotation, movement) == ("Reset", "Reset"):
        return "reset"
    degrees = int(rotation) if rotation in (-90, 0, 90) else 0
    return f"{degrees} {int(movement)}"


def main() -> None:
    file = Path(sys.argv[1]).resolve()
    # Whatever the robot prints must not be taken for an answer.
    answers, sys.stdout = sys.stdout, sys.stderr
    _, width, height, *_ = sys.stdin.readline().split()
    if width != height:
        sys.exit(f"the published interface has only square mazes, found {width}x{height}")
    # The robot may import files in its folder.
    sys.path.insert(0, str(file.parent))
    robot = runpy.run_path(str(file))["Robot"](int(width))
    for line in sys.stdin:
        rotation, movement = robot.next_move([int(word) for word in line.split()])
        print(answer(rotation, movement), file=answers, flush=True)


if __name__ == "__main__":
    main()
