"""Outputs in addition to forces: quantities, friction use, axes, inputs of effects, distance; and derivatives."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from tirefmu.fmu import check
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import contents
from tirefmu.tires import convert_signs

from .conftest import ERROR, OK, distance

POINT = {"kappa": 0.05, "alpha": -0.08, "gamma": 0.03, "Fz": 4100.0, "p": 2.1e5, "V": 21.0}


# ------------------------------------------------------------------ effects beyond the book


def test_inputs_of_effects_that_the_tire_has(tires):
    warm = tires["warm"]
    names = {name: [v.name for v in interface(tire).group("input")] for name, tire in
             (("warm", warm), ("plain", replace(warm, effects=warm.has - {"temp_friction"})))}  # fmt: skip
    assert names["warm"] == ["kappa", "alpha", "gamma", "Fz", "p", "V", "T"]
    assert names["plain"] == names["warm"][:-1]
    assert [v.name for v in interface(warm).group("state")] == ["distance"]
    assert interface(tires["mf61"]).group("state") == []


def test_the_distance_is_stored_and_reset(hosts, fmi):
    host = hosts("warm", fmi)
    assert host.set(distance=1000.0) == OK
    host.start()
    assert host.set(distance=0.0) == ERROR
    assert host.set(V=-12.0) == OK
    assert host.get("distance", "der(distance)").tolist() == [1000.0, 12.0]
    for k in range(4):
        assert host.step(0.25 * k, 0.25) == OK
    assert host.get("distance")[0] == 1012.0
    assert host.call("Reset") == OK
    assert host.get("distance")[0] == 0.0


# ------------------------------------------------------------------ extra outputs


def test_every_named_quantity_can_be_an_output(tires, hosts):
    warm, host = tires["warm"], hosts("warm", 3, "slip", "iso", True).start()
    row = warm.evaluate(pd.DataFrame([POINT | {"T": 80.0}]), hold=True).iloc[0]
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
    for _ in range(2):
        assert host.set(p=1e6, kappa=20.0) == OK
        host.get("Fx")
    assert [line.partition(" ")[0] for line in host.log[1:]] == ["kappa", "p"]


@pytest.mark.parametrize("name", ["fiala", "brush"])
def test_inputs_in_another_unit_or_sign_are_reported_for_a_tire_without_ranges(hosts, name):
    host = hosts(name, 2).start()
    for given in ({"alpha": 2.0}, {"alpha": -12.0}, {"kappa": 15.0}, {"Fz": -4000.0}, {"Fz": 4000.0}):
        assert host.set(**given) == OK
        host.get("Fx")
    assert [line.partition(" is outside ")[0] for line in host.log] == ["alpha = -12", "kappa = 15", "Fz = -4000"]


@pytest.mark.parametrize(("inputs", "speed"), [("wheel", "V_x"), ("hub", "v_x"), ("hub-torque", "v_x")])
def test_a_speed_that_nobody_sets_is_reported_once(hosts, inputs, speed):
    host = hosts("first", 2, inputs).start()
    host.get("Fx")
    assert not [line for line in host.log if "stands" in line]
    for _ in range(2):
        assert host.set(**{speed: 0.0}) == OK
        host.get("Fx")
        assert host.set(**{speed: 10.0}) == OK
        host.get("Fx")
    assert [line for line in host.log if "stands" in line] == [
        "V_x = 0: the wheel stands, or the host does not set its speed"
    ]


# ------------------------------------------------------------------ axes


def test_sae_axes_are_the_evaluation_in_sae(tires, fmus, hosts, fmi):
    path, tire = fmus["rolling", fmi, "slip", "sae"], tires["rolling"]
    assert validate_fmu(str(path)) == []
    rng, n = np.random.default_rng(6), 60
    slips = {key: rng.uniform(-size, size, n) for key, size in (("kappa", 0.2), ("alpha", 0.2), ("gamma", 0.1))}
    table = pd.DataFrame({"t": 0.02 * np.arange(n), **slips, "Fz": -rng.uniform(500.0, 6000.0, n)})
    forces = tire.evaluate(table, signs="sae", hold=True)[list(tire.outputs)]
    for signs in ("sae", "iso"):
        result = check(path, convert_signs(table.assign(**forces), "sae", signs), signs=signs)
        assert result.evaluation_difference < 1e-9
        assert max(channel.relative_rmse for channel in result.channels) < 1e-9
    assert hosts("rolling", fmi, "slip", "sae").get("Fz")[0] == -tire.nominal("Fz")


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
