"""Printed C and FMUs on other processors: forces, self-tests, the bytes of a serialized state.

`make other-processors` runs it; Debian's cross compilers and qemu-user are needed, and gcc-multilib for 32 bit.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest

from tirefmu.applications.exports import generate
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import contents
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import read_tir
from tirefmu.tires.code.compiler import find_compiler

from .programs import linked, moving_inputs, sources_of, token_of

pytestmark = pytest.mark.skipif("TIREFMU_PROCESSORS" not in os.environ, reason="make other-processors")


@dataclass(frozen=True)
class Processor:
    """How to compile and run for a processor; does it read the bytes of a state of this one?"""

    compiler: tuple[str, ...]
    emulator: tuple[str, ...]
    flags: tuple[str, ...] = ()
    reads_states: bool = True


def _emulated(name: str, *, reads_states: bool = True) -> Processor:
    return Processor((f"{name}-linux-gnu-gcc", "-static"), (f"qemu-{name}",), reads_states=reads_states)


#: 32-bit code is optimized for size; with the registers of its old floating-point unit, numbers have 64 bits between
#: two roundings.
PROCESSORS = {
    "aarch64": _emulated("aarch64"),
    "riscv64": _emulated("riscv64"),
    "s390x": _emulated("s390x", reads_states=False),
    "i686": Processor(("gcc", "-m32"), (), ("-Os", "-msse2", "-mfpmath=sse"), reads_states=False),
    "i686 with x87": Processor(("gcc", "-m32"), (), ("-Os", "-mfpmath=387"), reads_states=False),
}
#: Largest difference of a force, relative to the largest of its kind.
EQUAL = 1e-12
STEPS = 200
OK, ERROR = 0, 3


@pytest.fixture(params=PROCESSORS)
def processor(request, tmp_path):
    """Name each processor whose compiler and emulator are installed."""
    there = PROCESSORS[request.param]
    (tmp_path / "empty.c").write_text("#include <math.h>\nint main(void) { return 0; }\n")
    command = [*there.compiler, "empty.c", "-o", "empty"]
    found = all(map(shutil.which, (*there.compiler[:1], *there.emulator)))
    if not found or subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode:
        pytest.skip(f"nothing here compiles or runs for {request.param}")
    return request.param


@pytest.mark.parametrize("level", ["-O0", "-O2"])
@pytest.mark.parametrize("model", MODELS)
def test_self_test_of_printed_c(golden, tmp_path, processor, model, level):
    """With fused multiplications, as compilers for these processors use them by default."""
    given = golden / f"MagicFormula{model[2:]}_Parameters.tir"
    generate(read_tir(given) if given.exists() else model, "c", tmp_path)
    source = f"{model}_selftest.c"
    there = PROCESSORS[processor]
    compiler = [*there.compiler, "-std=gnu99", *there.flags, level, "-Wall", "-Wextra", "-Werror"]
    subprocess.run([*compiler, source, "-lm", "-o", "selftest"], cwd=tmp_path, check=True)
    command = [*there.emulator, "./selftest"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("inputs", ["slip", "hub"])
def test_fmu(golden, tmp_path, processor, inputs):
    tire = read_tir(golden / "MagicFormula61_Parameters.tir")
    files = contents(tire, 3, "tire", inputs=inputs)
    listed = {v.name: (i, v.causality) for i, v in enumerate(interface(tire, inputs=inputs).variables)}
    arguments = moving_inputs(tire, listed)
    first = str(listed["F_x" if inputs == "hub" else "Fx"][0])
    results = {}
    for name, machine in (("here", Processor(tuple(find_compiler()), ())), (processor, PROCESSORS[processor])):
        folder = tmp_path / name
        folder.mkdir()
        program = linked(machine.compiler, folder, "other_processor.c", sources_of(files), *machine.flags)
        paths = [str(tmp_path / "here.state"), str(tmp_path / f"{name}.state")]
        command = [*machine.emulator, str(program), token_of(files), str(STEPS), first, *paths, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        *rows, status = done.stdout.splitlines()
        results[name] = np.array([list(map(float, row.split())) for row in rows]), int(status)
    forces, own = results["here"]
    theirs, status = results[processor]
    assert own == OK
    size = np.abs(forces).max(axis=0)
    assert (size > 1.0).all()
    ours, bytes_there = ((tmp_path / f"{name}.state").read_bytes() for name in ("here", processor))
    assert not PROCESSORS[processor].reads_states or len(ours) == len(bytes_there)
    different = np.mean([a != b for a, b in zip(ours, bytes_there, strict=False)])
    print(
        f"{processor}, {inputs}: largest difference {np.max(np.abs(theirs - forces) / size):.1e}, "
        f"{100 * different:.1f} % of the bytes of the state differ"
    )
    assert (np.abs(theirs - forces) <= EQUAL * size).all()
    assert status == (OK if PROCESSORS[processor].reads_states else ERROR), (
        "bytes of the other order are refused, not misread"
    )
