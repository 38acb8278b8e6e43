"""The keys of rows and dicts are those of docs/keys.md."""
from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Iterator

import micromouse_sim as mm

DICTIONARY = Path(__file__).resolve().parents[3] / "docs" / "keys.md"


def keys(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from value
    for item in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from keys(item)


def test_all_keys_are_in_the_dictionary(tmp_path: Path) -> None:
    rows = [row.split(" | ")[0] for row in DICTIONARY.read_text().splitlines() if row.startswith("| `")]
    known = {key for row in rows for key in re.findall("`([^`]+)`", row)}
    maze = mm.Maze.generate(1, (5, 5))
    simulator = mm.Simulator(maze)
    search = mm.search(simulator, "swing")
    simulator.save(tmp_path / "a.mcap")
    found = [
        mm.compare(maze, "swing", vehicle="ares"), mm.contest(maze, "swing"), mm.trial(maze), search.phases,
        mm.load_recording(tmp_path / "a.mcap").info,
    ]
    assert len(set(keys(found))) > 60
    assert set(keys(found)) <= known
