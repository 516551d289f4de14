"""Effects with states: their simulation in a diagnosis, errors of a recording that resemble them, and their search."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tirefmu.diagnosis import diagnose, write_report
from tirefmu.diagnosis.probing import candidates_for, is_testable
from tirefmu.diagnosis.signals import FORMULA_SIGNS, Simulator, load_error_responses, signals_of
from tirefmu.diagnosis.unexplained.features import features
from tirefmu.measurements import Recording, with_turn_slip
from tirefmu.symbolic.added import library
from tirefmu.tires import Tire

from .independent import memory_kinds, memory_laws
from .independent.programs import smooth

BASE = ("load_friction", "load_stiffness")
NOMINAL = {"Fz0": 4000.0, "R0": 0.31, "p0": 220e3, "V0": 16.7}
VALUES = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.31, "NOMPRES": 220e3, "INFLPRES": 220e3, "LONGVL": 16.7, "PCY1": 1.4,
    "PDY1": 1.05, "PDY2": -0.15, "PEY1": -0.4, "PKY1": 21.0, "PKY2": 1.8, "QBZ1": 8.0, "QCZ1": 1.1, "QDZ1": 0.11,
}  # fmt: skip
ADDED = tuple(effect for effect in library().values() if effect.detection)
SLIP_HISTORY = {"SHMUX": 0.04, "SHMUY": 0.04, "SHKX": 0.05, "SHKY": 0.05, "SHWID": 0.025, "SHLEN": 0.05}


def tire_with(*effects, **values):
    return Tire("mf61", VALUES | values, effects=(*BASE, *effects), signs=FORMULA_SIGNS, added=ADDED)


def program():
    """Return sweeps at two rates and three loads, with rests, at 25 Hz."""
    parts = []
    for k, load in enumerate((4000.0, 2200.0, 5600.0, 3000.0, 5000.0, 2200.0, 4000.0, 5600.0)):
        seconds = 4.0 if k % 2 else 9.0
        phase = np.arange(0.0, 1.0, 0.04 / seconds)
        alpha = np.concatenate([0.2 * (-1.0) ** (k // 2) * np.sin(2.0 * np.pi * phase), np.zeros(25)])
        parts.append(pd.DataFrame({"alpha": alpha, "Fz": load}))
    table = pd.concat(parts, ignore_index=True).assign(V=16.7)
    table.insert(0, "t", 0.04 * np.arange(len(table)))
    return table


def recorded(tire, seed=1, table=None):
    """Return a program and forces with noise."""
    table, rng = program() if table is None else table, np.random.default_rng(seed)
    channels = ["Fx", "Fy", "Mz"] if "kappa" in table else ["Fy", "Mz"]
    forces = tire.evaluate(table, signs=FORMULA_SIGNS)[channels]
    return table.assign(
        **{
            name: values + 0.006 * values.abs().max() * rng.standard_normal(len(table))
            for name, values in forces.items()
        }
    )


@pytest.mark.parametrize(
    "values",
    [
        {"HMU": 0.15, "HTAU": 4.0, "HSLOW": 0.5, "HBODY": 15.0},
        {"BIMU": 0.1, "BIWORK": 5.0},
        {**SLIP_HISTORY, "LLMU": 0.7, "SIGY": 0.3},
        {"RSIG": 0.5, "RSLIP": 0.08},
    ],
    ids=["heat", "work", "direct", "relaxation"],
)
def test_a_diagnosis_simulates_the_states_as_an_evaluation_does(values):
    """Drives are linear between rows: the error is of second order in their distance."""
    table = recorded(tire_with())
    effects = [effect.name for effect in ADDED if {each.name for each in effect.declarations} & values.keys()]
    effects += ["relax_lat"] if "SIGY" in values else []
    start = tire_with()
    simulator = Simulator(start, signals_of(table, start, FORMULA_SIGNS, smooth=False))
    parameters = start.parameters()
    for name, value in values.items():
        parameters[simulator.index[name]] = value
    forces = simulator.forces(parameters)[list(simulator.signals.channels).index("Fy")]
    exact = tire_with(*effects, **values).evaluate(program(), signs=FORMULA_SIGNS)["Fy"].to_numpy()
    np.testing.assert_allclose(forces, exact, atol=2e-3 * np.abs(exact).max())
    without = simulator.forces(start.parameters())[list(simulator.signals.channels).index("Fy")]
    assert np.abs(forces - without).max() > 0.01 * np.abs(exact).max()
    assert np.array_equal(forces, Simulator(start, simulator.signals).forces(parameters)[0])  # whatever was before


def test_what_lengths_depend_on_may_be_asked_for_by_a_generator():
    model = tire_with().symbolic_model
    assert model.reached(name for name in ("sigma_kappa", "sigma_alpha")) == model.reached(
        ["sigma_kappa", "sigma_alpha"]
    )


def test_the_response_to_a_load_error_follows_the_direction_of_slip():
    tire = tire_with()
    signals = signals_of(recorded(tire), tire, FORMULA_SIGNS, smooth=False)
    simulator = Simulator(tire, signals)
    at_once = load_error_responses(simulator, tire.parameters())[0, :, 0]
    growing = np.gradient(np.abs(signals.named()["alpha"]), signals.t) > 0.05
    falling = np.gradient(np.abs(signals.named()["alpha"]), signals.t) < -0.05
    side = np.sign(signals.named()["alpha"])
    assert np.mean((side * at_once)[growing] > 0.0) > 0.95
    assert np.mean((side * at_once)[falling] < 0.0) > 0.95


@pytest.mark.slow
def test_the_history_of_slip_is_identified_and_shown(tmp_path):
    table = recorded(tire_with("slip_history", **SLIP_HISTORY))
    result = diagnose(table, signs=FORMULA_SIGNS, effects=BASE, nominal=NOMINAL)
    assert [one.effect for one in result.found] == ["slip_history"]
    assert result.delivered
    found = result.in_signs(FORMULA_SIGNS).found[0].coefficients
    assert found["SHMUY"].value == pytest.approx(0.04, abs=0.012)
    assert result.gap["holdout"]["Fy"]["after"] < 0.5 * result.gap["holdout"]["Fy"]["before"]
    page = write_report(result, table.assign(Fy=table["Fy"]), tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<h2>Memory</h2>" in page


@pytest.mark.slow
def test_hysteresis_of_one_axis_leaves_the_other_one():
    """Both slips take turns; the brake force has no hysteresis."""
    table = program()
    part = np.arange(len(table)) // 150 % 2
    braking = 0.12 * np.sin(np.arange(len(table)) / 11.0)
    table = table.assign(alpha=table["alpha"] * (part == 0), kappa=braking * (part == 1))
    table = recorded(tire_with("slip_history", **SLIP_HISTORY | {"SHMUX": 0.0, "SHKX": 0.0}), table=table)
    result = diagnose(
        table, signs=FORMULA_SIGNS, effects=BASE, nominal=NOMINAL, candidates=["slip_history", "heat_friction"]
    )
    assert [one.effect for one in result.found] == ["slip_history"]
    assert set(result.found[0].coefficients) == {"SHMUY", "SHKY", "SHWID"}
    assert result.delivered
    errors = result.gap["train"]
    assert errors["Fy"]["after"] < 0.7 * errors["Fy"]["before"]
    assert errors["Fx"]["after"] == pytest.approx(errors["Fx"]["before"], rel=0.01)


def test_a_load_that_leaves_late_is_followed_at_once():
    """The distance is exp(LLDIR) times LLEN while the load falls, and as many times shorter while it grows."""
    tire = tire_with("load_lag", LLMU=1.0, LLEN=1.0, LLDIR=0.7)
    t = np.arange(0.0, 4.0, 0.001)
    table = pd.DataFrame({"t": t, "alpha": 0.05, "Fz": np.where((t > 0.5) & (t < 2.0), 5000.0, 3000.0), "V": 10.0})
    late = tire.evaluate(table, signs=FORMULA_SIGNS, hold=True)["late_load"].to_numpy()
    for time, share in ((0.5, (late - 3000.0) / 2000.0), (2.0, (5000.0 - late) / 2000.0)):
        followed = t[(t > time) & (share > 1.0 - np.exp(-1.0))][0] - time
        assert followed == pytest.approx(0.1 * np.exp(-0.7 if time == 0.5 else 0.7), abs=0.003)


@pytest.mark.slow
def test_a_moving_carcass_is_no_skew_and_no_relaxation():
    """A true spring is loaded by a force that saturates; the recording has a skew besides."""
    rng, rate = np.random.default_rng(4), 100.0
    t = np.arange(2600) / rate
    parts = [0.05 * np.sin(2.0 * np.pi * np.outer(t, rng.uniform(0.4, 7.0, 5)) + rng.uniform(0.0, 6.0, 5)).sum(axis=1),
             0.2 * np.sin(1.7 * t)]  # fmt: skip
    alpha = np.where(t % 6.0 < 3.0, *parts)
    load = np.repeat([4000.0, 2500.0, 5500.0, 3200.0], 650)
    speed = np.repeat([10.0, 18.0, 10.0, 18.0], 650)  # at one speed, the lag of the spring is nearly a delay
    table = pd.DataFrame({"t": t, "alpha": smooth(alpha, 3.0), "Fz": smooth(load, 8.0), "V": smooth(speed, 8.0)})
    tire, specimen = tire_with(), SimpleNamespace(radius=0.31)
    acting = memory_laws.carcass_slip(1.0, specimen, {name: table[name].to_numpy() for name in table})
    forces = tire.evaluate(table.assign(alpha=acting).drop(columns="t"), signs=FORMULA_SIGNS)
    for name, size in (("Fy", 25.0), ("Mz", 1.0)):
        late = np.interp(t - 0.009, t, forces[name])
        table[name] = late + size * rng.standard_normal(len(t))
    result = diagnose(
        table, signs=FORMULA_SIGNS, effects=BASE, nominal=NOMINAL,
        candidates=["carcass_2nd_order", "relax_lat", "relax_slip", "hysteresis_force"],
    )  # fmt: skip
    assert [one.effect for one in result.found] == ["carcass_2nd_order"]
    assert result.delivered
    assert result.found[0].coefficients["CAFREQ"].value == pytest.approx(45.0, rel=0.1)
    assert result.recording["skew"] == pytest.approx(0.009, abs=0.002)


def test_a_load_error_in_the_direction_of_slip_is_no_effect():
    table = recorded(tire_with())
    direction = np.tanh(np.gradient(np.abs(table["alpha"]), table["t"]) / 0.05)
    result = diagnose(
        table.assign(Fz=table["Fz"] * (1.0 + 0.004 * direction)), signs=FORMULA_SIGNS, effects=BASE, nominal=NOMINAL
    )
    assert result.found == ()


def test_a_constant_speed_is_no_variable_of_a_formula():
    tire = tire_with()
    signals = signals_of(recorded(tire), tire, FORMULA_SIGNS)
    inputs, row = signals.inputs.copy(), signals.names.index("V")
    for share, expected in ((0.01, False), (0.2, True)):
        inputs[row] = tire.nominal("V") * (1.0 + share * np.linspace(-0.5, 0.5, inputs.shape[1]))
        many = features(
            replace(signals, inputs=inputs, origin=replace(signals.origin, recorded=signals.origin.recorded | {"V"})),
            tire,
        )
        assert any("V" in one.depends_on for ones in many for one in ones) == expected


def test_the_memory_suite_hides_each_effect_with_the_errors_of_a_recording():
    kinds = memory_kinds.NUMBER_OF_CASES
    assert sum(kinds.values()) >= 40
    assert kinds["null"] >= 12
    case = memory_kinds.case_of("single", 2)
    assert case.hidden == ("slip_history",)
    pd.testing.assert_frame_equal(case.table, memory_kinds.case_of("single", 2).table)
    assert np.isfinite(case.table.to_numpy()).all()
    assert np.isfinite(case.test.to_numpy()).all()


def test_fast_recordings_hide_a_moving_carcass_and_turn_slip_without_phit():
    for number, hidden in ((0, "carcass_2nd_order"), (1, "turn_slip")):
        case = memory_kinds.case_of("fast", number)
        assert case.hidden == (hidden,)
        assert "phit" not in case.table
        assert np.median(np.diff(case.table["t"])) < 0.011
        assert np.isfinite(case.test.to_numpy()).all()


def test_a_carcass_requires_a_fast_recording_and_turn_slip_is_derived_from_the_rate_of_alpha():
    start = tire_with()
    carcass = candidates_for(start)["carcass_2nd_order"]
    turning = replace(candidates_for(start)["turn_slip"], has_states=True)
    table = recorded(tire_with())
    for faster, fast in ((4.0, True), (1.0, False)):
        recording = with_turn_slip(Recording(table.assign(t=table["t"] / faster), FORMULA_SIGNS, "made"))
        signals = signals_of(recording.table, start, FORMULA_SIGNS, derived={"phit"})
        assert is_testable(signals, start, carcass) == fast
        assert "phit" not in signals.origin.recorded  # no formula reads it
        assert is_testable(signals, start, turning)
