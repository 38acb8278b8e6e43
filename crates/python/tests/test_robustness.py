"""Calls every function with random arguments. Whatever they are, no panic crosses the border."""
import math
import random
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

import micromouse_sim as mm

# `pyo3_runtime.PanicException` derives from `BaseException`.
EXPECTED = (mm.Error, ValueError, TypeError, OverflowError, OSError, LookupError)

# Without an argument, these wait for a server, or search for a long time.
SLOW = {"compare", "contest", "trial", "search", "Client", "Connection", "Error"}


class Index:
    """Raises an exception in the middle of a call."""

    def __index__(self) -> int:
        raise ZeroDivisionError

    def __str__(self) -> str:
        raise ZeroDivisionError

    def __iter__(self) -> Any:
        raise ZeroDivisionError


def arguments(folder: Path) -> list[Callable[[random.Random], Any]]:
    """Returns functions that create arguments: numbers, texts, grids, objects of the module."""
    maze, half = mm.Maze.bundled("01"), mm.Maze.bundled("half")
    simulator = mm.Simulator(maze)
    simulator.state(0, 0, "N", maze.distances(), maze.walls)
    return [
        lambda rng: rng.choice([0, 1, 2, 7, 15, 16, 31, 32, 255, 256, -1, 2**63, 2**64, -(2**70)]),
        lambda rng: rng.choice([0.5, math.nan, math.inf, None, True, b"", b"W\0\0N", Index()]),
        lambda rng: rng.choice([*"NESW", "", "n", "\ud800", "\0", "é" * 50, "open", "closed", "1"]),
        lambda rng: rng.choice([*mm.Heading, *mm.STRATEGIES, "contest", "ares", "text", "hex"]),
        lambda rng: rng.randrange(16),
        lambda rng: rng.choice("NESW"),
        lambda rng: [[rng.randrange(300) for _ in range(16)] for _ in range(16)],
        lambda rng: rng.choice([maze.distances(), maze.walls, half.walls, np.zeros((16, 16)),
                                np.zeros((0, 3), np.uint8), np.zeros(3), np.array(3)]),
        lambda rng: (rng.randrange(-1, 34), rng.randrange(-1, 34)),
        lambda rng: [(rng.randrange(-1, 34), rng.randrange(-1, 34)) for _ in range(3)],
        lambda rng: tuple(rng.choice([True, False, None]) for _ in range(rng.randrange(2, 5))),
        lambda rng: rng.choice([maze, half, simulator, simulator.history, simulator.history[0]]),
        lambda rng: rng.choice([mm.KnownMaze(), mm.KnownMaze((3, 2)), simulator.unexplored()]),
        lambda rng: slice(*(rng.choice([None, 0, 1, -1, 5, -(2**63), 2**63]) for _ in range(3))),
        lambda rng: folder / rng.choice(["file.txt", "missing/file", "."]),
    ]


@pytest.mark.parametrize("seed", range(20))
def test_random_arguments_raise_exceptions_only(seed: int, tmp_path: Path) -> None:
    rng, makers = random.Random(seed), arguments(tmp_path)
    client = mm.Client("tcp://127.0.0.1:1", timeout=0.0)
    recording = tmp_path / "run.mcap"
    mm.Simulator(mm.Maze.bundled("01")).save(recording)
    outcomes = [0, 0]
    for _ in range(150):
        objects = [
            mm.Maze.generate(rng.randrange(9), (rng.randrange(1, 33), rng.randrange(1, 33))),
            mm.KnownMaze((rng.randrange(1, 33), rng.randrange(1, 33))),
            mm.Strategy(rng.choice(mm.STRATEGIES)),
            mm.load_recording(recording),
            mm.Maze,
            mm.KnownMaze,
            client,
            mm,
        ]
        simulator = mm.Simulator(mm.Maze.bundled("01"))
        objects += [simulator, simulator.history]
        for target in objects:
            names = [name for name in dir(target) if not name.startswith("__")]
            names += ["__getitem__", "__eq__", "__call__"]
            name = rng.choice(names)
            is_module_part = target is mm and (name in SLOW or name.startswith("_"))
            if is_module_part or name in ("__class__", "_native"):
                continue
            given = [rng.choice(makers)(rng) for _ in range(rng.randrange(6))]
            try:
                found = getattr(target, name)
                if callable(found):
                    found(*given)
                outcomes[0] += 1
            except (*EXPECTED, ZeroDivisionError, AttributeError, UnicodeEncodeError):
                outcomes[1] += 1
    assert min(outcomes) > 100, "both happen often"


@pytest.mark.parametrize("name", mm.STRATEGIES)
def test_strategies_survive_impossible_searches(name: str) -> None:
    rng = random.Random(name)
    for _ in range(60):
        width, height = rng.randrange(1, 20), rng.randrange(1, 20)
        cells = [(rng.randrange(width), rng.randrange(height)) for _ in range(3)]
        known, strategy = mm.KnownMaze((width, height), cells[:2], cells[2]), mm.Strategy(name)
        for _ in range(12):
            pose = rng.randrange(width), rng.randrange(height), rng.choice(list(mm.Heading))
            try:
                known.observe(*pose, [rng.random() < 0.5 for _ in range(3)])
                strategy.next_move(known, *pose)
                strategy.weights()
            except (mm.Contradiction, mm.SearchError):
                pass
