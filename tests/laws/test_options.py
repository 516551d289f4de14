"""Options and speeds: the influence of each option, limits, low speed and standstill."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.tires.evaluation import Conventions, evaluate

OTHERS = ({"convention": "book"}, {"slip_angle": "angle"}, {"limits": True})
SIX = ["mf52", "mf61", "mf62"]
#: Inputs of the models.
SHARED = ("kappa", "alpha", "gamma", "Fz", "p", "V", "phit")


def table_of(tire, rows, **fixed):
    return pd.DataFrame(dict(zip(tire.inputs, rows, strict=True))).assign(**fixed)


def forces_of_table(tire, table, **options):
    return tire.evaluate(table, signs=tire.signs, **options)[list(tire.outputs)].to_numpy().T


@pytest.mark.parametrize("options", OTHERS, ids=str)
def test_each_option_changes_a_result_of_models_that_have_it(tire, points, scale_of, narrowed, options):
    tire, (name,) = narrowed(tire), options
    table = table_of(tire, points(tire))
    change = np.abs(forces_of_table(tire, table, **options) - forces_of_table(tire, table)) / scale_of(tire)
    if name in {option.name for option in tire.symbolic_model.options} or name == "limits":
        assert (change.max(axis=1) > 1e-4)[: tire.outputs.index("Mz") + 1].all()
    else:
        assert (change == 0).all()


def test_limits_without_ranges_do_not_change_mf96(made, points):
    tire = made("mf96", 0)
    table = table_of(tire, points(tire))
    np.testing.assert_array_equal(forces_of_table(tire, table, limits=True), forces_of_table(tire, table))


def test_outside_its_range_a_tire_is_evaluated_at_the_limit(magic_tire, points, narrowed):
    """Radii, and M_y by them, use kappa and load without limits, as turn slip does through the wheel speed."""
    magic_tire, rows = narrowed(magic_tire), points(magic_tire)
    still = {"phit": 0.0} if "phit" in magic_tire.inputs else {}
    bounds = np.array([magic_tire.ranges.get(name, (-np.inf, np.inf)) for name in magic_tire.inputs])
    if magic_tire.model != "mf96":  # the load has an upper limit only
        bounds[magic_tire.inputs.index("Fz"), 0] = -np.inf
    inside = np.clip(rows, bounds[:, :1], bounds[:, 1:])
    assert (inside != rows).any(axis=0).mean() > 0.8
    seen = [i for i, name in enumerate(magic_tire.outputs) if name != "My"]
    limited = forces_of_table(magic_tire, table_of(magic_tire, rows, **still), limits=True)[seen]
    np.testing.assert_array_equal(
        limited, forces_of_table(magic_tire, table_of(magic_tire, inside, **still), limits=True)[seen]
    )
    free = magic_tire.evaluate(table_of(magic_tire, inside, **still), signs=magic_tire.signs)
    # In MF5.2 to 6.2 limits also bound curvature factors to 1, and M_z has a load of FZMIN at least.
    plain = (free["Fz"] >= magic_tire.ranges["Fz"][0]).to_numpy()
    if magic_tire.model != "mf96":
        plain = plain & (free[["E_x", "E_y", "E_t"]] <= 1).all(axis=1).to_numpy()
    assert plain.mean() > 0.3
    expected = free[list(magic_tire.outputs)].to_numpy().T[seen]
    np.testing.assert_allclose(limited[:, plain], expected[:, plain], rtol=1e-12, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("model", SIX)
@pytest.mark.parametrize("convention", ["tno", "book"])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_no_jump_where_slips_begin_to_fade(made, points, scale_of, model, convention, way):
    """Across VXLOW nothing grows faster than by 1e3 loads per m/s.

    With the convention tno turn slip does jump there, from V_c to V_x as the speed that spin refers to.
    """
    tire = made(model, 0)
    rows, low = points(tire), way * tire.values["VXLOW"]
    still = {"phit": 0.0} if convention == "tno" else {}
    below, above = (
        forces_of_table(tire, table_of(tire, rows, **still, V=low * (1 + step)), limits=True, convention=convention)
        for step in (-1e-9, 1e-9)
    )
    assert np.max(np.abs(above - below) / scale_of(tire)) < 2e-6


@pytest.mark.parametrize("model", SIX)
def test_the_tire_comes_to_rest_without_a_jump(made, points, scale_of, model):
    """With limits slips, shifts and moments decrease with speed in both directions; inclination still produces M_x."""
    tire = made(model, 1)
    rows, pressed = points(tire), tire.outputs.index("Mx")
    rest = forces_of_table(tire, table_of(tire, rows, V=0.0), limits=True)
    assert (np.delete(rest, pressed, axis=0) == 0).all()
    assert (rest[pressed] != 0).all()
    for speed in (1e-3, -1e-3, 1e-6, -1e-6, 1e-9, -1e-9):
        crawling = forces_of_table(tire, table_of(tire, rows, V=speed), limits=True)
        assert np.max(np.abs(crawling - rest) / scale_of(tire)) < 1e3 * abs(speed)


@pytest.mark.parametrize("model", SIX)
@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
@pytest.mark.parametrize("options", [{}, *OTHERS], ids=str)
def test_standstill_is_finite(made, points, model, code, options):
    tire = made(model, 0)
    answer = tire.evaluate(table_of(tire, points(tire, n=20), V=0.0), signs=tire.signs, code=code, **options)
    assert np.isfinite(answer.to_numpy()).all()
    assert (answer["My"] == 0).all()


@pytest.fixture(scope="module")
def shares():
    """Return rows of numbers from -1 to 1 by input: both ends, zero and next to it, and between."""
    rng, shape = np.random.default_rng(0), (len(SHARED), 2000)
    special = rng.choice([-1.0, -1e-9, -1e-300, 0.0, 1e-300, 1e-9, 1.0], shape)
    return dict(zip(SHARED, np.where(rng.random(shape) < 0.5, special, rng.uniform(-1.0, 1.0, shape)), strict=True))


@pytest.mark.parametrize("model", ["mf96", *SIX])
def test_with_limits_forces_are_finite_wherever_the_inputs_are(made, narrowed, shares, model):
    tire = narrowed(made(model, 1))
    sizes = {"kappa": 50.0, "alpha": 1.57, "gamma": 1.0, "Fz": 5 * tire.values["FNOMIN"], "V": 150.0, "phit": 10.0}
    table = pd.DataFrame({name: size * shares[name] for name, size in sizes.items()}).assign(p=1e6 * (1 + shares["p"]))
    forces = evaluate(tire, table, Conventions("adapted-sae", limits=True))[list(tire.outputs)].to_numpy()
    assert np.isfinite(forces).all()
    assert (forces[table["Fz"] <= 0] == 0).all()


@pytest.mark.parametrize("model", ["mf96", *SIX])
def test_inputs_in_other_axes_give_the_same_tire(made, shares, model):
    """Alpha of "sae" has the other sign as well: the same tire at the same slip."""
    tire = made(model, 0)
    table = pd.DataFrame(shares).assign(
        gamma=0.3 * shares["gamma"], Fz=(1.01 + shares["Fz"]) * tire.values["FNOMIN"],
        p=2e5 * (1 + shares["p"] / 2), V=30 * shares["V"],
    )  # fmt: skip
    reversed_table = table.assign(Fz=-table["Fz"], alpha=-table["alpha"])
    iso, sae = (
        tire.evaluate(rows, signs=signs)[list(tire.outputs)].to_numpy()
        for rows, signs in ((table, "iso"), (reversed_table, "sae"))
    )
    ways = [-1.0 if name in ("Fy", "Mz", "My") else 1.0 for name in tire.outputs]
    scale = np.abs(iso).max(axis=1, keepdims=True)
    assert (np.abs(ways * sae - iso) <= 1e-9 * np.abs(iso) + 1e-11 * scale).all()
