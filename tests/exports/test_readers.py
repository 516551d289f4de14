"""Forces of open programs that read what `convert` writes: a test runs if a variable of the environment has the path.

The programs are MFeval, OpenTirePython and Project Chrono; `benchmarks/readers.py` has their variables and calls them.

`make readers` prints the largest differences, relative to the largest force of the rows.
"""

from __future__ import annotations

import importlib.util
import os

import numpy as np
import pandas as pd
import pytest
from fmpy import read_model_description, simulate_fmu

from tirefmu import convert, lint
from tirefmu.applications.exports import HOSTS
from tirefmu.fitting import fit
from tirefmu.fmu import export
from tirefmu.measurements import read_recording
from tirefmu.tires import read_tir

from ..rooms import ROOT

#: They need Octave, a compiler and the sources of other programs: make readers.
pytestmark = pytest.mark.slow

MODEL = "mf52"
ROWS = 200
#: Where Chrono's formulas are those of PAC2002: it limits B times slip to pi/2 - 0.01 and curvature factors to 1.
CHRONO_LIMIT = 1.56
_SPEC = importlib.util.spec_from_file_location("readers", ROOT / "benchmarks" / "readers.py")
readers = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(readers)


@pytest.fixture(scope="module")
def fitted(data_folder):
    """Return a tire fitted to measured recordings."""
    recordings = [read_recording(data_folder / f"{name}.mat") for name in ("cornering", "drivebrake")]
    few = [recording.table.iloc[::60] for recording in recordings]
    return fit(few, MODEL, screening=False, iterations=30, signs=recordings[0].signs).tire


@pytest.fixture(params=["golden", "fitted"])
def tire(request, tire_of):
    """Return a tire of a property file, and one fitted to measured recordings."""
    if request.param == "golden":
        return tire_of(MODEL)
    return request.getfixturevalue("fitted")


@pytest.fixture
def converted(tire, tmp_path):
    """Return a function that converts the tire for a host and returns the result."""
    return lambda host: convert(tire, tmp_path / f"{host}.tir", host)


def evaluated_by(name, path, table):
    """Return forces of a program, or skip the test if its path is not known."""
    variable, evaluate = readers.READERS[name]
    if not os.environ.get(variable):
        pytest.skip(f"{variable} is not set: see benchmarks/readers.py")
    return evaluate(path, table)


def rows(tire, **fixed):
    """Return operating conditions: random slips, inclinations and loads, some inputs fixed."""
    rng = np.random.default_rng(0)
    table = {name: rng.uniform(*limits, ROWS) for name, limits in (("kappa", (-0.2, 0.2)), ("alpha", (-0.2, 0.2)))}
    table |= {"gamma": rng.uniform(-0.05, 0.05, ROWS), "Fz": rng.uniform(0.3, 1.6, ROWS) * tire.values["FNOMIN"]}
    constant = {"V": tire.values["LONGVL"], **fixed}
    return pd.DataFrame({**table, **{name: np.full(ROWS, value) for name, value in constant.items()}})


def differences(reader, forces, expected, where=slice(None)):
    """Return the largest difference of each force, relative to the largest force; `make readers` prints them."""
    largest = {}
    for name, values in forces.items():
        difference, size = np.abs(values - expected[name])[where].max(), np.abs(expected[name]).max()
        largest[name] = float(difference / size) if size else float(difference)  # a fit without Mx has none
    print(f"{reader}: {', '.join(f'{name} {value:.0e}' for name, value in largest.items())}")
    return largest


def within(evaluated, *factors):
    """Return the rows in which no curvature factor is above 1, where other programs limit it."""
    return (evaluated[list(factors)] <= 1.0).all(axis=1).to_numpy()


def test_files_of_a_fitted_tire_pass_the_check_of_each_host_and_give_its_forces(fitted, tmp_path):
    hosts = [name for name, rules in HOSTS.items() if MODEL in rules.dialects]
    lacking = max(hosts, key=lambda name: len(HOSTS[name].dialects[MODEL].lacking))
    results = {lacking: convert(fitted, tmp_path / f"{lacking}.tir", lacking)}
    assert results[lacking].refitted
    for host in hosts:
        if host != lacking:
            complete = not HOSTS[host].dialects[MODEL].lacking
            given = fitted if complete else results[lacking].tire  # fitted once for all hosts that lack coefficients
            results[host] = convert(given, tmp_path / f"{host}.tir", host)
            assert not results[host].refitted
    table = rows(fitted).drop(columns="V")
    for host, result in results.items():
        assert not [finding for finding in lint(result.path, host) if finding.severity == "error"], host
        forces, expected = (tire.forces(**table) for tire in (read_tir(result.path), result.tire))
        for name, values in expected.items():
            np.testing.assert_array_equal(forces[name], values, err_msg=f"{host}: {name}")


def compared_with_mfeval(path, tire, table):
    """Return the largest differences of MFeval where no curvature factor is above 1: the copy of OpenTire limits it.

    That copy also has another residual moment and another rolling resistance: Mz and My are printed only.
    """
    evaluated = tire.evaluate(table)
    where = within(evaluated, "E_x", "E_y", "E_t", "E_xalpha", "E_ykappa")
    assert where.sum() > ROWS / 2
    largest = differences(f"MFeval, {path.name}", evaluated_by("MFeval", path, table), evaluated, where)
    return max(largest[name] for name in ("Fx", "Fy", "Mx"))


def test_mfeval_has_the_same_forces_and_moments(converted):
    result = converted("mfeval")
    assert compared_with_mfeval(result.path, result.tire, rows(result.tire)) < 1e-12


@pytest.mark.parametrize("model", ["mf52", "mf61", "mf62"])
@pytest.mark.parametrize("way", ["convert", "save"])
def test_mfeval_reads_the_model_of_a_file_and_its_camber(tire_of, tmp_path, model, way):
    """A FITTYP that loses a character makes MF6.1 an MF5.2, whose camber differs."""
    tire, path = tire_of(model), tmp_path / f"{way}_{model}.tir"
    if way == "convert":
        convert(tire, path, "mfeval")
    else:
        tire.save(path)
    assert compared_with_mfeval(path, tire, rows(tire).assign(gamma=0.08)) < 1e-12


def test_opentire_has_the_same_forces_where_no_curvature_factor_is_limited(converted):
    result = converted("adams")
    table = rows(result.tire)
    forces, evaluated = evaluated_by("OpenTirePython", result.path, table), result.tire.evaluate(table)
    differences("OpenTire, all rows", forces, evaluated)
    where = within(evaluated, "E_x", "E_y", "E_t", "E_xalpha", "E_ykappa")
    assert where.sum() > ROWS / 2
    largest = differences("OpenTire, curvature factors up to 1", forces, evaluated, where)
    assert largest["Fy"] < 1e-9
    assert max(largest["Fx"], largest["Mz"]) < 1e-3


@pytest.mark.parametrize(("fixed", "names"), [({"kappa": 0.0}, ["Fy"]), ({"alpha": 0.0}, ["Fx"])])
def test_chrono_has_the_same_forces_where_it_limits_nothing(converted, fixed, names):
    """It uses the slip angle where others use its tangent, and adds 0.1 N to a denominator."""
    result = converted("chrono")
    table = rows(result.tire, gamma=0.0, **fixed)
    forces, evaluated = evaluated_by("Chrono", result.path, table), result.tire.evaluate(table, slip_angle="angle")
    differences("Chrono, all rows", forces, evaluated)
    slips = (evaluated["B_x"] * evaluated["kappa_x"], evaluated["B_y"] * evaluated["alpha_y"])
    where = within(evaluated, "E_x", "E_y") & np.all([np.abs(slip) < CHRONO_LIMIT for slip in slips], axis=0)
    assert where.sum() > ROWS / 5
    largest = differences("Chrono", {name: forces[name] for name in names}, evaluated, where)
    assert max(largest.values()) < 2e-5


def slalom(tire, folder, largest, inclination):
    """Return lagged slips, load and forces of a hub FMU whose wheel drives a slalom, brakes and bounces."""
    fmu = export(tire, folder / "hub.fmu", inputs="hub")
    starts = {v.name: v.start for v in read_model_description(str(fmu)).modelVariables}
    rest, speed, spin = (float(starts[name]) for name in ("r_z", "v_x", "omega"))
    time = np.arange(401) * 0.01
    angle, slip = largest * np.sin(np.pi * time), -largest * np.clip((time - 2.0) / 0.5, 0.0, 1.0)
    rolled = inclination * np.sin(2.0 * np.pi * time)
    moved = {
        "time": time, "v_x": speed + 0.0 * time, "v_y": speed * np.tan(angle), "omega": spin * (1.0 + slip),
        "r_z": rest - 0.004 * np.sin(3.0 * np.pi * time),
        "R_22": np.cos(rolled), "R_33": np.cos(rolled), "R_32": np.sin(rolled), "R_23": -np.sin(rolled),
    }  # fmt: skip
    outputs = {"kappa_lagged": "kappa", "alpha_lagged": "alpha", "gamma": "gamma", "Fz": "Fz"}
    outputs |= {name: name for name in ("Fx", "Fy", "Mz")}
    results = simulate_fmu(
        str(fmu), fmi_type="CoSimulation", stop_time=4.0, step_size=0.01, output_interval=0.01,
        input=pd.DataFrame(moved).to_records(index=False), start_values={"SLIP_ANGLE": 1.0}, output=list(outputs),
        set_input_derivatives=False,
    )  # fmt: skip
    return pd.DataFrame({ours: results[name] for name, ours in outputs.items()})


@pytest.mark.parametrize(("largest", "inclination"), [(0.08, 0.0), (0.2, 0.0), (0.08, 0.05)])
def test_a_hub_fmu_drives_a_slalom_as_chronos_tire_does(tire_of, tmp_path, largest, inclination):
    """With the slips of the FMU's carcass, which Chrono's tire has not."""
    result = convert(tire_of(MODEL), tmp_path / "chrono.tir", "chrono")
    driven = slalom(result.tire, tmp_path, largest, inclination)
    assert driven[["Fx", "Fy"]].abs().max().min() > 4000.0
    forces = evaluated_by("Chrono", result.path, driven.assign(V=0.0))  # it reads no speed
    errors = differences(f"Chrono, slalom {largest} {inclination}", forces, driven)
    if (largest, inclination) == (0.08, 0.0):  # nothing is limited
        assert max(errors.values()) < 2e-5
