from __future__ import annotations

import json
import subprocess
from pathlib import Path

import flood_fill
import pytest

import micromouse_sim as mm


def test_the_figures_are_those_of_the_command(mmsim: str, tmp_path: Path) -> None:
    for name in ("01", "05", "unreachable", "trial-14"):
        maze = mm.Maze.bundled(name)
        maze.save(tmp_path / f"{maze.name}.txt")
    command = [mmsim, "compare", "--json", "--strategies", "all", str(tmp_path)]
    reports = json.loads(subprocess.run(command, capture_output=True).stdout)
    rows = mm.compare(tmp_path, mm.STRATEGIES)
    assert len(rows) == 4 * len(mm.STRATEGIES)
    for report in reports:
        for expected in report["mazes"]:
            [row] = [
                row for row in rows
                if (row["maze"], row["mouse"]) == (expected["name"], report["strategy"])
            ]
            shared = row.keys() & expected.keys()
            assert len(shared) >= 12
            assert {key: row[key] for key in shared} == {key: expected[key] for key in shared}


def test_a_function_has_the_figures_of_the_states_it_reports() -> None:
    mice = {"mine": flood_fill.search, "bundled": "flood-fill"}
    rows = mm.compare(["01-harbour", mm.Maze.generate(1), mm.Maze.generate(2, (9, 7))], mice)
    assert [row["mouse"] for row in rows] == ["mine", "bundled"] * 3
    for mine, bundled in zip(rows[::2], rows[1::2]):
        assert {**mine, "mouse": "bundled"} == bundled
    pandas = pytest.importorskip("pandas")
    assert len(pandas.DataFrame(rows)) == 6


def test_returns_and_fast_runs_of_a_function_count_apart() -> None:
    def mouse(simulator: mm.Simulator) -> None:
        strategy, known = mm.Strategy("shortest-path-search"), simulator.unexplored()
        pose: mm.Pose | None = simulator.start
        while pose is not None:
            known.observe(*pose, simulator.walls(*pose))
            following = strategy.next_move(known, *pose)
            simulator.state(*pose, strategy.weights(), known)
            pose = following

    for row, expected in zip(
        mm.compare(["01-harbour", "05-hedgerow"], {"mine": mouse}),
        mm.compare(["01-harbour", "05-hedgerow"], "shortest-path-search"),
    ):
        for key in ("steps_to_goal", "steps_in_all", "turns", "path_found", "fast_run_steps",
                    "steps_until_proven", "visited_cells", "states", "ending"):
            assert row[key] == expected[key], key


def test_faults_of_a_function_are_reported_in_its_row() -> None:
    def crash(simulator: mm.Simulator) -> None:
        simulator.walls(99, 0, "N")

    def circle(simulator: mm.Simulator) -> None:
        while True:
            simulator.state(0, 0, "N", simulator.maze.distances(), simulator.maze.walls)

    [first, second] = mm.compare("01-harbour", {"crash": crash, "circle": circle}, max_states=50)
    assert first["error"].startswith("Refused: the simulator refused W: ")
    assert (first["ending"], first["goal_reached"], first["states"]) == ("failed", False, 0)
    assert (second["ending"], second["states"]) == ("step_limit", 50)

    def interrupted(simulator: mm.Simulator) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mm.compare("01-harbour", {"interrupted": interrupted})


def test_unreadable_files_are_reported(tmp_path: Path) -> None:
    mm.Maze.generate(1).save(tmp_path / "good.txt")
    (tmp_path / "bad.txt").write_text("bad")
    with pytest.warns(UserWarning, match="skipped .*bad.txt: line 1"):
        assert [row["maze"] for row in mm.compare(tmp_path, "left-wall")] == ["good"]
    with pytest.raises(mm.MazeError, match="bad.txt"):
        mm.compare(tmp_path / "bad.txt")
    with pytest.raises(FileNotFoundError):
        mm.compare(tmp_path / "missing.txt")
    with pytest.raises(mm.MazeError, match="no bundled maze matches"):
        mm.compare("nowhere")
    with pytest.raises(ValueError, match="expected one of flood-fill"):
        mm.compare("01-harbour", "luck")


def test_a_function_that_never_stops_ends_after_a_default_limit() -> None:
    def wait(simulator: mm.Simulator) -> None:
        while True:
            simulator.state(0, 0, "N", [[0, 0]] * 2, [[0, 0]] * 2)

    maze = mm.Maze.parse("o---o---o\n|     G |\no   o   o\n| S     |\no---o---o\n")
    [row] = mm.compare(maze, {"endless": wait})
    assert row["ending"] == "step_limit" and "10000 states" in row["error"]
