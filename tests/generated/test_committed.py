"""The files in generated/ equal the generated code of the book, to the byte."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tirefmu.generated
from tirefmu.symbolic.added import library
from tirefmu.symbolic.models import MODELS, WITH_EFFECTS
from tirefmu.symbolic.printers import generate
from tirefmu.symbolic.printers.generate import difference, files_on_demand, render, render_model, write
from tirefmu.tires.code.build_cache import RECORD
from tirefmu.tires.code.printed import code_file, printed_folder

COMMITTED = Path(tirefmu.generated.__file__).parent
PROGRAM = """
import sys
from tirefmu.symbolic.models import model_named
from tirefmu.symbolic.printers.generate import render_model
sys.stdout.buffer.write("".join(f"{name}:{text}" for name, text in render_model(model_named("mf96")).items()).encode())
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


@pytest.mark.slow
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
    assert shown[:2] == ["--- generated/c/mf96.c", "+++ the equations: c/mf96.c"]
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


@pytest.mark.parametrize("name", ["numpy/mf96.py", "c/mf96.h", "structure/mf96.json", "MANIFEST.json"])
def test_a_missing_file_is_detected_and_written(copy, name):
    (copy / name).unlink()
    assert f"generated/{name}" in difference(copy)
    assert write(copy) == [copy / name]


@pytest.mark.parametrize(
    "name",
    [
        "numpy/mf95.py",
        "numpy/mf96_jacobians.py",
        "c/mf95.c",
        "c/mf95.h",
        "structure/mf95.json",
        "with_effects/c/mf95.c",
    ],
)
def test_a_file_that_is_not_made_is_detected_and_removed(copy, name):
    (copy / name).parent.mkdir(parents=True, exist_ok=True)
    (copy / name).write_text("outdated\n", encoding="ascii")
    assert f"generated/{name}" in difference(copy)
    assert write(copy) == [copy / name]
    assert not (copy / name).exists()


@pytest.mark.slow
def test_the_text_does_not_depend_on_the_hash_seed():
    """Check the smallest model under two seeds; what is committed is compared in this process, with a random one."""

    def printed(seed):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        return subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, check=True).stdout

    files = render_model(MODELS["mf96"])
    assert printed("1") == printed("2") == "".join(f"{name}:{text}" for name, text in files.items()).encode()


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
print(before)
"""


def test_forces_do_not_import_the_jacobians():
    done = subprocess.run([sys.executable, "-c", FORCES], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_jacobians_and_effects_are_not_committed():
    """They are printed when a wheel is built, or at their first use: adding an effect changes one TOML file."""
    names = render().keys()
    assert not [name for name in names if "_jacobian" in name or name.startswith(WITH_EFFECTS)]
    assert names >= {f"{folder}/{model}{ending}" for model in MODELS for folder, ending in
                     (("numpy", ".py"), ("c", ".c"), ("c", "_operations.h"), ("structure", ".json"))}  # fmt: skip


def test_everything_has_the_jacobians_and_the_library(monkeypatch, tmp_path):
    monkeypatch.setattr(generate, "packaged_models", lambda: {"fiala": MODELS["fiala"]})
    write(tmp_path, everything=True)
    whole = made_files(tmp_path)
    assert whole >= {name for file in files_on_demand("fiala") for name in (file, f"{WITH_EFFECTS}/{file}")}
    manifest = json.loads((tmp_path / "MANIFEST.json").read_text(encoding="ascii"))
    assert manifest["files"].keys() == whole - {"MANIFEST.json"}
    assert manifest[WITH_EFFECTS].keys() == {"fiala"}
    assert (tmp_path / "c" / "fiala.c").read_bytes() == (COMMITTED / "c" / "fiala.c").read_bytes()
    write(tmp_path)
    assert made_files(tmp_path) < whole


@pytest.mark.parametrize("file", files_on_demand("fiala"))
def test_what_is_not_committed_is_printed_at_its_first_use(file):
    path = code_file(MODELS["fiala"], file)
    assert COMMITTED not in path.parents
    assert path.read_text(encoding="ascii") == render_model(MODELS["fiala"])[file]
    assert code_file(MODELS["fiala"], "c/fiala.c") == COMMITTED / "c" / "fiala.c"


def test_jacobians_are_printed_when_they_are_asked_for(monkeypatch, tmp_path):
    """Most of the text, which an evaluation does not need. Their C code finds its header beside it."""
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path))
    model = MODELS["fiala"].extended([library()["temp_friction"]])
    values, jacobians = (made_files(printed_folder(model, jacobians=each)) - {RECORD} for each in (False, True))
    assert not [name for name in values if "jacobian" in name]
    assert values & jacobians == {"c/fiala.h"}
    assert {name for name in values | jacobians if not name.endswith(".pyc")} == render_model(model).keys()
