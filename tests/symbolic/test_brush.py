"""The brush model: its closed forms against bristles that are integrated one by one, its limits, and every command."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from tirefmu.fitting import fit
from tirefmu.measurements import Recording
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for

SIZE = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3}
LOAD_EXPONENTS = {"NSTIFF": 0.7, "NMU": -0.12, "NPATCH": 0.6}
#: One stiffness and one friction, as in the book; and different ones for each axis.
ISOTROPIC = {"CKAPPA": 6e4, "CALPHA": 6e4, "MUX": 1.2, "MUY": 1.2, "PATCH": 0.07}
ANISOTROPIC = {"CKAPPA": 9e4, "CALPHA": 5e4, "MUX": 1.4, "MUY": 1.1, "PATCH": 0.07}
#: Slips and loads: small, combined, near full sliding, near lock, spinning, turning backward.
SLIPS = [(0.0, 0.02), (0.03, 0.0), (0.02, -0.03), (-0.04, 0.05), (-0.9, 0.02), (0.6, 0.3), (-1.5, 0.1)]


def made(values=ANISOTROPIC, signs="iso", **changes):
    return Tire("brush", {**SIZE, **values, **LOAD_EXPONENTS, **changes}, signs=signs)


@pytest.fixture(scope="module", params=[ISOTROPIC, ANISOTROPIC], ids=["isotropic", "anisotropic"])
def tire(request):
    return made(request.param)


def grid():
    """Return rows (kappa, alpha, Fz) from adhesion to full sliding, on all sides."""
    slips = np.array([-1.0, -0.3, -0.05, -0.01, 0.0, 0.004, 0.03, 0.1, 0.5])
    return np.stack([axis.ravel() for axis in np.meshgrid(slips, 0.9 * slips, [900.0, 3000.0, 5000.0])])


def evaluated(tire, rows, **options):
    return tire.evaluate(pd.DataFrame(dict(zip(tire.inputs, rows, strict=True))), signs=tire.signs, **options)


def by_bristles(tire, kappa, alpha, load):
    """Integrate the bristles' forces over the patch, each up to its friction limit (ISO)."""
    v, ratio = tire.values, load / SIZE["FNOMIN"]
    a = v["PATCH"] * ratio ** v["NPATCH"]
    mu = np.array([v["MUX"], v["MUY"]]) * ratio ** v["NMU"]
    # The stiffness of all bristles in adhesion is 2 c a^2.
    c = np.array([v["CKAPPA"], v["CALPHA"]]) * ratio ** v["NSTIFF"] / (2 * a**2)
    sliding = np.array([kappa, -np.tan(alpha)])
    slip = sliding / abs(1 + kappa)

    def force(x):
        pressure = 3 * load / (4 * a) * (1 - (x / a) ** 2)
        elastic = c * slip * (a - x)
        if np.hypot(*(elastic / mu)) <= pressure:
            return elastic
        return mu**2 * sliding / np.hypot(*(mu * sliding)) * pressure

    def excess(x):
        # The limit over the elastic force, divided by the distance from the leading edge.
        return 3 * load / (4 * a**3) * (a + x) - np.hypot(*(c * slip / mu))

    edge = brentq(excess, -a, a) if excess(a) > 0 else a
    ends = [(-a, edge), (edge, a)]
    parts = (lambda x: force(x)[0], lambda x: force(x)[1], lambda x: x * force(x)[1])
    return [sum(quad(part, *end, epsabs=1e-11, epsrel=1e-11)[0] for end in ends) for part in parts]


def by_steps(tire, kappa, alpha, load, n=20_000):
    """Follow one bristle through the patch: slip deflects it, the friction circle limits its force (ISO)."""
    v, ratio = tire.values, load / SIZE["FNOMIN"]
    a = v["PATCH"] * ratio ** v["NPATCH"]
    mu, c = v["MUX"] * ratio ** v["NMU"], v["CKAPPA"] * ratio ** v["NSTIFF"] / (2 * a**2)
    slip, force, total = np.array([kappa, -np.tan(alpha)]) / abs(1 + kappa), np.zeros(2), np.zeros(3)
    step = 2 * a / n
    for x in a - step * (np.arange(n) + 0.5):
        limit = mu * 3 * load / (4 * a) * (1 - (x / a) ** 2)
        force = force + c * slip * step
        force *= min(1.0, limit / np.hypot(*force))
        total += np.array([*force, x * force[1]]) * step
    return total


@pytest.mark.parametrize("load", [1000.0, 4500.0])
@pytest.mark.parametrize(("kappa", "alpha"), SLIPS)
def test_the_closed_form_is_the_integral_over_the_patch(tire, kappa, alpha, load):
    forces = list(tire.forces(kappa=kappa, alpha=alpha, Fz=load).values())
    np.testing.assert_allclose(forces, by_bristles(tire, kappa, alpha, load), rtol=1e-10, atol=1e-9 * load)


def test_a_soft_tire_sticks_even_while_the_wheel_turns_backward():
    tire = made(CKAPPA=2e3, CALPHA=1.5e3)
    forces = list(tire.forces(kappa=-1.6, alpha=0.2, Fz=3000.0).values())
    np.testing.assert_allclose(forces, by_bristles(tire, -1.6, 0.2, 3000.0), rtol=1e-10)
    assert evaluated(tire, [[-1.6], [0.2], [3000.0]])["psi"][0] < 0.9


@pytest.mark.parametrize(("kappa", "alpha"), [(0.03, -0.04), (-0.06, 0.05)])
def test_bristles_with_memory_slide_as_the_closed_form_has_it(kappa, alpha):
    """In the isotropic model a sliding bristle stays deflected along the slip: no direction is assumed."""
    tire = made(ISOTROPIC)
    forces = list(tire.forces(kappa=kappa, alpha=alpha, Fz=3000.0).values())
    np.testing.assert_allclose(by_steps(tire, kappa, alpha, 3000.0), forces, rtol=1e-3)
    assert 0.1 < evaluated(tire, [[kappa], [alpha], [3000.0]])["psi"][0] < 0.9


def test_isotropic_lines_are_those_of_the_book():
    tire = made(ISOTROPIC)
    answer = evaluated(tire, grid())
    sigma = np.hypot(answer["slip_x"], answer["slip_y"])
    limit = answer["mu_x"] * answer["Fz"]
    s = np.minimum(answer["K_xkappa"] * sigma / (3 * limit), 1.0)
    total, trail = limit * (3 * s - 3 * s**2 + s**3), answer["a"] / 3 * (1 - s) ** 3 / (1 - s + s**2 / 3)
    np.testing.assert_allclose(np.hypot(answer["Fx"], answer["Fy"]), total, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(answer["trail"], trail, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(answer["Fx"] * sigma, total * answer["slip_x"], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(answer["Fy"] * sigma, -total * answer["slip_y"], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(answer["Mz"], -trail * answer["Fy"], rtol=1e-9, atol=1e-9)


def test_at_zero_slip_slopes_are_the_stiffnesses_and_the_trail_a_third(tire):
    loads = np.array([1000.0, 3000.0, 5000.0])
    rows = np.stack([0 * loads, 0 * loads, loads])
    answer = evaluated(tire, rows)
    assert (answer[["Fx", "Fy", "Mz"]] == 0).all(axis=None)
    slopes = code_for(tire.symbolic_model, "c").jacobian_inputs(rows, tire.parameters())
    ratio = (loads / SIZE["FNOMIN"]) ** LOAD_EXPONENTS["NSTIFF"]
    expected = np.array([tire.values["CKAPPA"] * ratio, -tire.values["CALPHA"] * ratio])
    np.testing.assert_allclose([slopes[:, 0, 0], slopes[:, 1, 1]], expected, rtol=1e-13)
    np.testing.assert_allclose([answer["K_xkappa"], answer["K_yalpha"]], expected, rtol=1e-13)
    np.testing.assert_allclose(slopes[:, 2, 1], -answer["a"] / 3 * slopes[:, 1, 1], rtol=1e-13)
    np.testing.assert_allclose(answer["trail"], answer["a"] / 3, rtol=1e-13)
    np.testing.assert_allclose(answer["a"], 0.07 * (loads / 3000.0) ** LOAD_EXPONENTS["NPATCH"], rtol=1e-13)


@pytest.mark.parametrize(("kappa", "alpha"), [(-1.0, 0.1), (-1.0, 0.0), (0.8, -0.7), (0.0, 1.4), (-1.0 + 1e-9, 0.3)])
def test_in_full_sliding_friction_opposes_the_sliding_velocity(kappa, alpha):
    tire = made(ANISOTROPIC, MUY=1.4)
    forces = tire.forces(kappa=kappa, alpha=alpha, Fz=4000.0)
    velocity = np.array([kappa, -np.tan(alpha)])  # of the wheel's force; the tread slides the other way
    limit = 1.4 * (4000.0 / 3000.0) ** LOAD_EXPONENTS["NMU"] * 4000.0
    np.testing.assert_allclose([forces.Fx, forces.Fy], limit * velocity / np.hypot(*velocity), rtol=1e-13, atol=1e-9)
    assert forces.Mz == 0


def test_the_friction_ellipse_is_reached_and_never_exceeded(tire):
    answer = evaluated(tire, grid())
    use = np.hypot(answer["Fx"] / (answer["mu_x"] * answer["Fz"]), answer["Fy"] / (answer["mu_y"] * answer["Fz"]))
    assert use.max() == pytest.approx(1.0, rel=1e-13)
    assert (use[answer["psi"] < 1] < 1.0).all()
    np.testing.assert_allclose(use[answer["psi"] == 1], 1.0, rtol=1e-13)


def test_load_exponents_are_the_option_of_absolute_stiffness():
    loads = np.array([1500.0, 3000.0, 6000.0])
    for exponent, expected in ((0.0, [1, 1, 1]), (1.0, [0.5, 1, 2])):
        answer = evaluated(made(NSTIFF=exponent), [0 * loads, 0 * loads, loads])
        np.testing.assert_allclose(answer["K_xkappa"] / 9e4, expected, rtol=1e-14)
        np.testing.assert_allclose(answer["K_yalpha"] / -5e4, expected, rtol=1e-14)
    plain = replace(made(), effects=[])
    answer = evaluated(plain, [0 * loads, 0 * loads, loads])
    np.testing.assert_allclose(answer["K_xkappa"] / 9e4, loads / 3000.0, rtol=1e-14)
    np.testing.assert_allclose(answer["mu_x"], 1.4, rtol=1e-14)
    np.testing.assert_allclose(answer["a"], 0.07 * np.sqrt(loads / 3000.0), rtol=1e-14)


def test_derivatives_are_continuous_into_full_sliding(tire):
    """The forces have no kink there: the last bristle that sticks carries nothing."""
    begin = brentq(lambda alpha: evaluated(tire, [[0.0], [alpha], [3000.0]])["psi"][0] - 1 + 1e-9, 0.01, 0.3)
    rows = np.array([[0.0, 0.0], [begin * (1 - 1e-7), begin * (1 + 1e-7)], [3000.0, 3000.0]])
    before, after = code_for(tire.symbolic_model, "c").jacobian_inputs(rows, tire.parameters())
    assert np.abs(before - after).max() < 1e-5 * tire.values["CALPHA"]


def bench(tire, n, *, loads, noise=0.0, signs="iso"):
    """Return a recording of pure and combined slips."""
    rng, t = np.random.default_rng(3), np.linspace(0.0, 40.0, n)
    slips = {"kappa": 0.15 * np.sin(1.3 * t), "alpha": 0.2 * np.sin(2.1 * t + 0.4)}
    table = pd.DataFrame({"t": t, **slips, "Fz": np.resize(np.repeat(loads, -(-n // len(loads))), n)})
    forces = tire.evaluate(table, signs=signs)[["Fx", "Fy", "Mz"]]
    return pd.concat([table, forces + noise * rng.normal(size=forces.shape) * [10.0, 10.0, 0.3]], axis=1)


def test_ten_rows_determine_a_tire():
    """From generic values, in both conventions; one load does not identify the exponents, which have defaults."""
    truth = made(NSTIFF=1.0, NMU=0.0, NPATCH=0.5)
    for signs in ("iso", "adapted-sae"):
        recording = Recording(bench(truth, 10, loads=[3000.0], signs=signs), signs, "ten.csv")
        result = fit([recording], "brush", nominal={"Fz0": 3000.0, "R0": 0.3})
        assert result.ok
        assert {name: result.tire.values[name] for name in ANISOTROPIC} == pytest.approx(ANISOTROPIC, rel=1e-5)
        assert {name: result.tire.values[name] for name in LOAD_EXPONENTS} == {"NSTIFF": 1.0, "NMU": 0.0, "NPATCH": 0.5}


def test_several_loads_determine_the_exponents():
    recording = Recording(bench(made(), 300, loads=[1500.0, 3000.0, 4500.0], noise=1.0), "iso", "bench.csv")
    result = fit([recording], "brush", nominal={"Fz0": 3000.0, "R0": 0.3}, screening=False)
    assert result.ok
    for name, value in {**ANISOTROPIC, **LOAD_EXPONENTS}.items():
        assert result.tire.values[name] == pytest.approx(value, rel=0.02, abs=0.01), name


def test_default_physical_constraints_are_enforced():
    """Friction that grows with load and stiffness that grows faster than it are fitted within the constraints."""
    table = bench(made(NSTIFF=1.4, NMU=0.2), 200, loads=[1500.0, 3000.0, 4500.0])
    nominal = {"Fz0": 3000.0, "R0": 0.3}
    result = fit([Recording(table, "iso", "bench.csv")], "brush", nominal=nominal, screening=False)
    assert result.tire.values["NSTIFF"] == pytest.approx(1.0, abs=1e-4)
    assert result.tire.values["NMU"] == pytest.approx(0.0, abs=1e-4)
    free = fit([Recording(table, "iso", "bench.csv")], "brush", nominal=nominal, screening=False,
               without_constraints=["friction_falling", "stiffness_saturating"])  # fmt: skip
    assert free.tire.values["NSTIFF"] == pytest.approx(1.4, rel=1e-3)
    assert free.tire.values["NMU"] == pytest.approx(0.2, rel=1e-3)
