"""A wheel with velocities as inputs at rest and close to it: friction, parking, shifts, lengths, derivatives."""

from __future__ import annotations

import zipfile

import numpy as np
import pandas as pd
import pytest

from tirefmu.fmu.description.interface import interface

from .conftest import DISCARD, OK

LOAD = 6752.0


@pytest.fixture
def standing(wheels):
    """Return a function that starts a wheel at rest."""
    return lambda name, **values: wheels(name).start(**{"V_x": 0.0, "V_y": 0.0, "omega": 0.0, **values})


def wheel_radius(host, tire):
    """Return the radius by which the FMU computes slips, for a wheel that turns slowly."""
    return host.get("R_e")[0] if "R_e" in host.variables else tire.values["UNLOADED_RADIUS"]


# ------------------------------------------------------------------ friction


@pytest.mark.parametrize("name", ["rolling", "mf61", "first"])
def test_the_vector_of_the_forces_is_limited_to_friction(wheels, tires, name):
    host, rng, time = wheels(name).start(), np.random.default_rng(3), 0.0
    host.set(Fz=1.6 * tires[name].nominal("Fz"))
    low = host.get("LOW_SPEED")[0]
    used = []
    for _ in range(3000):
        V_x = rng.uniform(-2.0, 2.0) * low
        turning = V_x / 0.33 + rng.uniform(-10.0, 10.0) * rng.choice([0.0, 0.01, 0.1, 1.0])
        host.set(V_x=V_x, V_y=rng.uniform(-3.0, 3.0) * rng.choice([0.0, 0.1, 1.0]), omega=turning)
        size = rng.choice([0.01, 0.1, 1.0])
        assert host.step(time, size) == OK
        time += size
        used.append(host.get("friction_use")[0])
    assert max(used) <= 1.0 + 1e-12
    assert np.quantile(used, 0.9) > 0.9


def test_the_limit_of_friction_fades_out_without_a_jump(standing):
    """The formula itself uses up to 1.08 of the friction without its shifts."""
    host = standing("mf61", Fz=LOAD)
    assert host.set(DEFAULT_SIGMA=0.0, SIGK=0.0) == OK  # no lag: the given slips act
    speeds = np.linspace(1.8, 3.4, 1601)
    used = []
    for V_x in speeds:
        host.set(V_x=V_x, V_y=-0.12 * V_x, omega=V_x / 0.385)
        used.append(host.get("friction_use")[0])
    assert np.abs(np.diff(used)).max() < 1e-3
    assert used[0] <= 1.0 + 1e-12
    assert used[-1] > 1.02


@pytest.mark.parametrize("name", ["first", "mf52", "mf61", "mf62", "fiala", "brush"])
def test_the_limit_acts_at_every_speed_on_request(standing, tires, name):
    """By default the resultant is that of the formulas; some of them exceed the friction ellipse."""
    host, rng, used = standing(name, DEFAULT_SIGMA=0.0), np.random.default_rng(4), []
    for _ in range(200):
        V_x = rng.uniform(5.0, 40.0)
        host.set(V_x=V_x, V_y=rng.uniform(-0.5, 0.5) * V_x, omega=V_x / 0.3 * rng.uniform(0.0, 1.5), FRICTION_LIMIT=0.0)
        assert host.step(host.get("time")[0], 10.0) == OK
        free, use = host.get("Fx", "Fy"), host.get("friction_use")[0]
        assert host.set(FRICTION_LIMIT=1.0) == OK
        assert host.get("Fx", "Fy") == pytest.approx(free / max(use, 1.0), rel=1e-12)
        used.append(use)
        assert host.get("friction_use")[0] <= 1.0 + 1e-12
    assert (max(used) > 1.01) == (name != "brush")  # the formulas of the brush model respect it
    assert host.set(FRICTION_LIMIT=1.1) == DISCARD


def test_derivatives_are_those_of_the_limited_forces(standing):
    host = standing("fiala", DEFAULT_SIGMA=0.0, V_x=20.0, V_y=6.0, omega=40.0, FRICTION_LIMIT=1.0)
    assert host.step(0.0, 10.0) == OK
    assert host.get("friction_use")[0] == pytest.approx(1.0, rel=1e-12)
    assert host.derivative(["friction_use"], ["V_y"], [1.0])[1] == pytest.approx([0.0], abs=1e-8)


# ------------------------------------------------------------------ turning on the spot


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_turning_on_the_spot_has_a_moment_up_to_the_friction_torque(standing, tires, way):
    host = standing("mf61", Fz=LOAD)
    torque = tires["mf61"].evaluate(pd.DataFrame({"kappa": [0.0], "Fz": [LOAD]}))["M_zphi_inf"].iloc[0]
    assert 300.0 < torque < 800.0
    host.set(psi_dot=way * 0.5)
    assert host.get("Mz")[0] == 0.0
    moments = []
    for k in range(100):
        assert host.step(0.02 * k, 0.02) == OK
        Fx, Fy, Mz = host.get("Fx", "Fy", "Mz")
        assert abs(Fx) < 1e-6
        assert abs(Fy) < 1e-6
        moments.append(-way * Mz)
    assert np.all(np.diff(moments) > 0.0)
    assert moments[-1] == pytest.approx(torque, rel=1e-3)
    assert moments[-1] <= torque
    # The wheel stops turning: the twist remains.  It turns back: the moment changes sign.
    host.set(psi_dot=0.0)
    assert host.step(2.0, 1.0) == OK
    assert host.get("Mz")[0] == pytest.approx(-way * moments[-1], rel=1e-12)
    host.set(psi_dot=-way * 0.5)
    assert host.step(3.0, 2.0) == OK
    assert host.get("Mz")[0] == pytest.approx(way * torque, rel=1e-3)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("name", ["first", "mf52", "fiala", "brush"])
def test_without_turn_slip_the_torque_is_that_of_a_patch_with_parabolic_pressure(standing, tires, name, way):
    """The integral of friction times lever over a patch whose half length is three times the trail."""
    host, model = standing(name), tires[name].symbolic_model
    row = tires[name].evaluate(pd.DataFrame({"kappa": [0.0]}), steady=True).iloc[0]
    load, a = tires[name].nominal("Fz"), 3.0 * abs(row[model.quantity("trail")])
    x = np.linspace(-a, a, 20001)
    pressure = 0.75 * load / a * (1.0 - (x / a) ** 2)
    torque = abs(row[model.quantity("friction_y")]) * np.trapezoid(pressure * np.abs(x), x)
    assert torque > 1.0
    host.set(psi_dot=way * 0.5)
    for k in range(100):
        assert host.step(0.02 * k, 0.02) == OK
    assert host.get("Mz")[0] == pytest.approx(-way * torque, rel=1e-3)
    assert np.hypot(*host.get("Fx", "Fy")) < 1e-6


def test_the_moment_of_turning_does_not_depend_on_the_step(standing):
    ends = []
    for n in (1, 40):
        host, time = standing("mf61", Fz=LOAD), 0.0
        for psi_dot, V_x in ((0.3, 0.0), (0.3, 0.05), (-0.8, 0.002), (0.0, 0.3)):
            host.set(psi_dot=psi_dot, V_x=V_x, omega=V_x / 0.385)
            for _ in range(n):
                assert host.step(time, 0.1 / n) == OK
                time += 0.1 / n
        ends.append(host.get("Mz", "twist"))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-9)


def test_rolling_removes_the_twist_and_turn_slip_takes_over(standing, tires):
    host = standing("mf61", Fz=LOAD, psi_dot=0.5)
    assert host.step(0.0, 1.0) == OK
    host.set(V_x=5.0, omega=5.0 / 0.385)
    assert host.step(1.0, 2.0) == OK
    assert abs(host.get("twist")[0]) < 0.02
    slips = dict(zip(("kappa", "alpha"), host.get("kappa", "alpha"), strict=True))
    expected = tires["mf61"].forces(**slips, V=5.0, phit=0.1, Fz=LOAD)
    assert host.get("Mz")[0] == pytest.approx(float(expected["Mz"]), rel=1e-9)


# ------------------------------------------------------------------ rest


@pytest.mark.parametrize("name", ["first", "mf52", "mf61", "mf62", "rolling"])
@pytest.mark.parametrize("share", [0.2, 1.0, 2.0])
def test_a_tire_at_rest_has_no_forces(standing, tires, name, share):
    host = standing(name, Fz=share * tires[name].nominal("Fz"))
    for time in (0.0, 1.0):
        assert np.all(host.get(*host.outputs) == 0.0)
        assert host.step(time, 1.0) == OK
    # An inclined wheel at rest has an overturning moment: the load acts beside its plane.
    host.set(gamma=0.05)
    shown = dict(zip(host.outputs, host.get(*host.outputs), strict=True))
    assert all(value == 0.0 for key, value in shown.items() if key != "Mx")


@pytest.mark.parametrize("name", ["first", "mf61"])
def test_shifts_fade_out_towards_rest(standing, tires, name):
    """Without deflection the forces decrease steadily from those of the formula to 0."""
    load = 0.2 * tires[name].nominal("Fz")
    host = standing(name, gamma=0.05, Fz=load)
    low, radius = host.get("LOW_SPEED")[0], wheel_radius(host, tires[name])
    sizes = []
    for V_x in np.linspace(1.0, 0.0, 101) * low:
        host.set(V_x=V_x, omega=V_x / radius)
        sizes.append(np.hypot(*host.get("Fx", "Fy")))
    formula = tires[name].forces(kappa=0.0, alpha=0.0, gamma=0.05, Fz=load, V=low)
    assert sizes[0] == pytest.approx(np.hypot(formula["Fx"], formula["Fy"]), rel=1e-9)
    assert sizes[-1] == 0.0
    assert np.all(np.diff(sizes) < 0.0)
    assert np.abs(np.diff(sizes)).max() < 0.02 * sizes[0]


@pytest.mark.parametrize("size", [1e-3, 5e-3, 2e-2])
@pytest.mark.parametrize(
    ("name", "load"), [("mf61", LOAD), ("first", 1100.0), ("rolling", LOAD), ("fiala", 4000.0), ("brush", 1000.0)]
)
def test_a_locked_wheel_holds_a_car_on_a_slope_with_forces_of_the_last_step(standing, name, load, size):
    """The weakest coupling: forces held over the step, inputs of its begin."""
    host, V_x, last = standing(name, Fz=load), 0.0, []
    for k in range(round(3.0 / size)):
        host.set(V_x=V_x)
        V_x += size * (host.get("Fx")[0] / load - 0.1) * 9.81
        assert host.step(k * size, size) == OK
        last.append(V_x)
    assert np.abs(last[-10:]).max() < 1e-6


# ------------------------------------------------------------------ relaxation lengths by default


def test_a_tire_without_relaxation_has_default_lengths(standing, tires):
    """The Magic Formula has its own; other tires have half the free radius."""
    formula = tires["mf61"].evaluate(pd.DataFrame({"kappa": [0.0], "Fz": [LOAD]}))[["sigma_x", "sigma_y"]].iloc[0]
    half = 0.5 * tires["first"].values["UNLOADED_RADIUS"]
    for name, lengths, inputs in (("mf61", formula, {"Fz": LOAD}), ("first", (half, half), {})):
        host = standing(name, **inputs)
        assert host.get("DEFAULT_SIGMA")[0] == pytest.approx(0.5 * tires[name].values["UNLOADED_RADIUS"])
        host.set(V_x=1e-6, V_y=0.3, omega=2.0)
        sliding = host.get("kappa", "alpha") * 0 + (2.0 * (host.get("R_e")[0] if name == "mf61" else 2 * half), 0.3)
        rates = host.get("der(kappa_lagged)", "der(tan_alpha_lagged)")
        np.testing.assert_allclose(sliding / rates, lengths, rtol=1e-3)


def test_unknown_stiffnesses_give_half_the_radius(tires):
    given = {k: v for k, v in tires["mf61"].values.items() if k != "LONGITUDINAL_STIFFNESS"}
    shown = interface(type(tires["mf61"])("mf61", given, effects=tires["mf61"].has), inputs="wheel")
    assert "half of its free radius" in shown.relaxation_note
    assert not shown.tire.lags
    assert interface(tires["rolling"], inputs="wheel").relaxation_note == ""
    assert interface(tires["mf61"]).relaxation_note == ""


def test_the_lengths_are_logged_and_documented(wheels, fmus, tires, fmi):
    host = wheels("mf61", fmi).start()
    note = interface(tires["mf61"], inputs="wheel").relaxation_note
    assert note.startswith("the tire has no relaxation")
    assert host.log == [note]
    with zipfile.ZipFile(fmus["mf61", fmi, "wheel"]) as archive:
        assert note in archive.read("documentation/index.html").decode()
    assert wheels("rolling", fmi).start().log == []


# ------------------------------------------------------------------ derivatives


@pytest.mark.parametrize("name", ["mf61", "rolling", "first"])
def test_derivatives_agree_across_standstill(standing, tires, name):
    host = standing(name, Fz=1.5 * tires[name].nominal("Fz"))
    host.set(V_y=0.02)
    host.step(0.0, 0.3)
    host.set(omega=0.2)
    host.step(0.3, 0.1)
    unknowns = [*host.outputs, "friction_use", "der(kappa_lagged)", "der(tan_alpha_lagged)"]
    slopes = {}
    for V_x in (-1e-4, -1e-6, -0.0, 0.0, 1e-6, 1e-4):
        host.set(V_x=V_x)
        status, slopes[V_x] = host.derivative(unknowns, ["V_x"], [1.0])
        assert status == OK
    assert abs(slopes[0.0][0]) > 1.0
    for V_x, derivatives in slopes.items():  # continuous, at a rate of the speed below which directions are blended
        scale = np.abs(slopes[0.0]) + 1.0
        assert np.max(np.abs(derivatives - slopes[0.0]) / scale) < 3.0 * abs(V_x) / 0.01 + 1e-6, V_x


def test_derivatives_by_the_default_length_and_of_the_twist(wheels):
    host = wheels("first").start()
    host.set(V_x=12.0, V_y=0.5, omega=50.0)
    _, (slope,) = host.derivative(["der(tan_alpha_lagged)"], ["DEFAULT_SIGMA"], [1.0])
    assert slope == pytest.approx(-host.get("der(tan_alpha_lagged)")[0] / host.get("DEFAULT_SIGMA")[0], rel=1e-12)
    host = wheels("mf61").start()
    host.set(V_x=5.0, omega=5.0 / 0.385, psi_dot=-0.7)
    host.step(0.0, 0.05)
    for name in ("psi_dot", "V_x"):
        status, slopes = host.derivative(["der(twist)"], [name], [1.0])
        assert status == OK
        assert slopes == pytest.approx(host.differences(["der(twist)"], name, 1e-5), rel=1e-6)
    assert host.derivative(["der(twist)"], ["twist"], [1.0])[1] == pytest.approx([-(0.7 + 5.0) / 0.1], rel=1e-12)


# ------------------------------------------------------------------ power


def test_the_dissipated_power_is_never_negative(standing, tires):
    """P = F . (sliding - rate of deflection) + damper: of forces times velocities, without what the spring stores.

    A second wheel without damper follows the same slips: it has the force of the spring alone.
    """
    host, spring = standing("mf61", Fz=LOAD), standing("mf61", Fz=LOAD, LOW_SPEED_DAMPING=0.0)
    sigma = tires["mf61"].evaluate(pd.DataFrame({"kappa": [0.0], "Fz": [LOAD]}))[["sigma_x", "sigma_y"]].iloc[0]
    radius = host.get("R_e")[0]
    rng, time, power = np.random.default_rng(5), 0.0, []
    low = host.get("LOW_SPEED")[0]
    for _ in range(1500):
        V_x = rng.choice([0.0, 1e-3, 0.05, 0.3, 0.9]) * low * rng.choice([-1.0, 1.0])
        motion = {"V_x": V_x, "V_y": rng.normal() * rng.choice([0.0, 0.01, 0.3]),
                  "omega": (V_x + rng.normal() * rng.choice([0.0, 0.01, 0.5])) / radius}  # fmt: skip
        size = rng.choice([1e-3, 1e-2, 0.1])
        for wheel in (host, spring):
            assert wheel.set(**motion) == OK
            rates = wheel.get("der(kappa_lagged)", "der(tan_alpha_lagged)")
        # The radius grows with the speed of the wheel: the slip shows the sliding velocity of the FMU.
        sliding = np.array([host.get("kappa")[0] * 0.5 * (V_x**2 / low + low), motion["V_y"]])
        force, elastic = (wheel.get("Fx", "Fy") * (1.0, -1.0) for wheel in (host, spring))
        power.append((force @ sliding) - elastic @ (rates * sigma.to_numpy()))
        assert host.step(time, size) == spring.step(time, size) == OK
        time += size
    assert max(power) > 1000.0
    assert min(power) >= -1e-9 * max(power)


def test_sae_axes_turn_the_same_way(hosts):
    host = hosts("first", 3, "wheel", "sae", True).start(V_x=0.0, V_y=0.0, omega=0.0, psi_dot=0.5)
    assert host.step(0.0, 1.0) == OK
    Fy, Mz, twist = host.get("Fy", "Mz", "twist")
    assert Fy == 0.0
    assert Mz < -1.0
    assert twist > 0.01
