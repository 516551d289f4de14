"""Misuse by a host in C that is linked with the sources of the FMU; with sanitizers if TIREFMU_SANITIZE is set."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.binaries import FLAGS, SMALL
from tirefmu.fmu.packaging.export import contents
from tirefmu.fmu.packaging.model_code import model_files
from tirefmu.tires import read_tir
from tirefmu.tires.code.compiler import compiled_object

from ..relatives import slow_but
from .programs import linked, moving_inputs, sources_of, token_of

SOURCE = Path(__file__).with_name("robust.c")
CASES = re.findall(r"CASE\((\w+)\)", SOURCE.read_text(encoding="ascii").split("CASES[] =")[1])
#: Makes the first floating-point exception of a program a signal.
TRAPS = b"""#define _GNU_SOURCE
#include <fenv.h>
__attribute__((constructor)) static void trap(void) { feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW); }
"""
SANITIZERS = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]
SANITIZED = SANITIZERS if os.environ.get("TIREFMU_SANITIZE") else []


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def results(request, tires, compiler, tmp_path_factory):
    """Return the printed lines, the errors and the exit status of the program."""
    fmi, folder = request.param, tmp_path_factory.mktemp("robust")
    files = contents(tires["rolling"], fmi, "tire")
    sources = sources_of(files)
    shown = [variable.name for variable in interface(tires["rolling"]).variables]
    assert shown[1:13] == [*tires["rolling"].inputs, *tires["rolling"].outputs]
    ready = {}
    if not SANITIZED:  # the model's code is compiled once for both versions
        for name in ("mf61.h", *model_files("mf61")):
            (folder / name).write_bytes(sources[name])
        ready = {
            name: compiled_object(
                "robust", folder / name, headers=[folder / "mf61.h"], include=[folder], flags=[*FLAGS, *SMALL]
            )
            for name in model_files("mf61")
        }
    defined = [f"-DFMI={fmi}", f"-DLMUX_REFERENCE={shown.index('LMUX')}"]
    program = linked(compiler, folder, SOURCE.name, sources, *SANITIZED, *defined, ready=ready)
    done = subprocess.run([str(program), token_of(files)], capture_output=True, text=True, check=False)
    return done.stdout.splitlines(), done.stderr, done.returncode


def test_there_are_enough_cases():
    assert len(CASES) == len(set(CASES)) >= 30


@pytest.mark.parametrize("case", CASES)
def test_case(results, case):
    lines, _, _ = results
    assert [line for line in lines if line.startswith(case)] == [f"{case} ok"]


def test_nothing_else_is_reported(results):
    _, errors, status = results
    assert errors == ""
    assert status == 0


@pytest.mark.slow
@pytest.mark.parametrize("inputs", ["hub", "hub-torque"])
def test_random_calls_with_hub_inputs(tires, compiler, tmp_path, inputs):
    """No call crashes, returns a value that is not finite, or changes the state when it is refused."""
    files = contents(tires["first"], 3, "tire", inputs=inputs)
    shown = interface(tires["first"], inputs=inputs)
    program = linked(compiler, tmp_path, "fuzz_hub.c", sources_of(files), *SANITIZED)
    calls = 100 * int(os.environ.get("TIREFMU_FUZZ", "200"))
    numbers = map(str, (calls, len(shown.contact_inputs) + 1, len(shown.variables), int(shown.spins)))
    done = subprocess.run([str(program), token_of(files), *numbers], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    accepted, refused, handled = map(int, re.findall(r"\d+", done.stdout))
    assert accepted + refused == calls
    assert (handled > 0) == shown.spins
    assert accepted > 0.25 * calls
    assert refused > 0.05 * calls


@pytest.mark.skipif(sys.platform != "linux", reason="feenableexcept is glibc's")
@pytest.mark.parametrize("inputs", slow_but(["hub-torque"], ["slip", "wheel", "hub", "hub-torque"]))
def test_no_step_raises_a_floating_point_exception(compiler, golden, tmp_path, inputs):
    """As in hosts that stop at the first one: the program ends by a signal if there is one."""
    tire = read_tir(golden / "MagicFormula61_Parameters.tir")
    files = contents(tire, 3, "tire", inputs=inputs)
    listed = {v.name: (i, v.causality) for i, v in enumerate(interface(tire, inputs=inputs).variables)}
    program = linked(compiler, tmp_path, "other_processor.c", {**sources_of(files), "traps.c": TRAPS})
    first = str(listed["Fx" if inputs in ("slip", "wheel") else "F_x"][0])
    paths = [str(tmp_path / "x.state")] * 2
    command = [str(program), token_of(files), "300", first, *paths, *moving_inputs(tire, listed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 301
