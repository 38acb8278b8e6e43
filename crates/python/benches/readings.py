"""Measures wall readings per second from a Python loop.

The same readings come from a `Simulator`, from a dict in plain Python and from a NumPy array. The
rounds are interleaved, so a busy machine slows down all of them.
"""
from __future__ import annotations

import statistics
import time
from typing import Callable

import micromouse_sim as mm

ROUNDS = 9
REPETITIONS = 200

Reading = Callable[[int, int, str], tuple[bool, bool, bool]]

MAZE = mm.Maze.bundled("01-harbour")
HEADINGS = "NESW"
POSES = [(x, y, h) for x in range(MAZE.width) for y in range(MAZE.height) for h in HEADINGS]


def plain_python() -> Reading:
    """Looks up each wall in a dict."""
    walls = {(x, y, h): MAZE.has_wall(x, y, h) for x, y, h in POSES}  # type: ignore[arg-type]
    turned = {h: (HEADINGS[i - 1], h, HEADINGS[(i + 1) % 4]) for i, h in enumerate(HEADINGS)}

    def read(x: int, y: int, heading: str) -> tuple[bool, bool, bool]:
        left, front, right = turned[heading]
        return walls[x, y, left], walls[x, y, front], walls[x, y, right]

    return read


def numpy_array() -> Reading:
    """Looks up the flags of the cell in an array."""
    flags, bits = MAZE.walls, {"N": 16, "E": 2, "S": 4, "W": 8}
    masks = {
        h: (bits[HEADINGS[i - 1]], bits[h], bits[HEADINGS[(i + 1) % 4]])
        for i, h in enumerate(HEADINGS)
    }

    def read(x: int, y: int, heading: str) -> tuple[bool, bool, bool]:
        left, front, right = masks[heading]
        cell = int(flags[x, y])
        return cell & left != 0, cell & front != 0, cell & right != 0

    return read


def readings_per_second(read: Reading) -> float:
    """Reads the walls around every pose and returns the number of readings per second."""
    start = time.perf_counter()
    for _ in range(REPETITIONS):
        for x, y, heading in POSES:
            read(x, y, heading)
    return REPETITIONS * len(POSES) / (time.perf_counter() - start)


if __name__ == "__main__":
    contenders: dict[str, Reading] = {
        "Simulator.walls": mm.Simulator(MAZE).walls,  # type: ignore[dict-item]
        "plain Python": plain_python(),
        "NumPy": numpy_array(),
    }
    for pose in POSES:
        assert len({read(*pose) for read in contenders.values()}) == 1, pose
    rounds = [{name: readings_per_second(read) for name, read in contenders.items()}
              for _ in range(ROUNDS)]
    for name in contenders:
        median = statistics.median(one[name] for one in rounds)
        print(f"{name:16} {median / 1e6:6.2f} million readings/s (median of {ROUNDS} rounds)")
