"""Comparing mice over many mazes."""
from __future__ import annotations

import os
import warnings
from typing import Any, Callable, Iterable, Mapping, Union

from . import _native
from ._native import Maze, Simulator, bundled_mazes

# As many as the bundled strategies with the most states. An endless search must end.
MAX_STATES = 10_000

MazeLike = Union[Maze, str, "os.PathLike[str]"]
Mouse = Callable[[Simulator], object]


def compare(
    mazes: MazeLike | Iterable[MazeLike] | None = None,
    mice: str | Iterable[str] | Mapping[str, str | Mouse] = ("flood-fill", "shortest-path-search"),
    max_states: int | None = None,
) -> list[dict[str, Any]]:
    """Returns one row for each maze and mouse, which `pandas.DataFrame` accepts.

    `mazes` holds mazes, paths of files and folders, and names of bundled mazes; by default, it is
    all bundled mazes. `mice` holds names of bundled strategies, or is a dict of names and
    strategies or functions. A function takes a `Simulator` and searches its maze; its
    figures come from the states that it reports. The keys of a row are those of
    `mmsim compare --json` where they exist there. The figures are those before the fast run, unless
    their name says otherwise.

    An exception of a function becomes the error of its row. Unreadable files of a folder are
    skipped with a warning. A search ends after `max_states` states: the simulator of a function
    refuses further ones. By default, functions may report 10,000 states.
    """
    found: list[Maze] = []
    for item in _items(mazes):
        found += _load(item)
    if isinstance(mice, str):
        mice = [mice]
    if not isinstance(mice, Iterable):
        raise TypeError('expected a name for a function (try mice={"mine": function})')
    named = dict(mice) if isinstance(mice, Mapping) else {name: name for name in mice}
    for mouse in named.values():
        if not isinstance(mouse, str) and not callable(mouse):
            raise TypeError(f"expected a strategy or a function, found {type(mouse).__name__}")
    if not all(isinstance(name, str) for name in named):
        raise TypeError('expected names (functions need one: mice={"mine": function})')
    strategies = [mouse for mouse in named.values() if isinstance(mouse, str)]
    rows = iter(_native.compare_strategies(found, strategies, max_states))
    table = []
    for maze in found:
        for name, mouse in named.items():
            if isinstance(mouse, str):
                table.append({**next(rows), "mouse": name})
            else:
                table.append(_run(name, mouse, maze, max_states))
    return table


def _items(mazes: MazeLike | Iterable[MazeLike] | None) -> Iterable[MazeLike]:
    if mazes is None:
        return bundled_mazes()
    if isinstance(mazes, (Maze, str, os.PathLike)):
        return [mazes]
    return mazes


def _load(item: MazeLike) -> list[Maze]:
    if isinstance(item, Maze):
        return [item]
    if os.path.isdir(item):
        mazes, errors = _native.load_folder(item)
        for error in errors:
            warnings.warn(f"skipped {error}", stacklevel=3)
        return mazes
    # A name has neither a folder nor an extension.
    is_name = isinstance(item, str) and os.path.splitext(os.path.basename(item)) == (item, "")
    if isinstance(item, str) and is_name and not os.path.exists(item):
        return [Maze.bundled(item)]
    return [Maze.load(item)]


def _run(name: str, mouse: Mouse, maze: Maze, max_states: int | None) -> dict[str, Any]:
    """Runs a function and returns the figures of the states that it has reported."""
    limit = MAX_STATES if max_states is None else max_states
    simulator = Simulator(maze, max_states=limit)
    error = ending = None
    try:
        mouse(simulator)
    except Exception as exception:
        error = f"{type(exception).__name__}: {exception}"
        ending = "step_limit" if len(simulator.history) >= limit else "failed"
    return _native.history_row(simulator, name, error, ending)
