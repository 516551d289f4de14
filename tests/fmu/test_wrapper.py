"""The hand-written C: without warnings, complete, and usable in a host without Python."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import zipfile
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3ScheduledExecution, FMU3Slave

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import fmi_headers
from tirefmu.fmu.packaging.sources import c_files, sources
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires import Tire

from ..relatives import slow_but
from .conftest import EFFECTS, VALUES
from .programs import random_steps


def compile_strictly(compiler, folder, names):
    strictly = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror"]
    done = subprocess.run([*compiler, *strictly, "-c", *names], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


@pytest.mark.parametrize(("fmi", "inputs"), slow_but([(3, "hub-torque")], [(2, "slip"), (3, "hub-torque")]))
def test_no_source_file_calls_one_that_calls_it(compiler, tmp_path, fmi, inputs):
    """The files of the wrapper have an order, in which each calls earlier ones only."""
    if not shutil.which("nm"):
        pytest.skip("nm is not installed")
    tire = Tire("mf61", VALUES, effects={"relax_lat", "relax_lon", "turn_slip", *EFFECTS})
    shown = interface(tire, inputs=inputs)
    for file, content in sources(fmi, shown, "{1}").items():
        (tmp_path / file).write_bytes(content)
    wrapper = [file for file in c_files(fmi, shown) if not file.startswith("mf61")]
    compile_strictly([*compiler, "-O0", "-isystem", str(fmi_headers())], tmp_path, wrapper)
    defined, needed = {}, {}
    for file in wrapper:
        listed = subprocess.run(["nm", "-P", file[:-1] + "o"], cwd=tmp_path, capture_output=True, text=True, check=True)
        for name, kind, *_ in map(str.split, listed.stdout.splitlines()):
            if kind == "U":
                needed.setdefault(file, set()).add(name)
            elif kind.isupper():
                defined[name] = file
    calls = {file: {defined[name] for name in names & defined.keys()} for file, names in needed.items()}
    assert len(calls) > 5
    assert set(TopologicalSorter(calls).static_order()) == set(wrapper)


@pytest.mark.parametrize("target", ["aarch64-linux-gnu", "arm-linux-gnueabihf"])
def test_compiles_for_arm_without_a_warning(tires, tmp_path, target):
    """As a real-time computer needs it: C99, every file."""
    pytest.importorskip("ziglang")
    shown = interface(tires["second"], inputs="hub-torque")
    for file, content in sources(3, shown, "{1}").items():
        (tmp_path / file).write_bytes(content)
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-O1", "-isystem", str(fmi_headers())]
    compile_strictly(zig, tmp_path, c_files(3, shown))


@pytest.mark.skipif(sys.platform != "linux", reason="needs a linker with --wrap")
@pytest.mark.parametrize(
    ("name", "inputs", "steps"),
    slow_but([("second", "hub-torque", 2000)], [("second", "hub-torque", 2000), ("mf61", "hub-torque", 50_000)]),
)
def test_a_step_allocates_no_memory_and_opens_no_file(compiler, tires, tmp_path, name, inputs, steps):
    """Nor is a step refused, or a load beyond all bounds: fast changes of slip make large forces."""
    wrapped = [f"-Wl,--wrap={function}" for function in ("malloc", "calloc", "realloc", "free", "fopen")]
    counted = random_steps(compiler, tmp_path, tires[name], inputs, steps, "-DCOUNTS", *wrapped)
    assert counted["allocations before"] > 0
    assert counted["allocations"] == 0
    assert 1e3 < counted["largest force"] < 60.0 * tires[name].values["FNOMIN"]


KINDS = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model, FMU3ScheduledExecution)}


@pytest.fixture
def library(fmus):
    """Return a function that loads the library of an FMU as fmpy does, which resolves every function of a kind."""
    with contextlib.ExitStack() as stack:

        def load(fmi, kind, token=None):
            slave = stack.enter_context(loaded(fmus["first", fmi]))
            identifier = slave.description.coSimulation.modelIdentifier
            guid = slave.description.guid if token is None else token
            made = kind(guid=guid, unzipDirectory=str(slave.folder), modelIdentifier=identifier, instanceName="other")
            stack.callback(made.freeLibrary)
            return made

        yield load


@pytest.mark.parametrize("kind", [kind for kinds in KINDS.values() for kind in kinds])
def test_every_function_of_the_standard_is_there(library, kind):
    library(2 if kind in KINDS[2] else 3, kind)


@pytest.mark.parametrize(
    ("fmi", "kind", "token", "message"),
    [
        (3, FMU3ScheduledExecution, None, "this FMU does not support Scheduled Execution"),
        (2, FMU2Slave, "{0}", "the token of the model description differs from the token of this binary"),
        (3, FMU3Slave, "{0}", "the token of the model description differs from the token of this binary"),
    ],
)
def test_an_instance_that_is_refused_has_a_reason(library, capfd, fmi, kind, token, message):
    with pytest.raises(Exception, match="Failed to instantiate"):
        library(fmi, kind, token).instantiate()
    assert message in capfd.readouterr().out


def test_what_is_not_supported_reports_so(host):
    host.start()
    names = {2: ["CancelStep"], 3: ["EvaluateDiscreteStates", "EnterConfigurationMode"]}[host.version]
    for name in names:
        assert host.call(name) == 3
        assert host.log[-1] == f"fmi{host.version}{name} is not supported by this FMU"


def unpacked_binary(fmu: Path, folder: Path) -> Path:
    with zipfile.ZipFile(fmu) as archive:
        (name,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        return Path(archive.extract(name, folder / fmu.stem))


def test_a_host_without_python(compiler, fmus, fmi, tires, tmp_path):
    if not sys.platform.startswith("linux"):
        pytest.skip("the host uses dlopen as Linux has it")
    source, program = Path(__file__).with_name("host.c"), tmp_path / "host"
    build = [*compiler, f"-DFMI={fmi}", f"-I{fmi_headers()}", str(source), "-o", str(program), "-ldl"]
    subprocess.run(build, check=True, capture_output=True)
    arguments = []
    for name in ("first", "second"):
        fmu = fmus[name, fmi]
        arguments += [str(unpacked_binary(fmu, tmp_path)), read_model_description(str(fmu)).guid]
    done = subprocess.run(
        [str(program), *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={key: value for key, value in os.environ.items() if not key.startswith("PYTHON")},
    )
    assert done.returncode == 0, done.stderr
    shown = np.array([[float(number) for number in line.split()] for line in done.stdout.splitlines()])
    points = [(name, 0.05 * k) for k in range(3) for name in ("first", "second")]
    expected = [
        [float(f) for f in tires[name].forces(kappa=0.04, alpha=alpha, gamma=0.02, Fz=850.0).values()]
        for name, alpha in points
    ]
    np.testing.assert_allclose(shown, expected, rtol=1e-9, atol=1e-9)
