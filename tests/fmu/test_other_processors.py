"""Printed C and FMUs on other processors, run by qemu: forces, self-tests, the bytes of a serialized state.

`make other-processors` runs it; Debian's cross compilers and qemu-user are needed.
"""

from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest

from tirefmu.applications.exports.printout import generate
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import contents
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.code.compiler import find_compiler

from .programs import LIMITS, linked, sources_of, token_of

pytestmark = pytest.mark.skipif("TIREFMU_PROCESSORS" not in os.environ, reason="make other-processors")

#: By processor: whether the byte with the lowest address is the smallest, as on the machine of the tests.
LITTLE_ENDIAN = {"aarch64": True, "riscv64": True, "s390x": False}
#: Largest difference of a force, relative to the largest of its kind.
EQUAL = 1e-12
STEPS = 200
OK, ERROR = 0, 3
SLIPS = {"kappa": (-1.0, 1.0), "alpha": (-1.2, 1.2), "gamma": (-0.1, 0.1), "Fz": (-500.0, 9000.0), "V": (-10.0, 50.0)}


@pytest.fixture(params=LITTLE_ENDIAN)
def processor(request):
    """Name each processor whose compiler and emulator are installed."""
    for program in (f"{request.param}-linux-gnu-gcc", f"qemu-{request.param}"):
        if not shutil.which(program):
            pytest.skip(f"{program} is not installed")
    return request.param


@pytest.mark.parametrize("level", ["-O0", "-O2"])
@pytest.mark.parametrize("model", MODELS)
def test_self_test_of_printed_c(golden, tmp_path, processor, model, level):
    """With fused multiplications, as compilers for these processors use them by default."""
    given = golden / f"MagicFormula{model[2:]}_Parameters.tir"
    generate(read_tir(given) if given.exists() else model, "c", tmp_path)
    source = f"{model}_selftest.c"
    compiler = [f"{processor}-linux-gnu-gcc", "-std=gnu99", level, "-Wall", "-Wextra", "-Werror", "-static"]
    subprocess.run([*compiler, source, "-lm", "-o", "selftest"], cwd=tmp_path, check=True)
    done = subprocess.run(
        [f"qemu-{processor}", "./selftest"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("inputs", ["slip", "hub"])
def test_fmu(golden, tmp_path, processor, inputs):
    tire = read_tir(golden / "MagicFormula61_Parameters.tir")
    files = contents(tire, 3, "tire", inputs=inputs)
    listed = {v.name: (i, v.causality) for i, v in enumerate(interface(tire, inputs=inputs).variables)}
    arguments = _arguments(tire, listed)
    first = str(listed["F_x" if inputs == "hub" else "Fx"][0])
    results = {}
    for name, compiler, emulator in (
        ("here", find_compiler(), []),
        (processor, [f"{processor}-linux-gnu-gcc", "-static"], [f"qemu-{processor}"]),
    ):
        folder = tmp_path / name
        folder.mkdir()
        program = linked(compiler, folder, "other_processor.c", sources_of(files))
        paths = [str(tmp_path / "here.state"), str(tmp_path / f"{name}.state")]
        command = [*emulator, str(program), token_of(files), str(STEPS), first, *paths, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        *rows, status = done.stdout.splitlines()
        results[name] = np.array([list(map(float, row.split())) for row in rows]), int(status)
    forces, own = results["here"]
    theirs, status = results[processor]
    assert own == OK
    size = np.abs(forces).max(axis=0)
    assert (size > 1.0).all()
    ours, bytes_there = ((tmp_path / f"{name}.state").read_bytes() for name in ("here", processor))
    assert len(ours) == len(bytes_there)
    different = np.mean([a != b for a, b in zip(ours, bytes_there, strict=True)])
    print(
        f"{processor}, {inputs}: largest difference {np.max(np.abs(theirs - forces) / size):.1e}, "
        f"{100 * different:.1f} % of the bytes of the state differ"
    )
    assert (np.abs(theirs - forces) <= EQUAL * size).all()
    assert status == (OK if LITTLE_ENDIAN[processor] else ERROR), "bytes of the other order are refused, not misread"


def _arguments(tire: Tire, listed: dict[str, tuple[int, str]]) -> list[str]:
    """Return the inputs of the program with their limits."""
    size = {"r_z": tire.values["UNLOADED_RADIUS"]}
    return [
        f"{listed[name][0]}:{low * size.get(name, 1.0)!r}:{high * size.get(name, 1.0)!r}"
        for name, (low, high) in (LIMITS | SLIPS).items()
        if listed.get(name, (0, ""))[1] == "input"
    ]
