import json
import signal
import subprocess
import sys
from pathlib import Path

import flood_fill
import pytest
from conftest import LIMIT, Serve

import micromouse_sim as mm


def solve(mmsim: str, endpoint: str, file: Path) -> list[bytes]:
    """Returns the states of `mmsim solve flood-fill`."""
    command = [mmsim, "solve", "flood-fill", "--goal", "server", "--connect", endpoint]
    subprocess.run([*command, "--record", str(file)], check=True, timeout=LIMIT)
    return [state.bytes for state in mm.load_recording(file).states]


@pytest.mark.parametrize("name", ["01-harbour", "half-size-old-quarter"])
def test_the_same_states_as_the_command(
    name: str, mmsim: str, serve: Serve, tmp_path: Path
) -> None:
    maze = mm.Maze.bundled(name)
    with serve(name) as server:
        expected = solve(mmsim, server["address"], tmp_path / "solve.mcap")
    assert [state.bytes for state in mm.search(maze).states] == expected
    simulator = mm.Simulator(maze)
    assert flood_fill.search(simulator)
    assert [state.bytes for state in simulator.history] == expected


def test_the_example_sends_the_same_states_to_a_server(
    serve: Serve, mmsim: str, tmp_path: Path
) -> None:
    with serve("01-harbour", "--record", str(tmp_path)) as server:
        with mm.Client(server["address"]) as client:
            assert flood_fill.search(client)
    with serve("01-harbour") as server:
        expected = solve(mmsim, server["address"], tmp_path / "solve")
    [file] = tmp_path.glob("*.mcap")
    assert [state.bytes for state in mm.load_recording(file).states] == expected


def test_the_example_runs_as_a_program(mmsim: str, tmp_path: Path) -> None:
    program = str(Path(flood_fill.__file__))
    alone = subprocess.run([sys.executable, program], capture_output=True, timeout=LIMIT, check=True)
    assert alone.stdout == b"goal reached\n"
    command = [mmsim, "run", "--port", "0", "--no-viewer", "--maze", "01-harbour", "--record"]
    command += [str(tmp_path), "--", sys.executable, program]
    subprocess.run(command, check=True, capture_output=True, timeout=LIMIT)
    [file] = tmp_path.glob("*.mcap")
    expected = mm.search(mm.Maze.bundled("01-harbour")).states
    assert list(mm.load_recording(file).states) == list(expected)


def test_an_unreachable_goal_ends_a_search_with_an_error() -> None:
    maze = mm.Maze.bundled("unreachable")
    search, simulator = mm.search(maze), mm.Simulator(maze)
    assert not search.goal_reached and search.error == "goal unreachable from (4, 5)"
    assert not flood_fill.search(simulator)
    assert list(simulator.history) == list(search.states)


def test_a_search_has_figures() -> None:
    search = mm.search(mm.Maze.bundled("01"), "shortest-path-search")
    phases = search.phases
    assert search.goal_reached and search.proven and search.path_found == 52
    total = phases["total"]
    assert (total["steps"], total["turns"]) == (search.steps, search.turns)
    runs = [phases[name] for name in ("search_run", "return_run", "fast_run")]
    for key in total:
        assert sum(run[key] for run in runs) == pytest.approx(total[key])
    assert search.steps_to_goal == phases["search_run"]["steps"]
    assert len(search.states) == search.steps + 1 and search.visited_cells == len(search.known.visited)
    assert search.requests == 2 * len(search.states) + 1
    limited = mm.search(mm.Maze.bundled("01"), max_states=10)
    assert len(limited.states) == 10 and not limited.goal_reached


def test_faulty_searches_are_refused() -> None:
    with pytest.raises(ValueError, match="expected one of flood-fill"):
        mm.search(mm.Maze.bundled("01"), "luck")
    with pytest.raises(TypeError, match="expected a Maze or a Simulator, found str"):
        mm.search("01")  # type: ignore[arg-type]
    with pytest.raises(mm.Refused, match="limit of 3 states"):
        mm.search(mm.Simulator(mm.Maze.bundled("01"), max_states=3))
    with pytest.raises(mm.Error, match="no states"):
        mm.search(mm.Maze.bundled("01"), max_states=0)._repr_html_()


def test_the_animation_is_small_and_needs_no_other_file() -> None:
    search = mm.search(mm.Maze.bundled("01"), "shortest-path-search")
    pages = [search._repr_html_() for _ in range(2)]
    identifiers = {page.split('"')[1] for page in pages}
    assert len(identifiers) == 2, "a page may contain several animations"
    for page in pages:
        assert len(page) < 100_000
        assert page.count("<script>") == 1 and " src=\"http" not in page and "import" not in page
    _, arguments = pages[0].split("(document.getElementById", 1)
    data = json.loads(arguments.split(", ", 1)[1].rsplit(");", 1)[0])
    assert replay(data) == [
        (state.pose.cell, state.pose.heading.value, state.weights.T.tolist(), state.walls.T.tolist())
        for state in search.states
    ]


def replay(data: dict) -> list:  # type: ignore[type-arg]
    """Decodes the states of an animation as its script does."""
    width, height, poses = data["width"], data["height"], data["poses"]
    cells, states = [[0, 0] for _ in range(width * height)], []
    for index, changes in enumerate(data["changes"]):
        for at in range(0, len(changes), 6):
            cell, *numbers = (int(changes[at + i : at + i + 2], 36) for i in (0, 2, 4))
            cells[cell] = numbers
        cell = int(poses[3 * index : 3 * index + 2], 36)
        grids = [
            [[cells[y * width + x][layer] for x in range(width)] for y in range(height)]
            for layer in range(2)
        ]
        states.append(((cell % width, cell // width), poses[3 * index + 2], *grids))
    return states


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize(
    "call",
    [
        "mm.Client('tcp://127.0.0.1:1', timeout=None).ping()",
        "[mm.compare(mice=['fastest-path-search']) for _ in range(1000)]",
        "mm.compare('01', {'mine': 'sleep 1000'}, time_limit=900.0)",
        "[mm.trial(robots=mm.ROBOTS) for _ in range(1000)]",
        "mm.trial('01', {'mine': 'sleep 1000'}, answer_limit=900.0)",
        "[mm.search(mm.Maze.bundled('half'), 'fastest-path-search') for _ in range(10000)]",
    ],
)
def test_ctrl_c_interrupts(call: str) -> None:
    program = f"import micromouse_sim as mm; print('ready', flush=True); {call}"
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LIMIT)
    assert errors.splitlines()[-1] == b"KeyboardInterrupt"


def test_the_vehicle_times_a_search(tmp_path: Path) -> None:
    maze = mm.Maze.parse("o---o---o---o---o\n| S           G |\no---o---o---o---o\n")
    slow = tmp_path / "slow.toml"
    slow.write_text("base = 'expert'\nsearch_speed = 180\nsearch_turn_time = 0.5\n")
    # crates/cli/tests/clock.rs expects the same seconds of the commands and the page.
    for vehicle, times in [
        (None, [1.1, 1.3, 0.3991, 2.7991]),
        (str(slow), [3.5, 4.0, 0.3991, 7.8991]),
    ]:
        search = mm.search(maze, "shortest-path-search", vehicle=vehicle)
        assert [run["time_s"] for run in search.phases.values()] == times
        assert search.known_run_time_s == 0.3991 and search.fastest_run_proven
    assert mm.search(maze).vehicle == "expert"
