import subprocess
import sys
from importlib.metadata import metadata, version

import micromouse_sim as mm


def test_numpy_is_imported_with_the_first_array() -> None:
    program = (
        "import sys, micromouse_sim as mm; simulator = mm.Simulator(mm.Maze.bundled('01'));"
        "simulator.state(0, 0, 'N', [[1] * 16] * 16, simulator.unexplored());"
        "assert 'numpy' not in sys.modules; simulator.maze.distances();"
        "assert 'numpy' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


def test_every_public_name_is_exported_and_documented() -> None:
    assert mm.__all__ == sorted(mm.__all__, key=lambda name: (not name.isupper(), name))
    for name in mm.__all__:
        assert hasattr(mm, name)


def test_the_command_has_the_version_of_the_package(mmsim: str) -> None:
    output = subprocess.run([mmsim, "--version"], capture_output=True, check=True, timeout=60).stdout
    assert output.split()[:2] == [b"mmsim", version("micromouse-sim").encode()]
    assert metadata("micromouse-sim")["License-Expression"] == "MIT OR Apache-2.0"
