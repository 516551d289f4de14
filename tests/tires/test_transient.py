"""Lagged slips: the update over a step, and the evaluation of a recording."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tirefmu.boundary.errors import DataError
from tirefmu.symbolic.models import model_named
from tirefmu.symbolic.quantities import AT_ONCE
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for
from tirefmu.tires.states.transient import followed, lagged_course, segment_starts

SIX = ["mf52", "mf61", "mf62"]
#: A small car's tire, with the relaxation lengths of MF5.2 in addition to SIGX and SIGY.
BODY = {
    "FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "PKY1": -18.0, "PKY2": 2.0, "PDX2": -0.1, "PDY2": -0.2, "PKX3": 0.2,
    "LATERAL_STIFFNESS": 1.2e5, "LONGITUDINAL_STIFFNESS": 2.8e5, "PTX1": 1.1, "PTX2": 0.2, "PTY1": 2.0,
    "SIGX": 0.2, "SIGY": 0.45, "SIGC": 0.4, "SIGK": 1.0, "QSX3": -0.05, "QSY1": 0.01,
}  # fmt: skip


def lagged(t, slip, speed, sigma, *, hold):
    return lagged_course(t, slip, speed, sigma, hold=hold).value


def lagging(name="mf61", *effects, **values):
    symbolic_model = model_named(name)
    given = {key: value for key, value in {**BODY, **values}.items() if key in symbolic_model.coefficients}
    return Tire(name, given, effects=symbolic_model.default_effects | set(effects))


@pytest.mark.parametrize("language", ["numpy", "c", "batch", "casadi"])
@pytest.mark.parametrize("name", [*SIX, "fiala"])
def test_relaxation_lengths_are_those_among_the_quantities(name, language):
    effects = model_named(name).effects.keys() & {"relax_lon", "relax_lat", "relax_mf"}
    tire, code = lagging(name, *effects, REL_LEN_LON=0.3, REL_LEN_LAT=0.5), code_for(name, language)
    rows = np.stack([np.full(9, tire.nominal(key)) for key in tire.inputs])
    rows[tire.inputs.index("Fz")], rows[tire.inputs.index("alpha")] = np.linspace(500.0, 6e3, 9), 0.05
    quantities = dict(zip(code.quantities_names, code.quantities(rows, tire.parameters()), strict=True))
    roles = [quantities[tire.symbolic_model.quantity(f"relaxation_{direction}")] for direction in "xy"]
    assert not np.array_equal(*roles)
    np.testing.assert_allclose(code.relaxation(rows, tire.parameters()), roles, rtol=1e-12)


def recording(n=40, step=0.05, seed=0):
    rng = np.random.default_rng(seed)
    return pd.DataFrame(
        {
            "t": step * np.arange(n),
            "kappa": rng.uniform(-0.2, 0.2, n),
            "alpha": rng.uniform(-0.2, 0.2, n),
            "gamma": rng.uniform(-0.05, 0.05, n),
            "Fz": rng.uniform(1000.0, 5000.0, n),
            "V": rng.uniform(1.0, 20.0, n),
        }
    )


def acting(answer):
    return answer[["kappa_lagged", "alpha_lagged"]].to_numpy()


def test_a_step_is_the_exponential_of_the_rolled_distance():
    t = np.array([0.0, 0.01, 0.02, 0.05, 0.2, 3.0])
    acts = lagged(t, np.full(6, 0.1), np.full(6, 12.0), np.full(6, 0.5), hold=True)
    np.testing.assert_allclose(acts, 0.1, rtol=1e-14)  # the start is a steady state
    slip = np.array([0.0, 0.1, 0.1, 0.1, 0.1, 0.1])
    acts = lagged(t, slip, np.full(6, 12.0), np.full(6, 0.5), hold=True)
    np.testing.assert_allclose(acts[1:], 0.1 * -np.expm1(-12.0 / 0.5 * (t[1:] - t[1])), rtol=1e-13, atol=1e-16)


def test_a_linear_slip_at_constant_speed_is_exact():
    """u = c t: x = c (t - tau) + c tau exp(-t/tau)."""
    t = np.sort(np.random.default_rng(1).uniform(0.0, 1.0, 30)) - 0.0
    t[0] = 0.0
    tau, rise = 0.4 / 5.0, 0.3
    acts = lagged(t, rise * t, np.full(30, 5.0), np.full(30, 0.4), hold=False)
    np.testing.assert_allclose(acts, rise * (t - tau + tau * np.exp(-t / tau)), rtol=1e-12, atol=1e-15)


def test_smooth_inputs_converge_to_the_differential_equation():
    """Of second order, as speed and relaxation length are means between rows."""

    def slip(t):
        return 0.1 * np.sin(7.0 * t) + 0.02 * np.cos(31.0 * t)

    def speed(t):
        return 10.0 + 6.0 * np.sin(3.0 * t)

    def sigma(t):
        return 0.5 + 0.3 * np.cos(5.0 * t)

    end = 2.0
    exact = solve_ivp(
        lambda t, x: speed(t) / sigma(t) * (slip(t) - x),
        (0.0, end),
        [slip(0.0)],
        rtol=1e-12,
        atol=1e-14,
        method="DOP853",
    ).y[0, -1]
    errors = []
    for n in (100, 200, 400, 800):
        t = np.linspace(0.0, end, n + 1)
        errors.append(abs(lagged(t, slip(t), speed(t), sigma(t), hold=False)[-1] - exact))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert (ratios > 3.5).all()
    assert (ratios < 4.5).all()
    assert errors[-1] < 1e-5


@pytest.mark.parametrize("hold", [True, False])
def test_states_are_constant_at_standstill(hold):
    t = np.arange(6.0)
    slip, speed = np.array([0.0, 0.1, 0.1, -0.3, 0.2, 0.2]), np.array([2.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    acts = lagged(t, slip, speed, np.full(6, 3.0), hold=hold)
    assert abs(acts[2] - slip[2]) > 0.01
    np.testing.assert_allclose(acts[3:], acts[2], rtol=1e-14)


@pytest.mark.parametrize("hold", [True, False])
def test_the_rolling_direction_does_not_matter(hold):
    table = recording()
    sigma = np.full(len(table), 0.4)
    t, slip, speed = (table[name].to_numpy() for name in ("t", "alpha", "V"))
    np.testing.assert_array_equal(lagged(t, slip, -speed, sigma, hold=hold), lagged(t, slip, speed, sigma, hold=hold))


@pytest.mark.parametrize("hold", [True, False])
def test_without_a_length_a_slip_acts_at_once(hold):
    table = recording()
    t, slip, speed = (table[name].to_numpy() for name in ("t", "alpha", "V"))
    for length in (0.0, AT_ONCE):
        np.testing.assert_array_equal(lagged(t, slip, speed, np.full(len(t), length), hold=hold), slip)
    some = np.where(np.arange(len(t)) % 4 == 0, 0.0, 0.4)
    acts = lagged(t, slip, 0 * speed, some, hold=hold)
    np.testing.assert_array_equal(acts[some == 0], slip[some == 0])  # even at standstill


@pytest.mark.parametrize("hold", [True, False])
def test_a_length_that_vanishes_is_the_limit_of_short_ones(hold):
    table = recording()
    t, slip, speed = (table[name].to_numpy() for name in ("t", "alpha", "V"))
    short = lagged(t, slip, speed, np.full(len(t), 1.1 * AT_ONCE), hold=hold)
    # Held inputs act from the time of their row, so the inputs of the previous row act in a row.
    np.testing.assert_allclose(short[1:], slip[:-1] if hold else slip[1:], rtol=0, atol=1e-4)


RECORDING = st.lists(
    st.tuples(st.floats(-0.2, 1.0), st.floats(-1.0, 1.0), st.floats(-50.0, 50.0), st.floats(0.0, 5.0)),
    min_size=1,
    max_size=30,
)


@settings(max_examples=100)
@given(rows=RECORDING, hold=st.booleans())
def test_lagged_slips_are_within_the_range_of_the_inputs(rows, hold):
    h, slip, speed, sigma = np.array(rows).T
    acts = lagged(np.cumsum(h), slip, speed, sigma, hold=hold)
    assert acts[0] == slip[0]
    assert slip.min() - 1e-14 <= acts.min()
    assert acts.max() <= slip.max() + 1e-14


@settings(max_examples=100)
@given(rows=RECORDING, hold=st.booleans(), size=st.floats(-3.0, 3.0))
def test_the_lag_is_linear_in_the_slip(rows, hold, size):
    h, slip, speed, sigma = np.array(rows).T
    once, other = lagged(np.cumsum(h), slip, speed, sigma, hold=hold), lagged(np.cumsum(h), h, speed, sigma, hold=hold)
    both = lagged(np.cumsum(h), size * slip + h, speed, sigma, hold=hold)
    np.testing.assert_allclose(both, size * once + other, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("effects", [("relax_lat", "relax_lon"), ("relax_load",), ("relax_mf",)], ids="+".join)
def test_held_inputs_require_no_step_size(name, effects):
    """Rows every 50 ms, each held, are the same as rows every 1 ms."""
    tire, coarse = lagging(name, *effects), recording(30, 0.05)
    fine = coarse.loc[coarse.index.repeat(50)].reset_index(drop=True).assign(t=0.001 * np.arange(50 * len(coarse)))
    expected, answer = (tire.evaluate(table, hold=True) for table in (coarse, fine))
    columns = ["kappa_lagged", "alpha_lagged", *tire.outputs]
    difference = answer[columns].iloc[::50].to_numpy() - expected[columns].to_numpy()
    assert np.max(np.abs(difference) / np.abs(expected[columns]).max().to_numpy()) < 1e-9
    at_once = tire.evaluate(coarse, steady=True)
    assert np.max(np.abs(at_once["Fy"] - expected["Fy"])) > 500.0  # the lag has an influence


@pytest.mark.parametrize("name", SIX)
def test_transient_forces_are_the_steady_forces_at_the_lagged_slips(name):
    tire, table = lagging(name, "relax_lat", "relax_lon"), recording()
    answer = tire.evaluate(table)
    at = table.drop(columns="t").assign(kappa=answer["kappa_lagged"], alpha=answer["alpha_lagged"])
    pd.testing.assert_frame_equal(tire.evaluate(at)[list(tire.outputs)], answer[list(tire.outputs)])
    pd.testing.assert_frame_equal(answer[list(table)], table)  # the inputs are returned unchanged


@pytest.mark.parametrize("name", SIX)
def test_each_effect_has_its_slip_and_its_length(name):
    table = recording()
    t, speed = table["t"].to_numpy(), table["V"].to_numpy()
    plain = lagging(name).evaluate(table)
    lengths = {"relax_lat": (0 * t, 0 * t + 0.45), "relax_lon": (0 * t + 0.2, 0 * t),
           "relax_load": (0 * t, 0.45 * (1 + 0.4 * plain["dfz"].to_numpy())),
           "relax_mf": (plain["sigma_x"].to_numpy(), plain["sigma_y"].to_numpy())}  # fmt: skip
    for effect, (long, side) in lengths.items():
        answer = lagging(name, effect).evaluate(table)
        np.testing.assert_allclose(answer[["sigma_kappa", "sigma_alpha"]].to_numpy().T, [long, side], rtol=1e-12)
        kappa = lagged(t, table["kappa"].to_numpy(), speed, long, hold=False)
        alpha = np.arctan(lagged(t, np.tan(table["alpha"].to_numpy()), speed, side, hold=False))
        np.testing.assert_allclose(acting(answer).T, [kappa, alpha], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("name", SIX)
@pytest.mark.parametrize("hold", [True, False])
def test_where_time_goes_backward_another_recording_begins(name, hold):
    tire, first, second = lagging(name, "relax_mf"), recording(seed=1), recording(seed=2)
    whole = tire.evaluate(pd.concat([first, second], ignore_index=True), hold=hold)
    alone = pd.concat([tire.evaluate(table, hold=hold) for table in (first, second)], ignore_index=True)
    pd.testing.assert_frame_equal(whole, alone, check_exact=True)


@pytest.mark.parametrize("hold", [True, False])
def test_a_segment_begins_at_its_own_start(hold):
    """After a gap in time as if the segment were alone."""
    table, starts = recording(), np.zeros(40)
    t, slip, rate = table["t"].to_numpy() + 5.0 * (np.arange(40) >= 17), table["alpha"].to_numpy(), np.full(40, 9.0)
    starts[[0, 17]] = 0.3, -0.2
    whole = followed(t, slip, rate, starts, hold=hold, begins=segment_starts(t)).value
    parts = [
        followed(t[part], slip[part], rate[part], starts[part], hold=hold).value
        for part in np.split(np.arange(40), [17])
    ]
    np.testing.assert_allclose(whole, np.concatenate(parts), rtol=1e-13)


@pytest.mark.parametrize("name", SIX)
def test_steady_rows_are_independent(name):
    table = recording()
    tires = {effect: lagging(name, effect) for effect in ("relax_lat", "relax_lon", "relax_load", "relax_mf")}
    expected = lagging(name).evaluate(table)
    assert not {"kappa_lagged", "alpha_lagged"} & set(expected)  # a tire without the effect reports no lag
    forces = list(lagging(name).outputs)
    for tire in tires.values():
        assert tire.lags
        for answer in (tire.evaluate(table, steady=True), tire.evaluate(table.drop(columns="t"))):
            pd.testing.assert_frame_equal(answer[forces], expected[forces], check_exact=True)
            assert "alpha_lagged" not in answer


@pytest.mark.parametrize("signs", ["adapted-sae", "sae"])
def test_lagged_slips_are_returned_in_the_signs_of_the_table(signs):
    tire, table = lagging("mf61", "relax_lat", "relax_lon"), recording()
    way = -1.0 if signs == "sae" else 1.0
    answer = tire.evaluate(table.assign(alpha=way * table["alpha"], Fz=way * table["Fz"]), signs=signs)
    expected = tire.evaluate(table)
    np.testing.assert_allclose(way * answer["alpha_lagged"], expected["alpha_lagged"], rtol=1e-12)
    np.testing.assert_allclose(answer["kappa_lagged"], expected["kappa_lagged"], rtol=1e-12)
    np.testing.assert_allclose(-answer["Fy"], expected["Fy"], rtol=1e-10)


def test_a_time_that_is_not_finite_is_rejected():
    table = recording()
    table.loc[3, "t"] = np.nan
    with pytest.raises(DataError, match=r"row 4: t is NaN \(1 of 40 rows\)"):
        lagging("mf61", "relax_lat").evaluate(table)
    lagging("mf61").evaluate(table)  # the time is ignored if no effect reads it


def test_a_recording_without_rows_is_rejected():
    assert lagging("mf61", "relax_lat").evaluate(recording().iloc[:0]).shape[0] == 0
    row = lagging("mf61", "relax_lat").evaluate(recording().iloc[:1])
    assert row["alpha_lagged"].iloc[0] == pytest.approx(row["alpha"].iloc[0], rel=1e-15)
