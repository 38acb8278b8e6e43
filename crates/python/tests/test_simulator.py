import threading
from pathlib import Path
from typing import Callable

import numpy as np
import pytest

import micromouse_sim as mm

MAZE = mm.Maze.parse("o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n", "small")
FLAGS = [[13, 26], [6, 26]]


def test_states_are_kept_until_reset() -> None:
    simulator = mm.Simulator(MAZE)
    simulator.ping()
    history = simulator.history
    for x in range(2):
        simulator.state(x, 0, "E", [[x, 300], [1, 0]], FLAGS)
    assert len(history) == 2 and repr(simulator) == '<Simulator of "small", 2 states>'
    state = history[-1]
    assert state.bytes == b"S\x01\x00EF\x01\xff\x01\x00F\x0d\x1a\x06\x1a"
    assert (state.index, state.pose) == (1, mm.Pose(1, 0, mm.Heading.EAST))
    assert state.weights.tolist() == [[1, 255], [1, 0]] and state.walls.tolist() == FLAGS
    assert state.known.wall(0, 0, "E") is False and "<svg" in state._repr_svg_()
    assert [one.index for one in history] == [0, 1] == [one.index for one in history[-9:9]]
    assert [one.index for one in history[::-1]] == [1, 0] and history[5:] == []
    with pytest.raises(IndexError, match="state 2 out of range, the history has 2"):
        history[2]
    with pytest.raises(IndexError):
        history[-3]
    simulator.reset()
    assert len(history) == 0 and state.index == 1


def test_the_same_state_can_be_given_in_many_ways() -> None:
    simulator = mm.Simulator(MAZE)
    known = simulator.unexplored()
    known.observe(0, 0, "N", simulator.walls(0, 0, "N"))
    weights = MAZE.distances()
    for given in (weights, weights.astype(np.uint8), weights.astype(np.int64), weights.tolist(),
                  weights.astype(np.int16), tuple(map(tuple, weights.tolist())),
                  np.asfortranarray(weights), np.repeat(weights, 2, axis=1)[:, ::2], list(weights)):
        for walls in (known, known.walls, known.walls.tolist()):
            simulator.state(np.int64(0), 0, mm.Heading.NORTH, given, walls)  # type: ignore[arg-type]
    assert len({state.bytes for state in simulator.history}) == 1
    assert simulator.history[0].weights.tolist() == weights.tolist()


def test_requests_have_the_replies_of_a_server() -> None:
    simulator = mm.Simulator(MAZE)
    assert simulator.request(b"ping") == b"pong"
    assert simulator.request(b"W\x00\x00N") == b"\x01\x00\x00"
    assert simulator.request(b"rubbish").startswith(b"error: expected ")
    with pytest.raises(mm.Refused, match=r"refused W: expected a cell in a maze of 2x2 cells"):
        simulator.walls(2, 0, "N")
    with pytest.raises(ValueError, match="expected a coordinate from 0 to 255, found 256"):
        simulator.walls(256, 0, "N")
    with pytest.raises(ValueError, match='expected N, E, S or W, found "north"'):
        simulator.walls(0, 0, "north")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected a heading, found int"):
        simulator.walls(0, 0, 1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="expected a grid of 2x2 cells, found 1x4"):
        simulator.state(0, 0, "N", [[1, 2, 3, 4]], FLAGS)
    with pytest.raises(ValueError, match="columns of a grid must have the same length"):
        simulator.state(0, 0, "N", [[1, 2], [3]], FLAGS)
    with pytest.raises(ValueError, match="integers of at least 0"):
        simulator.state(0, 0, "N", [[1, 2], [3, -1]], FLAGS)
    with pytest.raises(ValueError, match="integers of at least 0"):
        simulator.state(0, 0, "N", np.array([[1, 2], [3, -1]]), FLAGS)
    with pytest.raises(TypeError):
        simulator.state(0, 0, "N", [[1, 2], [3, 0.5]], FLAGS)  # type: ignore[list-item]
    with pytest.raises(mm.Refused, match="refused S: "):
        simulator.state(0, 9, "N", [[1, 2], [3, 4]], FLAGS)
    assert len(simulator.history) == 0


def test_annotations_belong_to_the_next_state(tmp_path: Path) -> None:
    simulator = mm.Simulator(MAZE)
    simulator.name("Theseus", "thread")
    simulator.text(0, 1, 42)
    simulator.colour(1, 1, "G")
    simulator.wall(0, 0, "N", "?")
    simulator.log("a line\nanother\x1b line\n" + "é" * 2000)
    simulator.restart()
    simulator.clear_texts()
    simulator.clear_colours()
    simulator.clear_walls()
    simulator.state(0, 0, "N", [[0, 0], [0, 0]], FLAGS)
    simulator.save(tmp_path / "run.mcap")
    assert b"Theseus" in (tmp_path / "run.mcap").read_bytes()
    simulator.text(5, 5, "lost")
    with pytest.raises(mm.Refused, match="refused A: "):
        simulator.state(0, 0, "N", [[0, 0], [0, 0]], FLAGS)
    simulator.state(0, 0, "N", [[0, 0], [0, 0]], FLAGS)
    assert len(simulator.history) == 2
    for fault in (lambda: simulator.text(0, 0, "x" * 11), lambda: simulator.colour(0, 0, "x"),
                  lambda: simulator.wall(0, 0, "N", "2"),  # type: ignore[arg-type]
                  lambda: simulator.name("x" * 101)):
        with pytest.raises(ValueError):
            fault()  # type: ignore[no-untyped-call]


def test_recordings_contain_the_maze_and_the_states(tmp_path: Path) -> None:
    path, simulator = tmp_path / "run.mcap", mm.Simulator(mm.Maze.bundled("half-size"))
    search = mm.search(simulator, "shortest-path-search")
    assert len(simulator.history) > 512, "several blocks"
    simulator.save(path)
    recording = mm.load_recording(path)
    assert recording.maze == simulator.maze and recording.is_complete
    assert recording.info["states"] == len(recording.states) == len(search.states)
    assert list(recording.states) == list(simulator.history) == list(search.states)
    path.write_bytes(b"no recording")
    with pytest.raises(mm.RecordingError, match="expected a recording"):
        mm.load_recording(path)
    with pytest.raises(FileNotFoundError, match="missing"):
        mm.load_recording(tmp_path / "missing")


def test_the_annotations_after_the_last_state_are_kept(tmp_path: Path) -> None:
    path, simulator = tmp_path / "run.mcap", mm.Simulator(MAZE)
    simulator.log("first")
    simulator.state(0, 0, "N", FLAGS, FLAGS)
    simulator.log("RESULT")
    simulator.text(0, 1, "end")
    simulator.colour(1, 0, "g")
    simulator.save(path)
    for history in (simulator.history, mm.load_recording(path).states):
        assert history.log == [(0, "first"), (1, "RESULT")]
        assert history.texts == {(0, 1): "end"} and history.colours == {(1, 0): "g"}


def test_a_simulator_may_limit_the_number_of_states() -> None:
    simulator = mm.Simulator(MAZE, max_states=2)
    for _ in range(2):
        simulator.state(0, 0, "N", FLAGS, FLAGS)
    with pytest.raises(mm.Refused, match="limit of 2 states reached"):
        simulator.state(0, 0, "N", FLAGS, FLAGS)
    simulator.reset()
    simulator.state(0, 0, "N", FLAGS, FLAGS)


def test_threads_can_share_a_simulator() -> None:
    simulator, known = mm.Simulator(MAZE), mm.KnownMaze.unexplored(MAZE)

    def drive() -> None:
        for _ in range(300):
            known.observe(0, 0, "N", simulator.walls(0, 0, "N"))
            simulator.state(0, 0, "N", known.distances(), known)

    threads = [threading.Thread(target=drive) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert len(simulator.history) == 1200


def test_invalid_grids_are_named_in_the_message() -> None:
    simulator = mm.Simulator(mm.Maze.bundled("01"))
    known = simulator.unexplored()
    for weights, message in [
        (np.zeros((16, 16)), "weights to be integers, found float64"),
        ([1], "weights to be a list of columns, found int"),
        (None, "weights to be an array, found NoneType"),
    ]:
        with pytest.raises(TypeError, match=message):
            simulator.state(0, 0, "N", weights, known)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="walls to be an array, found Maze"):
        simulator.state(0, 0, "N", [[0] * 16] * 16, simulator.maze)  # type: ignore[arg-type]


def test_arrays_of_any_layout_are_read_correctly() -> None:
    simulator = mm.Simulator(mm.Maze.bundled("01"))
    weights = np.arange(256, dtype=np.uint16).reshape(16, 16)
    packed = np.zeros((16, 16), dtype=[("seen", "u1"), ("weight", "<u2")])
    packed["weight"] = weights
    wide = np.zeros((32, 32), np.uint16)
    wide[::2, ::2] = weights
    for grid in (packed["weight"], wide[::2, ::2], np.asfortranarray(weights), weights.tolist()):
        simulator.state(0, 0, "N", grid, simulator.unexplored())
        assert np.array_equal(simulator.history[-1].weights, weights)
    assert len(simulator.history[1 :: 2**63 - 1]) == 1


def test_invalid_limits_are_refused() -> None:
    maze = mm.Maze.bundled("01")
    calls: list[Callable[[], object]] = [
        lambda: mm.search(maze, max_states=-1),
        lambda: mm.compare(maze, max_states=-1),
        lambda: mm.Simulator(maze, max_states=-1),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="expected a limit from 0 to 4294967295, found -1"):
            call()
    for mice in (lambda _: None, [lambda _: None], {"a": 5}):
        with pytest.raises(TypeError):
            mm.compare(maze, mice)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="unknown format of maze.unknown"):
        maze.save("maze.unknown")
