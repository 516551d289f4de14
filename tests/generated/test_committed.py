"""The files in generated/ equal the generated code of the book, to the byte."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tirefmu.generated
from tirefmu.symbolic.models import WITH_EFFECTS
from tirefmu.symbolic.printers.generate import difference, render, write

COMMITTED = Path(tirefmu.generated.__file__).parent
PROGRAM = """
import sys
from tirefmu.symbolic.models import model
from tirefmu.symbolic.printers.generate import render_model
sys.stdout.buffer.write("".join(f"{name}:{text}" for name, text in render_model(model("mf96")).items()).encode())
"""


@pytest.fixture
def copy(tmp_path) -> Path:
    """Return a copy of the committed files."""
    return Path(shutil.copytree(COMMITTED, tmp_path / "generated", ignore=shutil.ignore_patterns("__pycache__")))


def made_files(folder: Path) -> set[str]:
    """Return the machine-made files of a folder; the packages' empty __init__.py are not."""
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "__init__.py" and "__pycache__" not in path.parts
    }


def test_the_committed_files_are_what_the_book_prints(tmp_path):
    write(tmp_path)
    assert made_files(tmp_path) == made_files(COMMITTED), 'run "make generate"'
    for name in sorted(made_files(tmp_path)):
        assert (tmp_path / name).read_bytes() == (COMMITTED / name).read_bytes(), f'{name}: run "make generate"'
    assert difference(COMMITTED) == ""


def test_writing_again_changes_nothing(copy):
    assert write(copy) == []


def test_a_manual_edit_is_detected(copy):
    path = copy / "c" / "mf96.c"
    path.write_text(path.read_text(encoding="ascii").replace("D_x*fast_sin", "D_x*fast_cos", 1), encoding="ascii")
    shown = difference(copy).splitlines()
    assert shown[:2] == ["--- generated/c/mf96.c", "+++ the book: c/mf96.c"]
    changed = [line for line in shown[2:] if line.startswith(("-", "+"))]
    assert [line[0] for line in changed] == ["-", "+"]
    assert "D_x*fast_cos" in changed[0]
    assert "D_x*fast_sin" in changed[1]
    assert write(copy) == [path]
    assert difference(copy) == ""


def test_other_line_endings_are_detected(copy):
    path = copy / "numpy" / "mf96.py"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert "generated/numpy/mf96.py" in difference(copy)


@pytest.mark.parametrize("name", ["numpy/mf96.py", "c/mf96.h", "casadi/mf96_jacobians.py", "with_effects/structure/mf96.json", "MANIFEST.json"])
def test_a_missing_file_is_detected_and_written(copy, name):
    (copy / name).unlink()
    assert f"generated/{name}" in difference(copy)
    assert write(copy) == [copy / name]


@pytest.mark.parametrize(
    "name",
    ["numpy/mf95.py", "casadi/mf95_jacobians.py", "c/mf95.c", "c/mf95.h", "structure/mf95.json", "with_effects/c/mf95.c"],
)
def test_a_file_without_a_model_is_detected_and_removed(copy, name):
    (copy / name).write_text("outdated\n", encoding="ascii")
    assert f"generated/{name}" in difference(copy)
    assert write(copy) == [copy / name]
    assert not (copy / name).exists()


def test_the_text_does_not_depend_on_the_hash_seed():
    """Check the smallest model under two seeds; this process has a random one when it compares all that is committed."""

    def printed(seed):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        return subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, check=True).stdout

    files = [(name, text) for name, text in render().items() if "mf96" in name and not name.startswith(WITH_EFFECTS)]
    assert printed("1") == printed("2") == "".join(f"{name}:{text}" for name, text in files).encode()


def test_every_file_states_its_source():
    for name, text in render().items():
        if name != "MANIFEST.json":
            assert 'Do not edit: run "make generate"' in text[:300].replace('\\"', '"'), name  # JSON escapes quotes
        assert text.endswith("\n")
        assert text.isascii()
        assert "\t" not in text
        assert not [line for line in text.splitlines() if line != line.rstrip()], name


FORCES = """
import sys
from tirefmu.tires import Tire
tire = Tire("fiala", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3})
tire.forces(alpha=0.1)
before = [name for name in sys.modules if name.endswith("_jacobians")]
from tirefmu.generated.numpy import fiala, fiala_jacobians
assert fiala.jacobian_inputs is fiala_jacobians.jacobian_inputs
assert not hasattr(fiala, "jacobian_of_nothing")
print(before)
"""


def test_forces_do_not_import_the_jacobians():
    done = subprocess.run([sys.executable, "-c", FORCES], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
