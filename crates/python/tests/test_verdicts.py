"""The verdict on a function is that of the command on a client that does the same."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import micromouse_sim as mm

FILE = Path(__file__).parents[2] / "cli/tests/verdicts/mice.json"
CASES = json.loads(FILE.read_text())


# A function has no process that a signal can kill, and does not wait for a refused reply.
PROCESSES = ("killed", "waits-for-a-refused-reply")
MICE = [case for case in CASES["mice"] if case["name"] not in PROCESSES]


@pytest.mark.parametrize("case", MICE, ids=lambda case: case["name"])
def test_the_verdict_is_that_of_the_command(case: dict[str, Any]) -> None:
    maze = mm.Maze.parse(CASES["maze"])

    def mouse(simulator: mm.Simulator) -> None:
        empty = [[0] * maze.height] * maze.width
        for word in case["poses"].split():
            if word in ("reset", "restart"):
                getattr(simulator, word)()
                continue
            pose = (int(word[0]), int(word[1]), word[2])
            try:
                simulator.walls(*pose)
            except mm.Refused:  # a wall blocks the mouse
                continue
            walls = [list(column) for column in empty]
            walls[pose[0]][pose[1]] = 2 if word.endswith("+E") else 0
            simulator.state(*pose, empty, walls)
        if case["name"] == "crashes":
            raise RuntimeError("a bad day")
        while case["name"] == "hangs":
            simulator.state(*pose, empty, empty)

    crashes = case.get("crashes")
    misread = 0.0 if crashes is None else 1.0
    [row] = mm.compare(maze, {case["name"]: mouse}, max_states=50, misread=misread)
    assert row["crashes"] == crashes
    # A function has a limit of states instead of a time limit, and raises instead of exiting.
    expected = {"hangs": "step_limit"}.get(case["name"], case["ending"])
    assert (row["goal_reached"], row["ending"]) == (case["goal_reached"], expected)
    if case["name"] not in ("crashes", "hangs"):
        assert (row["error"] or "").startswith(case["error"] or "")
        assert (row["cause"] or {}).get("kind") == case.get("cause")
