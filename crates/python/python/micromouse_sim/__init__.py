"""A micromouse maze simulator.

    import micromouse_sim as mm

    simulator = mm.Simulator(mm.Maze.bundled("01-harbour"))
    left, front, right = simulator.walls(*simulator.start)

Cell (0, 0) is the south-west corner, x grows east, y grows north. Arrays with a number for each cell
are indexed as `array[x, y]`. NumPy is imported with the first array.
"""
from ._errors import (
    Contradiction,
    Error,
    MazeError,
    NoReply,
    RecordingError,
    Refused,
    SearchError,
    SimulatorError,
)
from ._native import (
    ROBOTS,
    STRATEGIES,
    Client,
    Connection,
    FastRun,
    History,
    KnownMaze,
    Maze,
    Recording,
    Search,
    Simulator,
    State,
    Strategy,
    bundled_mazes,
    flood,
    load_recording,
    search,
)
from ._types import Heading, Pose, Walls
from ._compare import compare, contest, trial

__all__ = [
    "ROBOTS",
    "STRATEGIES",
    "Client",
    "Connection",
    "Contradiction",
    "Error",
    "FastRun",
    "Heading",
    "History",
    "KnownMaze",
    "Maze",
    "MazeError",
    "NoReply",
    "Pose",
    "Recording",
    "RecordingError",
    "Refused",
    "Search",
    "SearchError",
    "Simulator",
    "SimulatorError",
    "State",
    "Strategy",
    "Walls",
    "bundled_mazes",
    "compare",
    "contest",
    "flood",
    "load_recording",
    "search",
    "trial",
]
