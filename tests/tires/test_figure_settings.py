"""Settings of matplotlib, of the working folder or of a program, change no figure and run nothing."""

from __future__ import annotations

import ast
import os
import subprocess
import sys

import pytest
from matplotlib import rc_context

from tirefmu import draw
from tirefmu.tires import published

from ..rooms import ROOMS, ROOT

OWN = ROOT / "drawing" / "own_matplotlib.py"
HOSTILE = {
    "LaTeX and sizes": b"text.usetex: True\ntext.latex.preamble: \\immediate\\write18{touch ran} \\notacommand\n"
    b"font.size: 40\nfigure.dpi: 1000\nsavefig.transparent: True\n",
    "bytes": b"\xff\xfe\x00",
}


def drawn(folder, settings=None):
    """Draw a tire by the command line in a folder, with fewer pixels, and return the files."""
    folder.mkdir()
    if settings is not None:
        (folder / "matplotlibrc").write_bytes(settings)
    main = (
        "from tirefmu.commands.cli import main; from tirefmu.tires.drawing import files; files.DPI = 40; exit(main())"
    )
    command = [sys.executable, "-c", main, "draw", "trento_hoosier", "--loads", "900", "-o", "out"]
    subprocess.run(command, cwd=folder, env={**os.environ}, check=True, capture_output=True)
    return {path.name: path.read_bytes() for path in (folder / "out").iterdir()}


@pytest.mark.slow
def test_settings_of_the_working_folder_are_not_read(tmp_path):
    plain = drawn(tmp_path / "plain")
    for name, settings in HOSTILE.items():
        assert drawn(tmp_path / name, settings) == plain
        assert sorted(path.name for path in (tmp_path / name).iterdir()) == ["matplotlibrc", "out"]


@pytest.mark.usefixtures("drawn_figures")
def test_settings_of_a_program_do_not_change_files(tmp_path):
    tire = published("trento_hoosier")
    plain = [path.read_bytes() for path in draw(tire, tmp_path / "plain", loads=[900.0])]
    with rc_context({"text.usetex": True, "text.latex.preamble": r"\notacommand", "font.size": 40.0}):
        assert [path.read_bytes() for path in draw(tire, tmp_path / "own", loads=[900.0])] == plain


@pytest.fixture(scope="module")
def modules():
    """Return the syntax trees of the modules of the packages that have to do with matplotlib, by path."""
    paths = [path for room in ROOMS for path in (ROOT / room).rglob("*.py") if "generated" not in path.parts]
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    return {path: ast.parse(text) for path, text in texts.items() if "matplotlib" in text}


def test_one_module_imports_matplotlib(modules):
    importers = {
        path
        for path, tree in modules.items()
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in (getattr(node, "module", None), *(alias.name for alias in node.names))
        if name and name.split(".")[0] == "matplotlib"
    }
    assert importers == {OWN}


def test_every_function_that_makes_or_renders_a_figure_has_the_own_settings(modules):
    makers = [
        (path.name, node)
        for path, tree in modules.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and {"MatplotlibFigure(", ".savefig("} & set(called(node))
    ]
    assert [node.name for _, node in makers] == ["picture", "rendered", "surfaces"]
    assert [
        (name, node.name) for name, node in makers if "own_settings()" not in map(ast.unparse, node.decorator_list)
    ] == []


def called(function):
    """Yield the names of the functions that a function calls itself, each with a bracket."""
    for node in ast.walk(function):
        if isinstance(node, ast.Call):
            yield f".{node.func.attr}(" if isinstance(node.func, ast.Attribute) else f"{ast.unparse(node.func)}("
