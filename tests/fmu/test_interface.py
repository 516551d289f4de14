"""Outputs in addition to forces: quantities, friction use, axes, inputs of effects, distance; and derivatives."""

from __future__ import annotations

import ctypes
import json
import zipfile
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from tirefmu.fmu import check, export
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import contents
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires.signs import convert_signs

from .conftest import Host

OK, ERROR = 0, 3
POINT = {"kappa": 0.05, "alpha": -0.08, "gamma": 0.03, "Fz": 4100.0, "p": 2.1e5, "V": 21.0}


def distance(found, expected):
    return np.max(np.abs(found - expected) / (1.0 + np.abs(expected)))


@pytest.fixture(scope="module")
def warm(tires):
    """Return a tire with effects that read the temperature and the distance."""
    tire = tires["mf61"]
    effects = (tire.has | {"temp_friction", "wear_drift"}) - {"turn_slip"}
    values = {**tire.values, "TMU1": 0.004, "TMU2": -1e-4, "TREF": 60.0, "WMU1": -2e-4}
    return replace(tire, values=values, effects=effects)


@pytest.fixture(scope="module")
def warm_fmu(warm, compiler, tmp_path_factory):
    return {
        fmi: export(warm, tmp_path_factory.mktemp("warm") / f"warm_{fmi}.fmu", fmi=fmi, quantities=fmi == 3)
        for fmi in (2, 3)
    }


# ------------------------------------------------------------------ effects beyond the book


def test_inputs_of_effects_that_the_tire_has(warm, tires):
    names = {name: [v.name for v in interface(tire).group("input")] for name, tire in
             (("warm", warm), ("plain", replace(warm, effects=warm.has - {"temp_friction"})))}  # fmt: skip
    assert names["warm"] == ["kappa", "alpha", "gamma", "Fz", "p", "V", "T"]
    assert names["plain"] == names["warm"][:-1]
    assert [v.name for v in interface(warm).group("state")] == ["distance"]
    assert interface(tires["mf61"]).group("state") == []


def test_added_effects_are_the_evaluation_with_inputs_held(warm, warm_fmu, fmi):
    assert validate_fmu(str(warm_fmu[fmi])) == []
    rng = np.random.default_rng(8)
    n = 200
    table = pd.DataFrame(
        {
            "t": np.cumsum(rng.uniform(0.001, 0.2, n)),
            "kappa": rng.uniform(-0.2, 0.2, n),
            "alpha": rng.uniform(-0.2, 0.2, n),
            "Fz": rng.uniform(500.0, 6000.0, n),
            "V": rng.uniform(-30.0, 60.0, n),
            "T": rng.uniform(20.0, 110.0, n),
        }
    )
    forces = warm.evaluate(table, hold=True)[list(warm.outputs)]
    result = check(warm_fmu[fmi], table.assign(**forces))
    assert result.ok
    assert result.evaluation_difference < 1e-9
    other = warm.evaluate(table, hold=False)["Fy"]  # the distance between rows is another one
    assert np.max(np.abs(other - forces["Fy"])) > 1.0


def test_the_distance_is_stored_saved_and_reset(warm_fmu, fmi):
    with loaded(warm_fmu[fmi]) as slave:
        host = Host(slave)
        assert host.set(distance=1000.0) == OK
        host.start()
        assert host.set(distance=0.0) == ERROR
        assert host.set(V=-12.0) == OK
        assert host.get("distance", "der(distance)").tolist() == [1000.0, 12.0]
        state = host.fmu.getFMUState() if fmi == 3 else host.fmu.getFMUstate()
        for k in range(4):
            assert host.step(0.25 * k, 0.25) == OK
        assert host.get("distance")[0] == 1012.0
        assert (host.fmu.setFMUState if fmi == 3 else host.fmu.setFMUstate)(state) in (None, OK)
        assert host.get("distance")[0] == 1000.0
        (host.fmu.freeFMUState if fmi == 3 else host.fmu.freeFMUstate)(state)
        assert host.call("Reset") == OK
        assert host.get("distance")[0] == 0.0


# ------------------------------------------------------------------ extra outputs


def test_every_named_quantity_can_be_an_output(warm, warm_fmu):
    row = warm.evaluate(pd.DataFrame([POINT | {"T": 80.0}]), hold=True).iloc[0]
    with loaded(warm_fmu[3]) as slave:
        host = Host(slave).start()
        host.set(**POINT, T=80.0)
        shown = [name for name in host.extras if name != "friction_use"]
        assert set(shown) == set(row.index) - {*warm.inputs, *warm.outputs}
        assert len(shown) > 50
        assert distance(host.get(*shown), row[shown].to_numpy(dtype=float)) < 1e-9


def test_radii_and_friction_use(hosts, tires):
    host = hosts("mf61", 3).start()
    row = tires["mf61"].evaluate(pd.DataFrame([POINT])).iloc[0]
    assert host.set(**POINT) == OK
    assert distance(host.get("R_e", "R_l"), row[["R_e", "R_l"]].to_numpy()) < 1e-12
    expected = np.hypot(row["Fx"] / row["mu_x"], row["Fy"] / row["mu_y"]) / POINT["Fz"]
    assert host.get("friction_use")[0] == pytest.approx(expected, rel=1e-12)
    for load in (0.0, -100.0):
        host.set(Fz=load)
        assert host.get("friction_use")[0] == 0.0


@pytest.mark.parametrize("name", ["first", "mf61", "rolling"])
def test_friction_use_is_one_where_all_friction_is_used(hosts, name, fmi):
    host = hosts(name, fmi)
    host.initialize()
    used = []
    for slip in np.linspace(0.0, 1.5, 200):
        host.set(alpha=slip)
        used.append(host.get("friction_use")[0])
    assert used[0] < 0.1
    assert 0.9 < max(used) < 1.1


def test_exceeding_the_known_range_is_reported_once(hosts):
    host = hosts("mf61", 3).start()
    host.set(**POINT)
    host.get("Fx")
    assert host.log == []
    for load in (90_000.0, 80_000.0, 4000.0, 90_000.0):
        assert host.set(Fz=load) == OK
        assert np.all(np.isfinite(host.get("Fx", "Fy")))
    assert len(host.log) == 1
    assert host.log[0].startswith("Fz = 90000 is outside ")


# ------------------------------------------------------------------ axes


def test_sae_axes_are_the_evaluation_in_sae(tires, compiler, tmp_path, fmi):
    for name in ("mf61", "rolling"):
        path = export(tires[name], tmp_path / f"{name}_sae.fmu", fmi=fmi, axes="sae")
        assert validate_fmu(str(path)) == []
        rng = np.random.default_rng(6)
        n = 60
        table = pd.DataFrame(
            {
                "t": 0.02 * np.arange(n),
                "kappa": rng.uniform(-0.2, 0.2, n),
                "alpha": rng.uniform(-0.2, 0.2, n),
                "gamma": rng.uniform(-0.1, 0.1, n),
                "Fz": -rng.uniform(500.0, 6000.0, n),
            }
        )
        expected = tires[name].evaluate(table, signs="sae", hold=True)
        with loaded(path) as slave:
            host = Host(slave)
            assert host.get("Fz")[0] == -tires[name].nominal("Fz")
            host.initialize()
            for i, row in table.iterrows():
                assert host.set(**row.drop("t")) == OK
                if i == 0:
                    host.call("ExitInitializationMode")
                lagged = ["kappa_lagged", "alpha_lagged"] if name == "rolling" else []
                shown = [*host.outputs, *lagged]
                assert distance(host.get(*shown), expected.loc[i, shown].to_numpy(dtype=float)) < 1e-9
                assert host.step(row["t"], 0.02) == OK


def test_check_uses_the_axes_of_the_fmu(tires, compiler, tmp_path):
    path = export(tires["mf61"], tmp_path / "sae.fmu", axes="sae")
    table = pd.DataFrame({"alpha": np.linspace(-0.1, 0.1, 21), "Fz": 3000.0})
    table["Fy"] = tires["mf61"].forces(alpha=table["alpha"], Fz=3000.0)["Fy"]
    for signs in ("iso", "sae"):
        result = check(path, convert_signs(table, "iso", signs), signs=signs)
        assert result.ok
        assert result.channels[0].r2 == pytest.approx(1.0, abs=1e-12)


def test_the_file_states_its_conventions(tires):
    for inputs, axes in (("slip", "iso"), ("wheel", "sae")):
        reported = json.loads(contents(tires["mf61"], 3, "t", inputs=inputs, axes=axes)["resources/interface.json"])
        assert reported == {"inputs": inputs, "axes": axes}


# ------------------------------------------------------------------ pictures, terminals, documentation


def test_icon_and_terminals(fmus, fmi):
    with zipfile.ZipFile(fmus["mf61", fmi]) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
        if fmi == 3:
            terminals = archive.read("terminalsAndIcons/terminalsAndIcons.xml").decode()
            for name in ("kappa", "Fz", "Fy", "friction_use"):
                assert f'variableName="{name}"' in terminals
    assert ("model.png" in names) == (fmi == 2)
    assert ("terminalsAndIcons/icon.png" in names) == (fmi == 3)
    for text in ("How to connect", "licenses/license.txt", "range of Fz"):
        assert text in page


# ------------------------------------------------------------------ derivatives


def adjoint(host, unknowns, knowns, seed):
    a, b = host.references(unknowns), host.references(knowns)
    seeds, found = (ctypes.c_double * len(seed))(*seed), (ctypes.c_double * len(knowns))()
    status = host.call("GetAdjointDerivative", a, len(a), b, len(b), seeds, len(seeds), found, len(found))
    return status, np.array(found)


@pytest.mark.parametrize("name", ["first", "mf61", "rolling"])
def test_adjoint_and_directional_derivatives_are_one_matrix(hosts, name):
    host = hosts(name, 3).start()
    host.set(**{key: value for key, value in POINT.items() if key in host.inputs})
    host.step(0.0, 0.01)
    unknowns, knowns = [*host.outputs, "friction_use"], [*host.inputs, "PDY1", "PKX1"]
    knowns += ["kappa_lagged", "tan_alpha_lagged"] if name == "rolling" else []
    by_columns = [host.derivative(unknowns, [known], [1.0])[1] for known in knowns]
    by_rows = [adjoint(host, [unknown], knowns, [1.0]) for unknown in unknowns]
    assert all(status == OK for status, _ in by_rows)
    # Reverse mode against forward mode: equal except for the last digits.
    np.testing.assert_allclose(np.array(by_columns).T, [row for _, row in by_rows], rtol=1e-12, atol=1e-13)
    seed = np.linspace(-1.0, 2.0, len(unknowns))
    np.testing.assert_allclose(adjoint(host, unknowns, knowns, seed)[1], seed @ np.array(by_columns).T, rtol=1e-12)
    assert adjoint(host, ["kappa"], ["Fz"], [1.0])[0] == ERROR


def test_derivatives_of_rates_and_by_states(hosts, fmi, tires):
    host = hosts("rolling", fmi).start()
    host.set(**POINT)
    host.step(0.0, 0.01)
    sigma = tires["rolling"].evaluate(pd.DataFrame([POINT])).iloc[0]
    status, (by_input,) = host.derivative(["der(kappa_lagged)"], ["kappa"], [1.0])
    assert status == OK
    assert by_input == pytest.approx(POINT["V"] / sigma["sigma_kappa"], rel=1e-6)
    status, (by_state,) = host.derivative(["der(kappa_lagged)"], ["kappa_lagged"], [1.0])
    assert by_state == pytest.approx(-by_input, rel=1e-6)
    # Side force by the tangent of the lagged slip: in steady state equal to that by the slip.
    kappa, alpha = host.get("kappa_lagged", "alpha_lagged")
    _, (by_tangent,) = host.derivative(["Fy"], ["tan_alpha_lagged"], [1.0])
    step = 1e-6
    around = [tires["rolling"].forces(**POINT | {"kappa": kappa, "alpha": alpha + s})["Fy"] for s in (step, -step)]
    assert by_tangent == pytest.approx((around[0] - around[1]) / (2 * step) * np.cos(alpha) ** 2, rel=1e-6)
