import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path
from importlib.metadata import metadata, version

import pytest
from conftest import LIMIT

import micromouse_sim as mm
from micromouse_sim import _native


def test_numpy_is_imported_with_the_first_array() -> None:
    program = (
        "import sys, micromouse_sim as mm; simulator = mm.Simulator(mm.Maze.bundled('01'));"
        "simulator.state(0, 0, 'N', [[1] * 16] * 16, simulator.unexplored());"
        "assert 'numpy' not in sys.modules; simulator.maze.distances();"
        "assert 'numpy' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=LIMIT)


def test_help_shows_the_documentation_of_the_stubs() -> None:
    stubs = ast.parse((Path(mm.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))
    compared = 0
    for node in stubs.body:
        if isinstance(node, ast.ClassDef):
            assert ast.get_docstring(node) == inspect.getdoc(getattr(_native, node.name))
        for member in ast.walk(node):
            if not isinstance(member, ast.FunctionDef) or member.name.startswith("_"):
                continue
            owner = getattr(_native, node.name) if isinstance(node, ast.ClassDef) else _native
            if expected := ast.get_docstring(member):
                assert expected == inspect.getdoc(getattr(owner, member.name)), member.name
                compared += 1
    assert compared > 80


def test_every_public_name_is_documented() -> None:
    for name in set(mm.__all__) - {"ROBOTS", "STRATEGIES"}:
        assert getattr(mm, name).__doc__, name


def test_the_code_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("gymnasium")
    monkeypatch.chdir(tmp_path)
    readme = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
    [mouse, table, gym] = re.findall("```python\n(.*?)```", readme, re.DOTALL)
    assert len([line for line in mouse.splitlines() if line.strip()]) <= 15
    names: dict[str, object] = {}
    exec(mouse, names)
    exec(table, names)
    exec(gym, names)
    states = mm.search(mm.Maze.bundled("01-harbour")).states
    assert list(names["simulator"].history) == list(states)  # type: ignore[attr-defined]
    assert names["steps"] == len(states) - 1


def test_the_command_has_the_version_of_the_package(mmsim: str) -> None:
    for command in ([mmsim], [sys.executable, "-m", "micromouse_sim"]):
        command += ["--version"]
        output = subprocess.run(command, capture_output=True, check=True, timeout=LIMIT).stdout
        assert output.split()[:2] == [b"mmsim", version("micromouse-sim").encode()]
    assert metadata("micromouse-sim")["License-Expression"] == "MIT OR Apache-2.0"
