"""Runs the example notebook from top to bottom."""
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOK = Path(__file__).parent.parent / "examples" / "tour.ipynb"


def outputs(notebook: Any, kind: str) -> list[str]:
    """Returns all outputs of this MIME type."""
    cells = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    return [output["data"][kind] for output in cells if kind in output.get("data", {})]


def test_the_notebook_runs_and_draws(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    pictures = outputs(notebook, "image/svg+xml")
    assert len(pictures) >= 5 and all(svg.startswith("<svg ") for svg in pictures)
    pages = outputs(notebook, "text/html")
    assert any("<script>" in page for page in pages), "the search is an animation"
    assert any("shortest-path-search" in page for page in pages), "pandas shows the table"
