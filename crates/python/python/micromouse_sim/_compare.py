"""Comparing mice and robots over many mazes."""
from __future__ import annotations

import os
import warnings
from typing import Any, Callable, Iterable, Iterator, Mapping, Union

from . import _native
from ._native import Maze, Simulator, bundled_mazes

Mouse = Callable[[Simulator], object]
Mice = Union[str, Iterable[str], Mapping[str, Union[str, Mouse]]]
Path = Union[str, "os.PathLike[str]"]
Published = Union[Path, Iterable[Path], Mapping[str, Union[Path, Iterable[Path]]]]

MazeLike = Union[Maze, Path]

DEFAULT_MICE = ("flood-fill", "shortest-path-search")


def compare(
    mazes: MazeLike | Iterable[MazeLike] | None = None,
    mice: Mice = DEFAULT_MICE,
    max_states: int | None = None,
    *,
    vehicle: str | None = None,
    time_limit: float = 10.0,
    misread: float = 0.0,
    misread_fixed: bool = False,
    misread_seed: int = 1,
    recover: bool = False,
    stop_at_goal: bool = False,
) -> list[dict[str, Any]]:
    """Returns one row for each maze and mouse, which `pandas.DataFrame` accepts.

    `mazes` holds mazes, paths of files and folders, and names of bundled mazes; by default, it is
    all bundled mazes. `mice` holds names of bundled strategies and commands of programs, such as
    `python3 mouse.py` or `./mouse`, or is a dict of names and strategies, commands or functions. A
    function takes a `Simulator` and searches its maze; its figures come from the states that it
    reports. The keys of a row are the columns of `mmsim compare --csv`. The figures are those before
    the fast run, unless their name says otherwise.

    Rows contain the times of a `vehicle` in seconds: a preset or a TOML file, by default expert, or
    kerise in mazes larger than 16×16.

    An exception of a function becomes the error of its row. Unreadable files of a folder are
    skipped with a warning. A search ends after `max_states` states: the simulator of a function
    refuses further ones. By default, functions and programs may report 10,000 states. A program is
    stopped after `time_limit` seconds. With `stop_at_goal`, a program is stopped when it reaches the
    goal. A function must return by itself, but what it does after the goal does not count.

    Mice misread walls with the probability `misread`, with `misread_fixed` the same walls each time.
    The same `misread_seed` gives the same wrong readings. A movement that a wall blocks is refused.
    With `recover`, strategies recover from wrong readings.
    """
    rows: list[dict[str, Any]] = _native.compare(
        _competition(
            _mazes(mazes), mice, max_states=max_states, vehicle=vehicle,
            time_limit=time_limit, misread=misread, misread_fixed=misread_fixed,
            misread_seed=misread_seed, recover=recover,
            stop_at_goal=stop_at_goal,
        )
    )
    return rows


def contest(
    mazes: MazeLike | Iterable[MazeLike] | None = None,
    mice: Mice = DEFAULT_MICE,
    max_states: int | None = None,
    *,
    rules: str = "best-run",
    vehicle: str | None = None,
    time_limit: float = 10.0,
    misread: float = 0.0,
    misread_fixed: bool = False,
    misread_seed: int = 1,
    recover: bool = False,
) -> dict[str, Any]:
    """Returns the results of a contest, with the keys of `mmsim contest --json`.

    `rules` is `best-run`, `apec` or `uk`. The other arguments are those of `compare`.
    """
    results: dict[str, Any] = _native.compare(
        _competition(
            _mazes(mazes), mice, max_states=max_states, vehicle=vehicle,
            time_limit=time_limit, misread=misread, misread_fixed=misread_fixed,
            misread_seed=misread_seed, recover=recover,
            stop_at_goal=False,
        ),
        rules,
    )
    return results


def trial(
    mazes: MazeLike | Iterable[MazeLike] | None = None,
    robots: str | Iterable[str] | Mapping[str, str] | None = None,
    *,
    published: Published | None = None,
    python: Path | None = None,
    seed: int = 0,
    noise: float = 0.0,
    answer_limit: float = 10.0,
) -> list[dict[str, Any]]:
    """Runs the two-run trial, and returns one row for each robot and maze.

    `robots` holds names of `ROBOTS` and commands of programs, or is a dict of names and robots or
    commands. `published` holds paths of files with the published interface, or is a dict of names
    and paths or sequences of a path and the words that follow the maze in `sys.argv`. `python` runs
    these files; by default, it is the first Python 3 or 2 on the PATH that suits the file.

    The keys of a row are those of `mmsim trial --compare --json`. Without robots, the rows are those
    of its tables. `noise` is the probability that a sensor reading is off by one cell. A program is
    stopped if an answer takes longer than `answer_limit` seconds.
    """
    named = None if robots is None else list(_named(robots).items())
    if not all(isinstance(robot, str) for _, robot in named or []):
        raise TypeError("expected names of robots or commands")
    if python is not None and published is None:
        raise ValueError("expected files in published, which python runs")
    files = None if published is None else list(_published(published))
    python = None if python is None else os.fspath(python)
    return _native.trial(_mazes(mazes), named, files, python, seed, noise, answer_limit)


def _published(published: Published) -> Iterator[tuple[str, list[str]]]:
    """Returns the name of each robot, and the path of its file with the words that follow it."""
    if isinstance(published, Mapping):
        for name, words in published.items():
            if isinstance(words, (str, os.PathLike)):
                words = [words]
            yield str(name), [os.fspath(word) for word in words]
        return
    paths = [published] if isinstance(published, (str, os.PathLike)) else published
    seen: dict[str, int] = {}
    for path in paths:
        name = os.path.basename(path)
        seen[name] = seen.get(name, 0) + 1
        yield name if seen[name] == 1 else f"{name} ({seen[name]})", [os.fspath(path)]


def _competition(mazes: list[Maze], mice: Mice, **options: object) -> dict[str, object]:
    named = _named(mice)
    for mouse in named.values():
        if not isinstance(mouse, str) and not callable(mouse):
            raise TypeError(f"expected a strategy or a function, found {type(mouse).__name__}")
    return {"mazes": mazes, "mice": list(named.items()), **options}


def _named(mice: str | Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(mice, str):
        mice = [mice]
    if not isinstance(mice, Iterable):
        raise TypeError('expected a name for a function (try mice={"mine": function})')
    named = dict(mice) if isinstance(mice, Mapping) else {name: name for name in mice}
    if not all(isinstance(name, str) for name in named):
        raise TypeError('expected names (functions need one: mice={"mine": function})')
    return named


def _mazes(mazes: MazeLike | Iterable[MazeLike] | None) -> list[Maze]:
    if mazes is None:
        mazes = bundled_mazes()
    if isinstance(mazes, (Maze, str, os.PathLike)):
        mazes = [mazes]
    found: list[Maze] = []
    for item in mazes:
        found += _load(item)
    return found


def _load(item: MazeLike) -> list[Maze]:
    if isinstance(item, Maze):
        return [item]
    if os.path.isdir(item):
        mazes, errors = _native.load_folder(item)
        for error in errors:
            warnings.warn(f"skipped {error}", stacklevel=4)
        return mazes
    # A name has neither a folder nor an extension.
    is_name = isinstance(item, str) and os.path.splitext(os.path.basename(item)) == (item, "")
    if isinstance(item, str) and is_name and not os.path.exists(item):
        return [Maze.bundled(item)]
    return [Maze.load(item)]
