"""Options and speeds: the influence of each option, limits, low speed and standstill."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

OTHERS = ({"convention": "book"}, {"slip_angle": "angle"}, {"limits": True})
SIX = ["mf52", "mf61", "mf62"]


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


def test_outside_its_range_a_tire_is_evaluated_at_the_limit(tire, points, narrowed):
    """Radii, and M_y by them, use kappa and load without limits, as turn slip does through the wheel speed."""
    tire, rows = narrowed(tire), points(tire)
    still = {"phit": 0.0} if "phit" in tire.inputs else {}
    bounds = np.array([tire.ranges.get(name, (-np.inf, np.inf)) for name in tire.inputs])
    if tire.model != "mf96":  # the load has an upper limit only
        bounds[tire.inputs.index("Fz"), 0] = -np.inf
    inside = np.clip(rows, bounds[:, :1], bounds[:, 1:])
    assert (inside != rows).any(axis=0).mean() > 0.8
    seen = [i for i, name in enumerate(tire.outputs) if name != "My"]
    limited = forces_of_table(tire, table_of(tire, rows, **still), limits=True)[seen]
    np.testing.assert_array_equal(limited, forces_of_table(tire, table_of(tire, inside, **still), limits=True)[seen])
    free = tire.evaluate(table_of(tire, inside, **still), signs=tire.signs)
    # In MF5.2 to 6.2 limits also bound curvature factors to 1, and M_z has a load of FZMIN at least.
    plain = (free["Fz"] >= tire.ranges["Fz"][0]).to_numpy()
    if tire.model != "mf96":
        plain = plain & (free[["E_x", "E_y", "E_t"]] <= 1).all(axis=1).to_numpy()
    assert plain.mean() > 0.3
    expected = free[list(tire.outputs)].to_numpy().T[seen]
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


SANE = st.floats(-1.0, 1.0)


@settings(max_examples=40)
@given(kappa=SANE, alpha=SANE, gamma=SANE, load=SANE, pressure=SANE, speed=SANE, spin=SANE)
@pytest.mark.parametrize("model", ["mf96", *SIX])
def test_with_limits_forces_are_finite_wherever_the_inputs_are(
    made, narrowed, model, kappa, alpha, gamma, load, pressure, speed, spin
):
    tire = narrowed(made(model, 1))
    row = {"kappa": 50 * kappa, "alpha": 1.57 * alpha, "gamma": gamma, "Fz": 5 * load * tire.values["FNOMIN"],
           "p": 1e6 * (1 + pressure), "V": 150 * speed, "phit": 10 * spin}  # fmt: skip
    forces = forces_of_table(tire, pd.DataFrame([row]), limits=True)
    assert np.isfinite(forces).all()
    if row["Fz"] <= 0:
        assert (forces == 0).all()


@settings(max_examples=40)
@given(kappa=SANE, alpha=SANE, gamma=SANE, load=SANE, pressure=SANE, speed=SANE, spin=SANE)
@pytest.mark.parametrize("model", ["mf96", *SIX])
def test_inputs_in_other_axes_give_the_same_tire(made, model, kappa, alpha, gamma, load, pressure, speed, spin):
    tire = made(model, 0)
    row = pd.DataFrame([{
        "kappa": kappa, "alpha": alpha, "gamma": 0.3 * gamma, "Fz": (1.01 + load) * tire.values["FNOMIN"],
        "p": 2e5 * (1 + pressure / 2), "V": 30 * speed, "phit": spin,
    }])  # fmt: skip
    sae, iso = (
        tire.evaluate(row.assign(Fz=way * row["Fz"], alpha=way * row["alpha"]), signs=signs)
        for way, signs in ((-1.0, "sae"), (1.0, "iso"))
    )
    scale = max(abs(iso[name].iloc[0]) for name in tire.outputs)
    for name in tire.outputs:
        way = -1.0 if name in ("Fy", "Mz", "My") else 1.0
        # alpha of "sae" has the other sign as well: the same tire at the same slip
        assert way * sae[name].iloc[0] == pytest.approx(iso[name].iloc[0], rel=1e-9, abs=1e-11 * scale)
