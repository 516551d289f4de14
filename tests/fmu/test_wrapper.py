"""The hand-written C: without warnings, complete, and usable in a host without Python."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3ScheduledExecution, FMU3Slave

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import fmi_headers
from tirefmu.fmu.packaging.sources import STI, c_files, sources, sti_sources
from tirefmu.fmu.packaging.sti import tire_header
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires import Tire

from .test_memory import EFFECTS, VALUES

OUTPUTS = ("Fx", "Fy", "Mz")


@pytest.mark.parametrize(
    ("name", "inputs", "optimization"),
    [
        *((name, inputs, "-O2") for name in ("second", "rolling") for inputs in ("slip", "wheel", "hub-torque")),
        ("rolling", "hub-torque", "-O0"),
    ],
)
def test_compiles_without_a_warning(compiler, tires, tmp_path, optimization, name, inputs):
    """The files of both versions of the standard."""
    tire = tires[name]
    shown = interface(tire, inputs=inputs)
    for file, content in (sources(2, shown, "{1}") | sources(3, shown, "{1}")).items():
        (tmp_path / file).write_bytes(content)
    files = dict.fromkeys((*c_files(2, shown), *c_files(3, shown)))
    # The larger models' code only takes longer.
    own = [file for file in files if tire.model == "mf96" or not file.startswith(tire.model)]
    compile_strictly([*compiler, optimization, "-isystem", str(fmi_headers())], tmp_path, own)


def compile_strictly(compiler, folder, names):
    strictly = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror"]
    done = subprocess.run([*compiler, *strictly, "-c", *names], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


@pytest.mark.parametrize(("fmi", "inputs"), [(2, "slip"), (3, "hub-torque")])
def test_no_source_file_calls_one_that_calls_it(compiler, tmp_path, fmi, inputs):
    """The files of the wrapper have an order, in which each calls earlier ones only."""
    if not shutil.which("nm"):
        pytest.skip("nm is not installed")
    tire = Tire("mf61", VALUES, effects={"relax_lat", "relax_lon", "turn_slip", *EFFECTS})
    shown = interface(tire, inputs=inputs)
    for file, content in sources(fmi, shown, "{1}").items():
        (tmp_path / file).write_bytes(content)
    own = [file for file in c_files(fmi, shown) if not file.startswith("mf61")]
    compile_strictly([*compiler, "-O0", "-isystem", str(fmi_headers())], tmp_path, own)
    defined, needed = {}, {}
    for file in own:
        listed = subprocess.run(["nm", "-P", file[:-1] + "o"], cwd=tmp_path, capture_output=True, text=True, check=True)
        for name, kind, *_ in map(str.split, listed.stdout.splitlines()):
            if kind == "U":
                needed.setdefault(file, set()).add(name)
            elif kind.isupper():
                defined[name] = file
    calls = {file: {defined[name] for name in names & defined.keys()} for file, names in needed.items()}
    assert len(calls) > 5
    assert set(TopologicalSorter(calls).static_order()) == set(own)


def test_a_library_with_sti_compiles_without_a_warning(compiler, tires, tmp_path):
    shown = interface(tires["second"], inputs="hub")
    for file, content in sti_sources(shown, tire_header(tires["second"])).items():
        (tmp_path / file).write_bytes(content)
    compile_strictly([*compiler, "-O2"], tmp_path, STI)


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
    [("second", "hub", 2000), ("second", "hub-torque", 2000), ("mf61", "hub-torque", 50_000)],
)
def test_a_step_allocates_no_memory_and_opens_no_file(compiler, tires, tmp_path, name, inputs, steps):
    """Nor is a step refused, or a load beyond all bounds: fast changes of slip make large forces."""
    shown = interface(tires[name], inputs=inputs)
    files = sources(3, shown, "{1}")
    for file, content in files.items():
        (tmp_path / file).write_bytes(content)
    wrapped = [f"-Wl,--wrap={name}" for name in ("malloc", "calloc", "realloc", "free", "fopen")]
    code = [str(tmp_path / file) for file in files if file.endswith(".c")]
    host = str(Path(__file__).with_name("quiet_step.c"))
    command = [*compiler, "-std=gnu99", "-O1", f"-I{tmp_path}", f"-I{fmi_headers()}", host, *code, *wrapped, "-lm"]
    subprocess.run([*command, "-o", str(tmp_path / "host")], check=True)
    listed = {v.name: reference for reference, v in enumerate(shown.variables)}
    radius = tires[name].values["UNLOADED_RADIUS"]
    limits = {"r_z": (0.85 * radius, 1.02 * radius), "R_32": (-0.1, 0.1), "v_x": (-10.0, 60.0), "v_y": (-3.0, 3.0),
              "v_z": (-0.5, 0.5), "w_z": (-1.0, 1.0), "road_mu": (0.1, 1.2)}  # fmt: skip
    limits |= {"T_drive": (-300.0, 300.0), "T_brake": (0.0, 500.0)} if shown.spins else {"omega": (-20.0, 150.0)}
    moved = [f"{listed[name]}:{low!r}:{high!r}" for name, (low, high) in limits.items()]
    given = [str(tmp_path / "host"), "{1}", str(steps), str(listed["F_x"]), *moved]
    done = subprocess.run(given, capture_output=True, text=True, check=True)
    before, during, largest = map(float, done.stdout.split())
    assert before > 0
    assert during == 0
    assert 1e3 < largest < 60.0 * tires[name].values["FNOMIN"]


KINDS = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model, FMU3ScheduledExecution)}


def test_every_function_of_the_standard_is_there(fmus, fmi):
    with loaded(fmus["first", fmi]) as slave:
        for kind in KINDS[fmi]:
            # fmpy resolves every function when it loads a library.
            library = kind(
                guid="",
                unzipDirectory=str(slave.folder),
                modelIdentifier=slave.description.coSimulation.modelIdentifier,
                instanceName="look",
            )
            library.freeLibrary()


def test_scheduled_execution_is_not_offered(fmus, capfd):
    with loaded(fmus["first", 3]) as slave:
        library = FMU3ScheduledExecution(
            guid=slave.description.guid,
            unzipDirectory=str(slave.folder),
            modelIdentifier=slave.description.coSimulation.modelIdentifier,
            instanceName="other",
        )
        with pytest.raises(Exception, match="Failed to instantiate"):
            library.instantiate()
        library.freeLibrary()
    assert "this FMU does not support Scheduled Execution" in capfd.readouterr().out


def test_another_token_is_refused(fmus, fmi, capfd):
    with loaded(fmus["first", fmi]) as slave:
        library = KINDS[fmi][0](
            guid="{00000000-0000-0000-0000-000000000000}",
            unzipDirectory=str(slave.folder),
            modelIdentifier=slave.description.coSimulation.modelIdentifier,
            instanceName="other",
        )
        with pytest.raises(Exception, match="Failed to instantiate"):
            library.instantiate()
        library.freeLibrary()
    assert "the token of the model description differs from the token of this binary" in capfd.readouterr().out


def test_what_is_not_supported_reports_so(host):
    host.start()
    names = {2: ["CancelStep"], 3: ["EvaluateDiscreteStates", "EnterConfigurationMode"]}[host.version]
    for name in names:
        assert host.call(name) == 3
        assert host.log[-1] == f"fmi{host.version}{name} is not supported by this FMU"


def test_fmpys_own_simulation(fmus, fmi, tires):
    time = np.linspace(0.0, 1.0, 11)
    signal = np.zeros(11, dtype=[("time", float), ("alpha", float), ("Fz", float)])
    signal["time"], signal["alpha"], signal["Fz"] = time, 0.15 * time, 700.0
    result = simulate_fmu(
        str(fmus["second", fmi]),
        stop_time=1.0,
        output_interval=0.1,
        start_values={"kappa": 0.03, "LMUY": 0.9},
        input=signal,
        output=["alpha", "Fz", *OUTPUTS],
    )
    tire = replace(tires["second"], values={**tires["second"].values, "LMUY": 0.9})
    forces = tire.forces(kappa=0.03, alpha=result["alpha"], Fz=result["Fz"])
    assert len(result) == 11
    for name in OUTPUTS:
        np.testing.assert_allclose(result[name], forces[name], rtol=1e-9, atol=1e-9)


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
    found = np.array([[float(number) for number in line.split()] for line in done.stdout.splitlines()])
    points = [(name, 0.05 * k) for k in range(3) for name in ("first", "second")]
    expected = [
        [float(f) for f in tires[name].forces(kappa=0.04, alpha=alpha, gamma=0.02, Fz=850.0).values()]
        for name, alpha in points
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
