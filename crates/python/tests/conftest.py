"""The `mmsim` command of the wheel, and servers on free ports."""
import json
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, ContextManager, Iterator

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "examples"))

# The time limit in seconds for everything that should end soon.
LIMIT = 300.0

Serve = Callable[..., ContextManager[dict[str, Any]]]


@pytest.fixture(scope="session")
def mmsim() -> str:
    """The path of the command that the wheel has installed."""
    folder = Path(sys.executable).parent
    path = folder / ("mmsim.exe" if os.name == "nt" else "mmsim")
    assert path.is_file(), f"the wheel has not installed {path}"
    return str(path)


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Hides the mazes and the endpoint of the user, and keeps files out of the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    monkeypatch.delenv("MMSIM_ENDPOINT", raising=False)


@pytest.fixture
def serve(mmsim: str) -> Serve:
    """Starts a server. Its first line describes it."""

    @contextmanager
    def start(maze: str, *options: str) -> Iterator[dict[str, Any]]:
        command = [mmsim, "--port", "0", "--no-viewer", "--json", maze, *options]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            try:
                yield json.loads(process.stdout.readline())
            finally:
                process.terminate()
                process.wait(LIMIT)

    return start
