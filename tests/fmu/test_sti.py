"""The library with the Standard Tyre Interface in a C host, compared with the FMU with hub inputs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tirefmu.applications.sti.export import export_sti
from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.symbolic.wheel.quantities import CARRIER, WRENCH
from tirefmu.tires.code.compiler import suffix
from tirefmu.tires.hub import wheel_motion

from .solver import Solver

SOURCE = Path(__file__).with_name("sti_host.c")
#: The subroutines, and the jobs before the simulation of a host that calls them.
ENTRIES = {"tirefmu_sti_": "1,2", "tirefmu_sti": "1,2,11,6", "dtyre_": "1,2"}
NAMES = ("mf61", "second", "fiala", "brush")
STEP, ROWS = 0.002, 150
WRENCH_NAMES, CARRIER_NAMES = ([quantity.name for quantity in kind] for kind in (WRENCH, CARRIER))
WARNING, DO_NOT_USE, FATAL = 1, 2, 3


@pytest.fixture(scope="module")
def programs(tires, compiler, tmp_path_factory):
    """Return the C host by tire, linked with the library of the tire."""
    folder = tmp_path_factory.mktemp("sti")

    class Programs(dict):
        def __missing__(self, name):
            library = export_sti(tires[name], folder / f"lib{name}{suffix()}")
            command = [*compiler, "-std=c99", str(SOURCE), "-o", str(folder / name), str(library), "-lm",
                       f"-Wl,-rpath,{folder}"]  # fmt: skip
            built = subprocess.run(command, capture_output=True, text=True, check=False)
            assert built.returncode == 0, built.stderr
            self[name] = folder / name
            return self[name]

    return Programs()


def motion(manoeuvre, radius):
    """Return positions, orientations, velocities, angular velocities (global) and spins of a manoeuvre."""
    t = STEP * np.arange(ROWS)
    zero = 0.0 * t
    speed = {"launch": 8.0 * t, "slalom": zero + 25.0, "landing": zero + 15.0, "reverse": zero - 6.0}[manoeuvre]
    x = np.cumsum(speed) * STEP
    y, yaw = (0.1 * np.sin(9.0 * t), 0.06 * np.sin(12.0 * t)) if manoeuvre == "slalom" else (zero + 0.2, zero)
    rate = 0.72 * np.cos(12.0 * t) if manoeuvre == "slalom" else zero
    ground = 0.02 * x + 0.01 * np.sin(0.8 * x) + 0.01 * y
    z = ground + radius * (1.06 - 0.5 * t if manoeuvre == "landing" else 0.95 + zero)
    v = np.stack([speed, np.gradient(y, STEP), np.gradient(z, STEP)], axis=-1)
    slip = 0.3 * t / t[-1] if manoeuvre == "launch" else 0.02 * np.sin(20.0 * t)
    turned = Rotation.from_euler("ZXY", np.stack([yaw, 0.03 + 0.02 * np.sin(5.0 * t), 0.01 + zero], axis=-1))
    return np.stack([x, y, z], axis=-1), turned, v, np.stack([zero, zero, rate], axis=-1), speed / radius * (1 + slip)


def run(program, entry, r, turned, v, w, spin, *fault):
    """Return the numbers by row, the error output and the exit status of the C host."""
    matrices = turned.as_matrix()
    rows = np.column_stack([
        STEP * np.arange(len(r)), r, np.swapaxes(matrices, 1, 2).reshape(-1, 9),
        np.einsum("nji,nj->ni", matrices, v), np.einsum("nji,nj->ni", matrices, w), spin,
    ])  # fmt: skip
    text = "\n".join(" ".join(map(repr, map(float, row))) for row in rows)
    command = [str(program), entry, ENTRIES[entry], *fault]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float), done.stderr, done.returncode


def plane(entry, radius, r, matrix):
    """Return height below the wheel centre, normal and friction of the road, as the C host has it."""

    def at(x, y):
        slopes = np.array([0.02 + 0.008 * np.cos(0.8 * x), 0.01])
        return 0.02 * x + 0.01 * np.sin(0.8 * x) + 0.01 * y, slopes, 0.8 + 0.2 * np.tanh(y)

    z, slopes, friction = at(r[0], r[1])
    if entry == "dtyre_":  # the plane at the contact point
        named = {f"R_{i + 1}{j + 1}": matrix[i, j] for i in range(3) for j in range(3)}
        normal = {"road_nx": -slopes[0], "road_ny": -slopes[1], "road_nz": 1.0}
        motion_there = wheel_motion(r_x=r[0], r_y=r[1], r_z=r[2], road_z=z, **normal, **named)
        place = np.array([motion_there["c_x"], motion_there["c_y"]])
        z, slopes, friction = at(*place)
        z += slopes @ (r[:2] - place)
    elif (r[2] - z) / np.sqrt(1.0 + slopes @ slopes) >= radius:  # no contact: a level road far below
        return r[2] - 1.5 * radius, [0.0, 0.0, 1.0], friction
    return z, [*-slopes, 1.0], friction


def simulate(fmu, folder, entry, radius, r, turned, v, w, spin):
    """Return the same numbers as the C host: forces, moments, states, derivatives."""
    solver, matrices, rows = Solver(fmu, folder).start(), turned.as_matrix(), []
    states = solver.states()
    solver.update()
    assert solver.call("enterContinuousTimeMode") == 0
    for i in range(len(r)):
        z, normal, friction = plane(entry, radius, r[i], matrices[i])
        given = dict(zip(CARRIER_NAMES, [*r[i], *matrices[i].ravel(), *v[i], *w[i]], strict=True))
        given |= dict(zip(("road_z", "road_nx", "road_ny", "road_nz"), [z, *normal], strict=True)) | {"omega": spin[i]}
        given |= {"road_mu": friction} if "road_mu" in solver.references else {}
        for name, value in given.items():
            assert solver.set(name, value) == 0
        assert solver.set_states(*states) == 0
        rates = solver.rates()
        rows.append([*solver.get(*WRENCH_NAMES), *states, *rates])
        states = states + STEP * rates
    solver.fmu.freeInstance()
    return np.array(rows)


@pytest.mark.parametrize("manoeuvre", ["launch", "slalom", "landing", "reverse"])
@pytest.mark.parametrize(
    ("name", "entry"),
    [("mf61", "tirefmu_sti_"), ("mf61", "dtyre_"), *((name, "tirefmu_sti") for name in NAMES[1:])],
)
def test_library_and_fmu_agree(programs, fmus, tires, tmp_path, name, entry, manoeuvre):
    radius = tires[name].values["UNLOADED_RADIUS"]
    given = motion(manoeuvre, radius)
    rows, report, status = run(programs[name], entry, *given)
    assert status == 0, report
    expected = simulate(fmus[name, 3, "hub"], tmp_path, entry, radius, *given)
    size = 1.0 + np.abs(expected).max(axis=0)
    assert np.abs(expected[:, :6]).max() > 100.0
    assert np.abs((rows[:, : expected.shape[1]] - expected) / size).max() < 1e-9
    if manoeuvre == "landing":
        assert np.all(rows[0, :6] == 0.0)
        assert rows[-1, 2] > 100.0


def test_results_have_their_positions(programs, tires):
    given = motion("slalom", tires["mf61"].values["UNLOADED_RADIUS"])
    by_entry = {}
    for entry in ("tirefmu_sti_", "dtyre_"):
        rows, report, _ = run(programs["mf61"], entry, *given)
        assert "3 states, 16 parameters, 75 results" in report
        by_entry[entry] = rows[:, -75:]
    results, tno = by_entry.values()
    radius = tires["mf61"].values["UNLOADED_RADIUS"]
    np.testing.assert_allclose(results[:, 43] + tno[:, 11], radius, atol=1e-4)  # the planes differ a little
    np.testing.assert_allclose(results[:, 25:28], tno[:, 12:15], atol=1e-3)
    assert np.all(results[:, 2] > 0.0)
    np.testing.assert_allclose(results[:, 47], 25.0, rtol=0.05)
    assert np.ptp(results[:, 6]) > 0.05


@pytest.mark.parametrize(
    ("fault", "status", "line"),
    [
        ("road", DO_NOT_USE, "no road here"),
        ("job", DO_NOT_USE, "tire 3: JOBFLG 7 is unknown"),
        ("states", FATAL, "states"),
        ("results", FATAL, "NVARS is 10, but the tire has 75 results"),
        ("number", DO_NOT_USE, "r_y must be finite"),
    ],
)
def test_errors_have_the_codes_of_the_standard(programs, tires, fault, status, line):
    rows, report, returned = run(programs["mf61"], "tirefmu_sti_", *motion("slalom", 0.3), fault)
    assert returned == status
    assert line in report
    assert len(rows) == 0


def test_a_wheel_outside_the_valid_range_is_one_warning(programs, tires):
    r, turned, v, w, spin = motion("reverse", tires["mf61"].values["UNLOADED_RADIUS"])
    r[:, 2] -= 0.15
    _, report, status = run(programs["mf61"], "tirefmu_sti_", r, turned, v, w, spin)
    assert status == 0
    assert report.count("the valid range of the tire") == 1
    assert "5 1: Fz = " in report


def test_the_road_is_called_in_every_call_of_adams(programs):
    _, report, _ = run(programs["mf61"], "tirefmu_sti", *motion("reverse", 0.3))
    assert f"{2 * ROWS + 5} road calls" in report  # jobs 1, 2, 11, 6 and 99


@pytest.mark.parametrize(
    ("name", "platforms", "message"),
    [
        ("tire.fmu", "host", "the name of a library ends with .dll, .dylib, .so"),
        ("tire.so", "x86_64-windows", "libraries for x86_64-windows end with .dll"),
        ("tire.so", "all", "a library is for one platform"),
    ],
)
def test_a_name_that_is_no_library_of_the_platform_is_one_line(tires, tmp_path, name, platforms, message):
    with pytest.raises(FmuError, match=message):
        export_sti(tires["first"], tmp_path / name, platforms=platforms)
    assert not list(tmp_path.iterdir())


def test_options_of_fmus_are_refused(tmp_path, capsys):
    assert (
        main(["export", "trento_hoosier", "--kind", "sti", "-o", str(tmp_path / "tire.so"), "--inputs", "wheel"]) == 2
    )
    assert "omit --fmi, --inputs" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_library_for_another_system(tires, tmp_path):
    pytest.importorskip("ziglang")
    written = export_sti(tires["first"], tmp_path / ("tire.so" if sys.platform == "win32" else "tire.dll"))
    content = written.read_bytes()
    assert content.startswith(b"\x7fELF" if sys.platform == "win32" else b"MZ")
    for entry in ENTRIES:
        assert entry.encode() + b"\0" in content
