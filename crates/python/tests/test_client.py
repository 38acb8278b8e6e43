import subprocess
import sys
import threading
from pathlib import Path

import pytest
from conftest import LIMIT, Serve

import micromouse_sim as mm


def test_a_client_has_the_methods_of_a_simulator(serve: Serve) -> None:
    maze = mm.Maze.bundled("01")
    with serve("01-harbour") as server, mm.Client(server["address"], annotations=True) as client:
        simulator = mm.Simulator(maze)
        assert client.start == simulator.start and client.unexplored() == simulator.unexplored()
        assert client.endpoint == server["address"] in repr(client)
        for connection in (client, simulator):
            connection.ping()
            connection.reset()
            known = connection.unexplored()
            known.observe(0, 0, "N", connection.walls(0, 0, "N"))
            connection.name("Theseus")
            connection.log("here")
            connection.state(0, 0, "N", known.distances(), known)
            messages = []
            for x in (99, 255):
                with pytest.raises(mm.Refused) as refused:
                    connection.walls(x, 0, "N")
                messages.append(str(refused.value))
            with pytest.raises(mm.Refused) as refused:
                connection.state(0, 99, "N", known.distances(), known)
            messages.append(str(refused.value))
            assert messages[0].startswith("the simulator refused W: expected a cell")
        assert client.request(b"info") == simulator.request(b"info")
        with pytest.raises(mm.Error, match="a client has no history"):
            client.history


def test_without_info_the_arguments_describe_the_maze() -> None:
    with mm.Client("tcp://127.0.0.1:1") as client:
        assert client.unexplored(size=(16, 16)) == mm.KnownMaze()
        assert client.unexplored(goals=[(3, 3)]).goals == ((3, 3),)


def test_a_missing_server_is_reported() -> None:
    with mm.Client("tcp://127.0.0.1:1", timeout=0.1) as client:
        for _ in range(2):
            with pytest.raises(mm.NoReply, match="no reply from tcp://127.0.0.1:1 within 0.1 s"):
                client.ping()
    with pytest.raises(mm.SimulatorError, match="cannot reach nowhere"):
        mm.Client("nowhere")
    for timeout in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="invalid timeout"):
            mm.Client(timeout=timeout)
    with pytest.raises(TypeError, match="expected a timeout in seconds, or None"):
        mm.Client(timeout="soon")  # type: ignore[arg-type]


def test_mmsim_run_sets_the_endpoint(serve: Serve, monkeypatch: pytest.MonkeyPatch) -> None:
    assert mm.Client().endpoint == "tcp://127.0.0.1:6574"
    with serve("01-harbour") as server:
        monkeypatch.setenv("MMSIM_ENDPOINT", server["address"])
        mm.Client().ping()


def test_a_client_works_after_it_was_closed_and_in_other_threads(serve: Serve) -> None:
    with serve("01-harbour") as server:
        client = mm.Client(server["address"], timeout=LIMIT)
        client.close()
        client.ping()
        readings: list[mm.Walls] = []

        def read() -> None:
            readings.extend(client.walls(0, 0, "N") for _ in range(20))

        threads = [threading.Thread(target=read) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(LIMIT)
        assert readings == [mm.Walls(True, False, True)] * 80


CLIENT = "mm.Client(sys.argv[1], annotations=True)"
CALLS = "client.state(0, 0, 'N', [[0] * 16] * 16, client.unexplored()); client.log('RESULT')"


@pytest.mark.parametrize(
    "program",
    [
        f"client = {CLIENT}; {CALLS}; client.close()",
        f"with {CLIENT} as client: {CALLS}",
        f"client = {CLIENT}; {CALLS}",
        f"def search(client): {CALLS}\nsearch({CLIENT})",
    ],
)
def test_the_annotations_after_the_last_state_are_sent(program: str, serve: Serve, tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    with serve("01-harbour", "--record", str(folder)) as server:
        command = [sys.executable, "-c", f"import sys, micromouse_sim as mm\n{program}", server["address"]]
        subprocess.run(command, check=True, timeout=LIMIT)
    (path,) = folder.glob("*.mcap")
    assert mm.load_recording(path).states.log == [(1, "RESULT")]
