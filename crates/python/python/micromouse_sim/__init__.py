"""A micromouse maze simulator.

    import micromouse_sim as mm

    simulator = mm.Simulator(mm.Maze.bundled("01"))
    left, front, right = simulator.walls(*simulator.start)

Cell (0, 0) is the south-west corner, x grows east, y grows north. NumPy is imported with the first
array.
"""
from ._errors import (
    Contradiction,
    Error,
    MazeError,
    NoReply,
    Refused,
    SearchError,
    SimulatorError,
)
from ._native import Connection, Maze, Simulator, bundled_mazes
from ._types import Heading, Pose, Walls

__all__ = [
    "Connection",
    "Contradiction",
    "Error",
    "Heading",
    "Maze",
    "MazeError",
    "NoReply",
    "Pose",
    "Refused",
    "SearchError",
    "Simulator",
    "SimulatorError",
    "Walls",
    "bundled_mazes",
]
