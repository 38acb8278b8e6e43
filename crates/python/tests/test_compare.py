from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

import flood_fill
import pytest
from conftest import LIMIT

import micromouse_sim as mm


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Returns a folder with four mazes."""
    for name in ("01", "05", "unreachable", "trial-14"):
        maze = mm.Maze.bundled(name)
        maze.save(tmp_path / f"{maze.name}.txt")
    return tmp_path


def output(*command: object) -> Any:
    """Runs a command, and returns its JSON."""
    words = [*map(str, command), "--json"]
    return json.loads(subprocess.run(words, capture_output=True, timeout=LIMIT).stdout)


@pytest.mark.parametrize("vehicle", [None, "ares"])
def test_the_figures_are_those_of_the_command(
    mmsim: str, folder: Path, vehicle: str | None
) -> None:
    options = [f"--vehicle={vehicle}"] if vehicle else []
    reports = output(mmsim, "compare", "--strategies", "all", folder, *options)
    rows = mm.compare(folder, mm.STRATEGIES, vehicle=vehicle)
    expected = [
        {"mouse": report["mouse"], **report["mazes"][maze]}
        for maze in range(4)
        for report in reports
    ]
    for row in rows + expected:
        assert row.pop("processor_time_us") is None or row["goal_reached"] in (True, False)
        assert "total_time_s" in row
    assert rows == expected


@pytest.mark.parametrize("is_fixed", [False, True])
@pytest.mark.parametrize("recover", [False, True])
def test_wrong_readings_are_those_of_the_command(
    mmsim: str, folder: Path, is_fixed: bool, recover: bool
) -> None:
    options = ["--misread=5%", "--misread-seed=3"]
    options += ["--misread-fixed"] * is_fixed + ["--recover"] * recover
    reports = output(mmsim, "compare", "--strategies=flood-fill,swing", folder, *options)
    mice = {"flood-fill": "flood-fill", "swing": "swing", "mine": flood_fill.search}
    rows = mm.compare(
        folder, mice, misread=0.05, misread_fixed=is_fixed, misread_seed=3, recover=recover
    )
    for maze in range(4):
        for report, row in zip(reports, rows[3 * maze:]):
            assert {**report["mazes"][maze], "processor_time_us": row["processor_time_us"]}.items() <= row.items()
        # A function misreads the same walls, but does not recover.
        if not recover:
            assert all(
                rows[3 * maze + 2][key] == rows[3 * maze][key]
                for key in ("goal_reached", "search_steps", "search_turns", "crashes", "states")
            )
    contest = ["contest", folder, "--strategies=flood-fill,swing", *options]
    assert output(mmsim, *contest) == mm.contest(
        folder, ("flood-fill", "swing"), misread=0.05, misread_fixed=is_fixed, misread_seed=3,
        recover=recover,
    )


def test_what_a_function_does_after_the_goal_may_be_ignored() -> None:
    maze = mm.Maze.parse("o---o---o\n| S   G |\no---o---o\n")

    def mouse(simulator: mm.Simulator) -> None:
        empty = [[0] * maze.height] * maze.width
        for x in (0, 1, 0):
            simulator.state(x, 0, "E", empty, empty)
        raise RuntimeError("a bad day")

    for stops, expected in ((False, (3, "failed", "RuntimeError: a bad day")),
                            (True, (2, "finished", None))):
        [row] = mm.compare(maze, {"mine": mouse}, stop_at_goal=stops)
        assert row["goal_reached"]
        assert (row["states"], row["ending"], row["error"]) == expected


def test_a_contest_is_that_of_the_command(mmsim: str, folder: Path) -> None:
    options = ["--rules=apec", "--vehicle=ares", "--strategies=swing,left-wall"]
    mice = ("swing", "left-wall")
    expected = output(mmsim, "contest", folder, *options)
    assert mm.contest(folder, mice, rules="apec", vehicle="ares") == expected
    mine = mm.contest("01-harbour", {"mine": flood_fill.search, "bundled": "flood-fill"})
    [first, second] = mine["mazes"][0]["entries"]
    assert {**first, "mouse": "bundled"} == second
    with pytest.raises(ValueError, match="expected one of best-run, apec, uk"):
        mm.contest("01-harbour", rules="none")


def test_a_trial_is_that_of_the_command(mmsim: str, folder: Path) -> None:
    rows = output(mmsim, "trial", folder, "--compare", "--noise=0.01", "--seed=3")
    assert mm.trial(folder, noise=0.01, seed=3) == rows
    robots = mm.trial(folder, mm.ROBOTS, noise=0.01, seed=3)
    assert robots == [row for row in rows if row["table"] == "robots"]
    [row] = mm.trial(mm.Maze.generate(1), {"mine": "proven"})
    assert (row["row"], row["mouse"], row["ending"]) == ("mine", "proven", "scored")
    assert row["maze"] == "contest-16x16-1"
    with pytest.raises(ValueError, match="expected one of random"):
        mm.trial("01-harbour", "luck")
    with pytest.raises(ValueError, match="probability from 0 to 1"):
        mm.trial("01-harbour", noise=2.0)
    with pytest.raises(TypeError, match="expected names of robots"):
        mm.trial("01-harbour", {"mine": flood_fill.search})


def test_a_robot_may_have_the_published_interface(
    mmsim: str, folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    robot = tmp_path_factory.mktemp("robots") / "my robot.py"
    robot.write_text("""\
import sys
class Robot:
    def __init__(self, maze_dim):
        sys.exit(f"{maze_dim} {sys.argv[1:]}")
    def next_move(self, sensors):
        return 0, 1
""")
    options = ["--python", sys.executable, "--published", robot]
    expected = output(mmsim, "trial", folder, *options, "--published", robot, "90")
    rows = mm.trial(folder, published={"a": robot, "b": [robot, "90"]}, python=sys.executable)

    assert sorted(row["error"] for row in rows) == sorted(row["error"] for row in expected)
    words = {"a": "['maze.txt']", "b": "['maze.txt', '90']"}
    assert len(rows) == 8 and all(row["error"].endswith(words[row["row"]]) for row in rows)
    [row] = mm.trial("01-harbour", published=robot)
    assert row["mouse"] == "my robot.py" and row["error"].endswith("16 ['maze.txt']")
    rows = mm.trial("01-harbour", published=[robot, robot])
    assert [row["mouse"] for row in rows] == ["my robot.py", "my robot.py (2)"]
    assert mm.trial("01-harbour", published=[]) == []
    with pytest.raises(ValueError, match="expected files in published"):
        mm.trial("01-harbour", python=sys.executable)
    with pytest.raises(FileNotFoundError, match="missing.py is not a file"):
        mm.trial("01-harbour", published="missing.py")
    with pytest.raises(ValueError, match="expected a file"):
        mm.trial("01-harbour", published={"mine": []})


def test_a_program_is_a_mouse_or_a_robot(tmp_path: Path) -> None:
    program = tmp_path / "mouse.py"
    program.write_text("raise SystemExit('no idea')")
    command = f"'{sys.executable}' '{program}'"
    [row] = mm.compare("01-harbour", {"mine": command})
    assert (row["mouse"], row["ending"], row["states"]) == ("mine", "failed", 0)
    assert row["error"].endswith("no idea")
    [row] = mm.trial("01-harbour", {"mine": command})
    assert (row["mouse"], row["ending"]) == ("mine", "failed") and "no idea" in row["error"]
    with pytest.raises(FileNotFoundError, match="missing does not exist"):
        mm.compare("01-harbour", {"mine": str(tmp_path / "missing")})


@pytest.mark.skipif(sys.platform != "linux", reason="Other systems let some processes escape.")
def test_no_program_outlives_a_killed_process(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    mouse = f"sh -c 'exec 9>{pipe}; echo >&9; setsid sleep 1000 & sleep 1000'"
    program = "import micromouse_sim as mm, sys; mm.compare('01', {'m': sys.argv[1]}, time_limit=1e3)"
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with subprocess.Popen([sys.executable, "-c", program, mouse]) as process:
        assert select.select([reader], [], [], LIMIT)[0] and os.read(reader, 1) == b"\n"
        process.kill()
    # The pipe ends when no process of the mouse is left.
    assert select.select([reader], [], [], LIMIT)[0] and os.read(reader, 1) == b""
    os.close(reader)


def test_a_function_has_the_figures_of_the_states_it_reports() -> None:
    mice = {"mine": flood_fill.search, "bundled": "flood-fill"}
    mazes: list[mm.Maze | str] = ["01-harbour", mm.Maze.generate(1), mm.Maze.generate(2, (9, 7))]
    rows = mm.compare(mazes, mice, vehicle="expert")
    assert [row["mouse"] for row in rows] == ["mine", "bundled"] * 3
    for mine, bundled in zip(rows[::2], rows[1::2]):
        assert bundled["processor_time_us"] > 0
        own = {"mouse": "mine", "processor_time_us": None, "crashes": None}
        assert mine == {**bundled, **own}
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
        for key in ("steps_to_goal", "search_steps", "search_turns", "path_found", "fast_run_steps",
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
    (tmp_path / "bad.txt").write_text("o---o\n| S \no---o\n")
    with pytest.warns(UserWarning, match="skipped .*bad.txt: line 2") as warned:
        assert [row["maze"] for row in mm.compare(tmp_path, "left-wall")] == ["good"]
        mm.trial(tmp_path, "swing")
    assert [warning.filename for warning in warned] == [__file__] * 2
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
