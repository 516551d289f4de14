"""States of added effects: their course over a recording, held or linear, and their equilibrium."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from tirefmu.boundary.errors import EffectError
from tirefmu.symbolic.added import library, read_effect
from tirefmu.tires import Tire, convert_signs, read_tir
from tirefmu.tires.code import code_for
from tirefmu.tires.evaluation import quantities

from ..relatives import slow_but

#: Values at which each effect of the library with states has an influence.
ACTIVE = {
    "heat_friction": {"HMU": 0.2, "HTAU": 6.0, "HSLOW": 0.5, "HBODY": 20.0, "HLOAD": 0.5, "HCOOL": 0.02},
    "heat_stiffness": {"HK": 0.2, "HTAU": 6.0},
    "slip_history": {"SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.08, "SHKY": 0.08},
    "hysteresis_force": {"HFY": 0.03, "HFPLAY": 0.02, "HFARM": -0.1},
    "load_lag": {"LLMU": 1.0, "LLK": 0.8, "LLDIR": 0.6},
    "break_in": {"BIMU": 0.2, "BIWORK": 2.5},
    "carcass_2nd_order": {"CASIG": 0.3, "CAFREQ": 60.0, "CADAMP": 0.2},
}
#: Step with held inputs, s: an oscillation is seen before it has ended.
STEP = {"carcass_2nd_order": 0.02}
#: Largest error of a held step of 0.5 s against small ones, where forces or the state itself determine its rate.
BOUND = {"heat_friction": 1e-5, "heat_stiffness": 1e-5, "break_in": 1e-5, "load_lag": 1e-5}
#: Two nodes: the tread heats the carcass, which cools to a measured temperature; friction falls with both.
TWO_NODES = """
name = "two_nodes"
physics = "tread and carcass"
[coefficients]
TNMU = {description = "friction", unit = "1/K", lower = -0.1, upper = 0.1}
TNHEAT = {description = "heating", unit = "K/J", lower = 0.0, upper = 0.1, neutral = 0.003}
TNTAU = {description = "time constant of the tread", unit = "s", lower = 0.1, upper = 60.0, neutral = 2.0}
TNBODY = {description = "time constant of the carcass", unit = "s", lower = 1.0, upper = 600.0, neutral = 40.0}
TNFIRST = {description = "carcass at the start", unit = "degC", lower = 0.0, upper = 100.0, neutral = 30.0}
[states.carcass]
kind = "heat"
drive = "(tread - carcass)/TNBODY"
rate = "1/TNBODY"
ambient = "T"
start = "TNFIRST"
unit = "degC"
[states.tread]
kind = "heat"
drive = "TNHEAT*sliding_power"
rate = "(1 + 0.01*abs(V))/TNTAU"
ambient = "carcass"
unit = "degC"
[[acts]]
on = "friction_y"
factor = "exp(-TNMU*(tread - 50))"
"""
#: One model for all tests: a printed model takes seconds.
ADDED = (*library().values(), read_effect(TWO_NODES, "two_nodes.toml"))
SIZE = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
BODY = {**SIZE, "SIGX": 0.2, "SIGY": 0.4}


def tire_with(*effects, lags=True, **values):
    relaxation = {"relax_lat", "relax_lon"} if lags else set()
    given = {**BODY, **{key: value for effect in effects for key, value in ACTIVE.get(effect, {}).items()}, **values}
    return Tire("mf61", given, effects={*effects, *relaxation}, added=ADDED)


def levels(n=12, seed=3, step=0.5):
    """Return inputs that jump at every step."""
    rng = np.random.default_rng(seed)
    return pd.DataFrame(
        {
            "t": step * np.arange(n), "alpha": rng.uniform(-0.2, 0.2, n), "kappa": rng.uniform(-0.1, 0.1, n),
            "Fz": rng.uniform(2000.0, 6000.0, n), "V": rng.uniform(5.0, 20.0, n),
        }
    )  # fmt: skip


def split(table, parts):
    """Return the same held inputs in smaller steps."""
    h = table["t"].iloc[1] - table["t"].iloc[0]
    fine = table.loc[table.index.repeat(parts)].reset_index(drop=True)
    return fine.assign(t=h / parts * np.arange(len(fine)))


@pytest.mark.parametrize("lags", [True, False], ids=["lagged", "direct"])
@pytest.mark.parametrize("name", slow_but(["slip_history", "carcass_2nd_order"], ACTIVE))
def test_held_inputs_require_no_step_size(name, lags):
    tire, coarse = tire_with(name, lags=lags), levels(step=STEP.get(name, 0.5))
    once, often = tire.evaluate(coarse, hold=True), tire.evaluate(split(coarse, 20), hold=True).iloc[::20]
    for column in (*tire.states, "Fy"):
        difference = np.abs(once[column].to_numpy() - often[column].to_numpy()).max()
        assert difference <= BOUND.get(name, 1e-12) * np.abs(often[column]).max(), column
    steady = tire_with(lags=lags).evaluate(coarse, hold=True)
    assert np.abs(steady["Fy"] - once["Fy"]).max() > 30.0  # the effect has an influence


@pytest.mark.slow
def test_a_step_with_strong_feedback_is_halved():
    """Friction falls so much with heat that an iteration over a long step finds no values."""
    tire = tire_with("heat_friction", lags=False, HMU=2.0, HTAU=1.0, HLOAD=0.0, HCOOL=0.0)
    coarse = pd.DataFrame({"t": 60.0 * np.arange(3), "alpha": [0.0, 0.2, 0.2], "Fz": 6000.0, "V": 30.0})
    once, often = tire.evaluate(coarse, hold=True), tire.evaluate(split(coarse, 100), hold=True).iloc[::100]
    np.testing.assert_allclose(once["tread_heat"], often["tread_heat"], rtol=BOUND["heat_friction"])


def test_a_state_without_a_value_is_not_a_number():
    """A sum grows with the square of the force that grows with it: beyond all bounds in finite time."""
    text = '[states.late]\nkind = "accumulation"\ndrive = "OWNLEN*(Fy/100)**2"\n'
    text = HEAD.replace("{}", "{flips = true}") + text + '[[acts]]\non = "Fy"\nterm = "GAIN*FNOMIN*late"\n'
    effects = (read_effect(text, "own.toml"),)
    tire = Tire("mf96", {**SIZE, "GAIN": 1.0, "OWNLEN": 1.0}, effects=["own"], added=effects)
    missing = tire.evaluate(levels(4))["Fy"].isna()
    assert missing.any()
    assert missing.is_monotonic_increasing  # no value returns


def smooth(n, end=3.0):
    t = np.linspace(0.0, end, n)
    return pd.DataFrame(
        {
            "t": t, "alpha": 0.15 * np.sin(2.0 * t), "kappa": 0.03 * np.sin(3.1 * t),
            "Fz": 4000.0 + 1500.0 * np.sin(1.3 * t), "V": 15.0 + 3.0 * np.cos(t), "T": 25.0 + t,
        }
    )  # fmt: skip


@pytest.mark.parametrize(
    "name",
    slow_but(
        ["slip_history", "carcass_2nd_order"],
        ["heat_friction", "slip_history", "load_lag", "break_in", "two_nodes", "carcass_2nd_order"],
    ),
)
def test_the_course_converges_to_the_differential_equations(name):
    """Without lagged slips, the lines state_derivative are the right sides of the differential equations."""
    tire = tire_with(name, lags=False, **({"TNMU": 0.005} if name == "two_nodes" else {}))
    code, parameters, states = code_for(tire.symbolic_model, "c"), tire.parameters(), tire.states
    fine = smooth(1201, end=1.5)

    def rates(t, x):
        row = {key: np.interp(t, fine["t"], fine[key]) for key in fine} | dict(zip(states, x, strict=True))
        inputs = np.array([[row.get(key, tire.nominal(key))] for key in tire.inputs])
        values = dict(zip(code.quantities_names, code.quantities(inputs, parameters)[:, 0], strict=True))
        return [values[f"{state}_derivative"] for state in states]

    answer = tire.evaluate(fine)
    start = answer[list(states)].iloc[0].to_numpy(dtype=float)
    exact = solve_ivp(rates, (0.0, 1.5), start, rtol=1e-5, atol=1e-7, max_step=0.05).y[:, -1]
    for column, value in zip(states, exact, strict=True):
        assert answer[column].iloc[-1] == pytest.approx(value, rel=3e-4, abs=1e-4), column


def test_a_recording_starts_in_equilibrium_and_again_where_time_goes_back():
    tire, table = tire_with("heat_friction", "slip_history"), levels(6)
    steady = tire.evaluate(table, steady=True)
    answer = tire.evaluate(table)
    assert answer["tread_heat"].iloc[0] == pytest.approx(steady["tread_heat"].iloc[0], rel=1e-12)
    assert np.abs(steady["tread_heat_derivative"]).max() < 1e-9 * steady["tread_heat_target"].max()
    twice = tire.evaluate(pd.concat([table, table], ignore_index=True))
    np.testing.assert_allclose(twice["Fy"].iloc[6:], answer["Fy"], rtol=1e-12)
    np.testing.assert_allclose(tire.forces(**{k: table[k] for k in ("alpha", "kappa", "Fz", "V")}).Fy, steady["Fy"])


def test_a_start_value_replaces_the_equilibrium():
    tire = tire_with("two_nodes", TNFIRST=45.0, TNMU=0.004)
    answer = tire.evaluate(smooth(50))
    assert answer["carcass"].iloc[0] == 45.0
    assert answer["tread"].iloc[0] == pytest.approx(45.0, abs=0.5)  # in equilibrium with the carcass
    assert (np.diff(answer["carcass"][:10]) < 0.0).all()


def test_slip_history_is_higher_while_slip_grows_whatever_the_rate():
    tire = tire_with("slip_history", lags=False)
    forces = {}
    for end in (4.0, 40.0):
        t = np.linspace(0.0, end, 801)
        alpha = 0.15 * np.sin(2.0 * np.pi * t / end)
        answer = tire.evaluate(pd.DataFrame({"t": t, "alpha": alpha, "Fz": 4000.0, "V": 15.0}))
        # The rising and the falling branch of each half wave at equal slip, in every second half wave.
        forces[end] = answer["Fy"].to_numpy()
        out, back = np.abs(answer["Fy"].iloc[[100, 500]]), np.abs(answer["Fy"].iloc[[300, 700]])
        assert (out.to_numpy() > 1.02 * back.to_numpy()).all()
    # Ten times slower: the contact follows more closely, the loop is the same.
    assert np.abs(forces[4.0] - forces[40.0]).max() < 0.03 * np.abs(forces[40.0]).max()


def test_the_follower_of_a_play_is_behind_the_slip_by_at_most_the_width():
    """One step through the whole play, held inputs, and a second recording that starts again in the middle."""
    tire = tire_with("hysteresis_force", lags=False, HFWID=0.05, HFLEN=0.01)
    alpha = [0.0, 0.2, 0.2, 0.1, 0.1, -0.15, -0.15, 0.0]
    table = pd.DataFrame({"t": 0.5 * np.arange(8), "alpha": alpha, "Fz": 4000.0, "V": 20.0})
    answer = tire.evaluate(pd.concat([table, table], ignore_index=True), hold=True)
    slip, follower = answer["carcass_slip"].to_numpy(), [0.0]
    for value in slip[1:8]:
        follower.append(min(max(follower[-1], value - 0.05), value + 0.05))
    np.testing.assert_allclose(slip[:8] - 0.05 * answer["inner_play"][:8], follower, atol=1e-12)
    np.testing.assert_array_equal(answer["inner_play"][8:], answer["inner_play"][:8])


def test_a_recording_may_have_no_row_or_one():
    for n in (0, 1):
        answer = tire_with("heat_friction", "slip_history", "break_in").evaluate(levels().iloc[:n])
        assert answer["tread_heat"].shape == (n,)


def test_break_in_is_not_recovered():
    tire = tire_with("break_in")
    t = np.linspace(0.0, 20.0, 401)
    alpha = np.where(t < 8.0, 0.15 * np.sin(t), 0.0)
    answer = tire.evaluate(pd.DataFrame({"t": t, "alpha": alpha, "Fz": 4000.0, "V": 15.0}))
    assert (np.diff(answer["sliding_work"]) >= 0.0).all()
    assert answer["mu_y"].iloc[-1] < answer["mu_y"].iloc[0]


def test_an_effect_at_neutral_coefficients_does_nothing():
    plain = tire_with().evaluate(smooth(40))
    for name in ACTIVE:
        answer = Tire("mf61", BODY, effects={name, "relax_lat", "relax_lon"}, added=ADDED).evaluate(smooth(40))
        pd.testing.assert_frame_equal(answer[["Fx", "Fy", "Mz"]], plain[["Fx", "Fy", "Mz"]], rtol=1e-14)


def test_two_effects_share_a_state_that_they_declare_alike():
    tire = tire_with("heat_friction", "heat_stiffness")
    assert tire.states == ("tread_heat", "carcass_heat")
    assert tire.symbolic_model.owned("heat_friction", "heat_stiffness") >= {"HMU", "HK", "HTAU"}


def test_a_tire_file_contains_the_state(tmp_path):
    names, path = ("two_nodes", "slip_history"), tmp_path / "memory.tir"
    values, added = {**SIZE, **ACTIVE["slip_history"], "TNMU": 0.004}, [e for e in ADDED if e.name in names]
    tire = Tire("mf96", values, effects=names, added=added)
    tire.save(path)
    again = read_tir(path)
    assert set(again.states) == set(tire.states)
    table = smooth(30)
    np.testing.assert_allclose(again.evaluate(table)["Fy"], tire.evaluate(table)["Fy"], rtol=1e-12)


@pytest.mark.parametrize("signs", ["sae", "adapted-sae"])
def test_the_signs_of_the_table_do_not_matter(signs):
    tire, table = tire_with("hysteresis_force", "heat_friction"), smooth(40)
    there = tire.evaluate(convert_signs(table, "iso", signs), signs=signs)
    back = convert_signs(there[["Fy", "Mz"]], signs, "iso")
    pd.testing.assert_frame_equal(back, tire.evaluate(table)[["Fy", "Mz"]], rtol=1e-9, atol=1e-9)


LAG = '[states.late]\nkind = "lag"\ndrive = "alpha"\nlength = "OWNLEN"\n'
HEAD = 'name = "own"\nphysics = "own"\n[coefficients]\n'
HEAD += 'OWNLEN = {description = "x", unit = "m", neutral = 0.3}\nGAIN = {}\n'
ACT = '[[acts]]\non = "mu_y"\nfactor = "1 + GAIN*late"\n'
SWING = LAG.replace('"lag"', '"oscillator"').replace("length", "damping") + "frequency = 50\n"
WRONG = {
    "did you mean lag? Known are lag, heat, temperature, accumulation, oscillator, hysteresis, play": LAG.replace(
        '"lag"', '"lagg"'
    ),
    "a lag requires rate or length": LAG.replace('length = "OWNLEN"', ""),
    "an oscillator requires damping": LAG.replace('"lag"', '"oscillator"').replace("length", "frequency"),
    "[states.late_speed] has the name of the speed of an oscillator": SWING + LAG.replace(".late]", ".late_speed]"),
    "an oscillator has no fitted start": SWING.replace("50\n", '50\nstart = "fitted"\n'),
    "a lag has no width": LAG + 'width = "OWNLEN"\n',
    "unknown key 'lenght'": LAG.replace("length", "lenght"),
    "unknown function '__import__'": LAG.replace('"alpha"', '"__import__(os)"'),
    "'Late' in states is not a word of small letters": LAG.replace("states.late", "states.Late"),
    "'exp' is a name of the generated code": LAG.replace("states.late", "states.exp"),
    "drive 'alpha' is no lag of this effect": LAG.replace('"lag"', '"hysteresis"').replace("length", "width"),
    "'t' is a name of the program": LAG.replace("states.late", "states.t"),
    "'kappa_lagged' is a name of the program": LAG.replace("states.late", "states.kappa_lagged"),
    "state other is declared but not used": LAG + LAG.replace("states.late", "states.other"),
    "states.late.drive is []: expected a list of one or two lags": LAG.replace('drive = "alpha"', "drive = []"),
}


@pytest.mark.parametrize("message", WRONG)
def test_a_wrong_state_is_one_clear_line(message):
    with pytest.raises(EffectError) as error:
        read_effect(HEAD + WRONG[message] + ACT, "own.toml")
    assert message in str(error.value)
    assert str(error.value).startswith("own.toml")
    assert "\n" not in str(error.value)


def test_a_state_that_reads_an_unknown_quantity_is_an_error():
    effect = read_effect(HEAD + LAG.replace('"alpha"', '"K_yalfa"') + ACT, "own.toml")
    with pytest.raises(EffectError, match="state late reads 'K_yalfa', which mf96 has not"):
        Tire("mf96", SIZE, effects=["own"], added=(effect,))


def test_an_oscillator_that_forces_drive_is_an_error():
    effect = read_effect(HEAD + SWING.replace('"alpha"', '"Fy"') + ACT, "own.toml")
    with pytest.raises(EffectError, match="state late: an oscillator reads inputs and coefficients only"):
        Tire("mf96", SIZE, effects=["own"], added=(effect,))


def test_the_carcass_overshoots_and_without_mass_it_relaxes():
    """The closed form of a damped oscillation, and the lag that is its limit for a large frequency."""
    t = np.linspace(0.0, 0.4, 81)
    step = pd.DataFrame({"t": t, "alpha": np.where(t > 0.0, 0.01, 0.0), "Fz": 4000.0, "V": 10.0})
    heavy = tire_with("carcass_2nd_order", lags=False, CASIG=0.1, CAFREQ=50.0).evaluate(step, hold=True)
    w, rate = 50.0, 50.0 * 0.2 + 0.5 * 0.1 * 50.0**2 / np.sqrt(10.0**2 + 0.01)
    turn, h = np.sqrt(w**2 - rate**2), t[1:] - t[1]
    closed = np.tan(0.01) * (1.0 - np.exp(-rate * h) * (np.cos(turn * h) + rate / turn * np.sin(turn * h)))
    np.testing.assert_allclose(heavy["carcass_deflection"].iloc[1:], closed, rtol=1e-11, atol=1e-16)
    assert heavy["Fy"].abs().max() > 1.02 * heavy["Fy"].abs().iloc[-1]
    light = tire_with("carcass_2nd_order", lags=False, CASIG=0.4, CAFREQ=3000.0, CADAMP=0.0).evaluate(step, hold=True)
    lag = np.tan(0.01) * -np.expm1(-10.0 * h / 0.4)
    np.testing.assert_allclose(light["alpha_star"].abs().iloc[2:], lag[1:], rtol=2e-2)


def test_a_state_cannot_have_the_name_of_a_line_of_another():
    text = HEAD + LAG + LAG.replace("states.late", "states.late_rate") + ACT.replace("*late", "*late*late_rate")
    with pytest.raises(EffectError, match="state late_rate has the name of a quantity of state late"):
        Tire("mf61", BODY, effects=["own"], added=(read_effect(text, "own.toml"),))


def test_the_library_has_the_names_of_the_contract():
    names = {*ACTIVE, "relax_slip"}
    assert names <= library().keys()
    assert all(library()[name].source for name in names)
    assert quantities(tire_with("heat_friction"), {"alpha": 0.1, "Fz": 4000.0, "V": 15.0})["tread_heat_target"] > 0.25
