"""The notebooks of the tutorials run in a Jupyter kernel (test_documentation.py: their blocks without)."""

from __future__ import annotations

import os
import re
import runpy
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(f"tutorials/{path.name}" for path in (DOCS / "tutorials").glob("*.md"))

pytestmark = pytest.mark.skipif("TIREFMU_NOTEBOOKS" not in os.environ, reason="starts kernels: make docs")


def checked(source):
    """Return the source of a cell with the exit code of each command checked: IPython itself ignores it."""
    if not source.startswith("!"):
        return source
    lines = []
    for line in source.splitlines():
        codes = {int(code) for code in re.findall(r"\d", line.partition("#")[2])} or {0}
        lines += [line, f"assert _exit_code in {codes}, _exit_code"]
    return "\n".join(lines)


def executed(notebook, folder):
    """Return a notebook with the outputs of its cells; an error of a cell is raised."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["source"] = checked(cell["source"])
    read = nbformat.from_dict(notebook)
    client = nbclient.NotebookClient(read, timeout=600, resources={"metadata": {"path": str(folder)}})
    return client.execute()


@pytest.fixture(autouse=True)
def programs(monkeypatch):
    """Put the command tirefmu of this environment first."""
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.filterwarnings("default")  # of Jupyter's own packages
@pytest.mark.parametrize("page", PAGES)
def test_the_notebook_of_a_page_runs(page, tmp_path):
    make = runpy.run_path(str(DOCS / "reference_pages.py"))["notebook"]
    found = executed(make((DOCS / page).read_text(encoding="utf-8")), tmp_path)
    code = [cell for cell in found.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))


@pytest.mark.filterwarnings("default")
def test_a_command_that_fails_is_an_error_of_its_cell(tmp_path):
    error = pytest.importorskip("nbclient.exceptions").CellExecutionError
    cell = {"cell_type": "code", "execution_count": None, "id": "a", "metadata": {}, "outputs": []}
    notebook = {"cells": [{**cell, "source": "!tirefmu info missing.tir"}], "metadata": {}, "nbformat": 4}
    with pytest.raises(error, match=r"missing\.tir: no such file"):
        executed({**notebook, "nbformat_minor": 5}, tmp_path)
