"""gcc, clang and cppcheck have no warning in the C sources of FMUs: some with gcc, with TIREFMU_WARNINGS all of them.

The sources are those that an export compiles. `make warnings` fails if one of the programs is missing.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from importlib.resources import files

import pytest

from tirefmu.applications.sti.export import export_sti
from tirefmu.fmu import export
from tirefmu.fmu.description.interface import INPUTS
from tirefmu.fmu.packaging import binaries
from tirefmu.fmu.packaging.export import fmi_headers
from tirefmu.fmu.packaging.model_code import model_files
from tirefmu.fmu.packaging.prebuilding import every_generic
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire

from ..relatives import slow_but

COMPLETE = "TIREFMU_WARNINGS" in os.environ
WARNINGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
#: gcc looks for variables without a value when it optimizes. cppcheck knows the macros of one system. The files serve
#: all models and inputs: for some a condition is constant, or a member of a vector is not used.
COMMANDS = {
    "gcc": ("gcc", *WARNINGS, "-O1", "-c", "-isystem"),
    "clang": ("clang", *WARNINGS, "-fsyntax-only", "-isystem"),
    "cppcheck": (
        "cppcheck", "--std=c99", "--quiet", "--error-exitcode=1", "--enable=warning,style,performance,portability",
        "--suppress=knownConditionTrueFalse", "--suppress=unusedStructMember", "-D__GNUC__=12", "-D__linux__=1", "-I",
    ),
}  # fmt: skip


@pytest.fixture
def exported(monkeypatch, tmp_path):
    """Return a function that exports and returns the sources that would be compiled."""
    taken = []
    monkeypatch.setattr(binaries, "binary", lambda sources, *_: taken.append(sources) or b"")

    def sources_of(function, tire, name="tire.fmu", **options):
        taken.clear()
        function(tire, tmp_path / name, **options)
        (sources,) = taken
        return sources

    return sources_of


def tires(model):
    """Return a tire with steady slip, and one with lagging slips, effects on demand and states of added effects."""
    symbolic_model, values = MODELS[model], {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    more = {*sorted(symbolic_model.relaxing_effects)[:1], *(effect for effect, _ in symbolic_model.on_demand)}
    effects = symbolic_model.default_effects | more | {"heat_friction", "slip_history"}
    return Tire(model, values), Tire(model, values, effects=effects)


def every_build(model, exported):
    """Yield the sources of every kind of binary of a model."""
    steady, full = tires(model)
    for fmi in (2, 3):
        yield exported(export, steady, fmi=fmi)
        for inputs in INPUTS:
            yield exported(export, full, fmi=fmi, inputs=inputs, arrays=fmi == 3 and "hub" in inputs)
    yield exported(export, steady, fmi=3, inputs="wheel", axes="sae", quantities=True)
    yield exported(export_sti, full, "tire.so")
    yield from {shape.shown.inputs: shape.sources for shape in every_generic([model])}.values()


def assert_no_warning(program, sources, names, folder):
    for file, content in sources.items():
        (folder / file).write_bytes(content)
    done = subprocess.run(
        [*COMMANDS[program], str(fmi_headers()), *names], cwd=folder, capture_output=True, text=True, check=False
    )
    assert not done.stderr, done.stderr
    assert done.returncode == 0


@pytest.mark.skipif(not shutil.which("gcc"), reason="gcc is not installed")
@pytest.mark.parametrize("kind", slow_but(["hub-torque"], [*INPUTS, "sti"]))
def test_gcc_has_no_warning(exported, tmp_path, kind):
    """The wrapper's files around the smallest model."""
    if kind == "sti":
        sources = exported(export_sti, tires("brush")[1], "tire.so")
    else:
        sources = exported(export, tires("brush")[1], fmi=3 if kind == "slip" else 2, inputs=kind)
    assert_no_warning("gcc", sources, [file for file in sources if file.endswith(".c")], tmp_path)


@pytest.mark.skipif(not COMPLETE, reason="minutes: make warnings")
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("program", COMMANDS)
def test_no_program_has_a_warning(exported, tmp_path, program, model):
    compiled = set()
    for i, sources in enumerate(every_build(model, exported)):
        folder = tmp_path / str(i)
        folder.mkdir()
        # The code of a model is the same in all of its binaries, unless effects are added.
        names = [
            name for name in sources
            if name.endswith(".c") and not (name in model_files(model) and (name, sources[name]) in compiled)
        ]  # fmt: skip
        assert_no_warning(program, sources, names, folder)
        compiled |= {(name, sources[name]) for name in names}
    folders = (files("tirefmu.fmu") / "wrapper", files("tirefmu.applications.sti"))
    wrapper = {file.name for folder in folders for file in folder.iterdir() if file.name.endswith(".c")}
    assert wrapper - {name for name, _ in compiled} == {"windows.c"}  # which needs the headers of Windows
