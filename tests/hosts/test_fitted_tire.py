"""A tire fitted to measured recordings, converted for every host that has its model: lint, and forces of open readers.

TIREFMU_OPENTIRE is the folder `code` of a clone of OpenTirePython (MIT licence), an open reader of PAC2002 files.
"""

from __future__ import annotations

import os
from importlib import import_module

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.hosts.convert import convert
from tirefmu.hosts.dialects import HOSTS
from tirefmu.hosts.lint import lint
from tirefmu.measurements import read_recording
from tirefmu.tires import read_tir

MODEL = "mf52"
ROWS = 200


@pytest.fixture(scope="module")
def converted(data_folder, tmp_path_factory):
    """Return the conversions by host: of the fitted tire, or of one without the coefficients that most hosts lack."""
    folder = tmp_path_factory.mktemp("hosts")
    recordings = [read_recording(data_folder / f"{name}.mat") for name in ("cornering", "drivebrake")]
    few = [recording.table.iloc[::60] for recording in recordings]
    fitted = fit(few, MODEL, screening=False, iterations=30, signs=recordings[0].signs).tire
    hosts = [name for name, rules in HOSTS.items() if MODEL in rules.dialects]
    lacking = max(hosts, key=lambda name: len(HOSTS[name].dialects[MODEL].lacking))
    results = {lacking: convert(fitted, folder / f"{lacking}.tir", lacking)}
    assert results[lacking].refitted
    for host in hosts:
        if host != lacking:
            complete = not HOSTS[host].dialects[MODEL].lacking
            tire = fitted if complete else results[lacking].tire
            results[host] = convert(tire, folder / f"{host}.tir", host)
            assert not results[host].refitted
    return results


@pytest.fixture(scope="module")
def rows():
    rng = np.random.default_rng(0)
    table = {name: rng.uniform(*limits, ROWS) for name, limits in (("kappa", (-0.2, 0.2)), ("alpha", (-0.2, 0.2)))}
    return {**table, "gamma": rng.uniform(-0.05, 0.05, ROWS), "Fz": rng.uniform(0.3, 1.6, ROWS)}


def test_files_of_a_fitted_tire_pass_the_check_of_each_host_and_give_its_forces(converted, rows):
    for host, result in converted.items():
        assert not [finding for finding in lint(result.path, host) if finding.severity == "error"], host
        read = read_tir(result.path)
        given = {**rows, "Fz": rows["Fz"] * read.values["FNOMIN"]}
        forces, expected = read.forces(**given), result.tire.forces(**given)
        for name, values in expected.items():
            np.testing.assert_array_equal(forces[name], values, err_msg=f"{host}: {name}")


def test_the_reader_of_opentire_finds_the_same_side_force(converted, rows, monkeypatch):
    """Its Fx and Mz differ by up to 1e-2 of the largest: it limits curvature factors to 1 (docs/languages.md)."""
    folder = os.environ.get("TIREFMU_OPENTIRE")
    if not folder:
        pytest.skip("TIREFMU_OPENTIRE is not set: OpenTirePython is not on PyPI")
    monkeypatch.syspath_prepend(folder)
    reader, state = import_module("opentire.Core.TIRFile"), import_module("opentire.Core.tirestate")

    result = converted["adams"]
    other, tire = reader.TIRFile().load(str(result.path)), result.tire
    given = {**rows, "Fz": rows["Fz"] * tire.values["FNOMIN"], "V": np.full(ROWS, tire.values["LONGVL"])}
    names = {"SR": "kappa", "SA": "alpha", "IA": "gamma", "FZ": "Fz", "V": "V"}
    found = []
    for i in range(ROWS):
        row = state.TireState()
        row.update({theirs: float(given[ours][i]) for theirs, ours in names.items()})
        found.append(other.calculate_fy(row))
    expected = tire.forces(**given)["Fy"]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
