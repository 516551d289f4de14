"""Sweeps, plateaus and transitions are found from the inputs alone."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation, binary_erosion

from tirefmu.measurements import Recording, VirtualBench, alpha_sweeps, kappa_sweeps, phases, steady_points, transitions
from tirefmu.tires import published

SLACK = 25  # rows: a level is reached once it is within the channel's tolerance, after the median of 0.2 s


@pytest.mark.parametrize("change", [0.0, 1.0])
@pytest.mark.parametrize(
    ("channel", "levels"),
    [
        ("gamma", np.radians([0.0, 2.0, 4.0, 0.0, 3.44])),
        *(("gamma", np.radians([0.0, 2.0, 0.0, 2.0 + step])) for step in (0.5, 1.0, 1.2, 1.5)),
        *(("p", 1e3 * np.array([83.0, 97.0, 70.0, 97.0 - step])) for step in (3.0, 4.0, 6.0, 8.0, 10.0)),
        *(("Fz", np.array([250.0, 1000.0, 500.0, 1000.0 * (1.0 + share)])) for share in (0.05, 0.1, 0.15)),
    ],
)
def test_no_held_row_is_a_transition_because_another_level_has_more_rows(channel, levels, change):
    """The last two conditions are those of a shorter run on the same bench. `change`: s from one level to the next."""
    rows, ramp = [8000] * (len(levels) - 2) + [1600] * 2, round(change / 0.01)
    values = np.full(rows[0], levels[0])
    held = np.full(rows[0], True)
    for before, level, stay in zip(levels, levels[1:], rows[1:], strict=False):
        values = np.concatenate([values, np.linspace(before, level, ramp), np.full(stay, level)])
        held = np.concatenate([held, np.full(ramp, False), np.full(stay, True)])
    noise = {"gamma": 5e-4, "p": 200.0, "Fz": 5.0}[channel] * np.random.default_rng(3).standard_normal(len(values))
    t = 0.01 * np.arange(len(values))
    table = pd.DataFrame({"t": t, "alpha": 0.15 * np.sin(t), "kappa": 0.0, "gamma": 0.0, "Fz": 1000.0, "V": 11.0})
    table = table.assign(Fy=-1000.0 * np.tanh(8.0 * table["alpha"])).assign(**{channel: values + noise})
    assert not np.any(transitions(Recording(table, "iso", "made.csv"))[held] != "")


def test_a_slow_change_from_level_to_level_stays_a_transition():
    """A pressure takes 20 s; its rows are far from both levels for longer than a load takes."""
    p = 1e3 * np.concatenate([np.full(6000, 83.0), np.linspace(83.0, 97.0, 2000), np.full(6000, 97.0)])
    t = 0.01 * np.arange(len(p))
    table = pd.DataFrame({"t": t, "alpha": 0.15 * np.sin(t), "Fz": 1000.0, "p": p, "Fy": -900.0 * np.sin(t)})
    found = transitions(Recording(table, "iso", "made.csv")) == "p"
    assert found[6600:7400].all()
    assert not found[:5900].any()
    assert not found[8100:].any()


@settings(max_examples=20)
@given(
    loads=st.lists(st.sampled_from([250.0, 500.0, 700.0, 1100.0, 1550.0]), min_size=1, max_size=4, unique=True),
    cambers=st.lists(st.sampled_from([0.0, 2.0, 4.0]), min_size=1, max_size=3, unique=True),
    seed=st.integers(0, 9),
)
def test_exactly_the_transitions_are_found(make_raw, loads, cambers, seed):
    run = make_raw(loads, cambers, seed=seed)
    found = transitions(run.recording) != ""
    assert found[binary_erosion(run.between, iterations=SLACK + 15)].all()
    assert not found[~binary_dilation(run.between, iterations=SLACK)].any()


def test_each_transition_names_the_input_that_moved(raw):
    names = transitions(raw.recording)
    assert set(names) == {"", "Fz", "gamma"}
    camber = np.degrees(raw.recording.table["gamma"].to_numpy())
    assert (np.abs(camber - 2.0 * np.round(camber / 2.0))[names == ""] < 0.6).all()


def test_settling_extends_each_transition_and_starts_none(raw):
    at_once, settled = transitions(raw.recording) != "", transitions(raw.recording, settling=0.5) != ""
    assert (settled >= at_once).all()
    ends = np.flatnonzero(at_once[:-1] & ~at_once[1:])
    assert settled.sum() == at_once.sum() + 50 * len(ends)
    assert all(settled[end + 1 : end + 51].all() for end in ends)


@settings(max_examples=20)
@given(
    stretches=st.lists(
        st.tuples(st.sampled_from(["hold", "sweep", "jump", "gap"]), st.integers(1, 300)), min_size=1, max_size=6
    )
)
def test_phases_are_all_rows_once_and_in_order(stretches):
    clock, angle, load = [0.0], [0.0], [900.0]
    for kind, rows in stretches:
        for row in range(rows):
            clock.append(clock[-1] + (9.0 if kind == "gap" and not row else 0.01))
            angle.append(angle[-1] + (1e-3 if kind == "sweep" else 0.0))
            load.append(1800.0 if kind == "jump" else 900.0)
    recording = Recording(pd.DataFrame({"t": clock, "alpha": angle, "Fz": load}), "iso", "a.csv")
    found = phases(recording)
    rows = np.arange(len(recording))
    assert np.array_equal(np.concatenate([rows[phase.rows] for phase in found]), rows)
    assert {phase.kind for phase in found} <= {"sweep", "plateau", "transition", "points"}
    starts = {phase.rows.start for phase in found}
    assert {segment.start for segment in recording.segments()} <= starts


@pytest.mark.parametrize("signs", ["sae", "adapted-sae"])
def test_signs_have_no_influence(raw, signs):
    def summary(recording):
        return [(phase.rows, phase.kind, phase.moving) for phase in phases(recording)]

    assert summary(raw.recording.with_signs(signs)) == summary(raw.recording)


def test_a_plateau_is_one():
    table = pd.DataFrame({"t": np.arange(500) / 100.0, "alpha": 0.05, "Fz": 900.0})
    (phase,) = phases(Recording(table, "iso", "a.csv"))
    assert (phase.kind, phase.moving, phase.held) == ("plateau", (), {"alpha": 0.05, "Fz": 900.0})


@pytest.mark.parametrize("slip", ["alpha", "kappa", "phit"])
@pytest.mark.parametrize("still", [500, 6000])
def test_a_sweep_from_a_level_and_back_to_it_is_no_transition(slip, still):
    rest = np.zeros(still)
    values = np.concatenate([rest, 0.2 * np.sin(np.linspace(0.0, 2.0 * np.pi, 1200)), rest])
    table = pd.DataFrame({"t": np.arange(len(values)) / 100.0, slip: values, "Fz": 900.0})
    recording = Recording(table, "iso", "a.csv")
    assert (transitions(recording) == "").all()
    found = phases(recording)
    assert [phase.kind for phase in found] == ["plateau", "sweep", "plateau"]
    sweep = found[1].rows
    # It starts and ends where the slip exceeds the tolerance, or where the window of one second detects the motion.
    assert abs(sweep.start - still) < 60
    assert abs(sweep.stop - still - 1200) < 60


def test_a_slip_between_two_levels_is_in_transition():
    angle = np.radians(np.interp(np.arange(2000), [0, 900, 1000, 2000], [0.0, 0.0, 6.0, 6.0]))
    recording = Recording(pd.DataFrame({"t": np.arange(2000) / 100.0, "alpha": angle}), "iso", "a.csv")
    rows = np.flatnonzero(transitions(recording) == "alpha")
    assert (rows[0], rows[-1]) == pytest.approx((909, 991), abs=3)
    assert [phase.kind for phase in phases(recording)] == ["plateau", "transition", "plateau"]


def test_steps_of_the_slip_angle_separate_plateaus():
    angle = np.repeat(np.radians([0.0, 4.0, 8.0, 2.0]), 400)
    table = pd.DataFrame({"t": np.arange(len(angle)) / 100.0, "alpha": angle, "Fz": 900.0})
    found = phases(Recording(table, "iso", "a.csv"))
    assert [round(np.degrees(phase.held["alpha"])) for phase in found] == [0, 4, 8, 2]
    assert [phase.rows.start for phase in found] == [0, 400, 800, 1200]
    assert {phase.kind for phase in found} == {"plateau"}


@pytest.mark.parametrize(("sweeps", "slip"), [(alpha_sweeps, "alpha"), (kappa_sweeps, "kappa")])
def test_programs_of_the_virtual_bench_are_sweeps(sweeps, slip):
    recording = VirtualBench(published("trento_hoosier"), seed=1).run(sweeps([300.0, 900.0], cambers=[0.0, 0.05]))
    expected = [(segment, "sweep", (slip,)) for segment in recording.segments()]
    assert [(phase.rows, phase.kind, phase.moving) for phase in phases(recording)] == expected


def test_steady_points_are_no_time_series():
    program = steady_points([-0.1, 0.0, 0.1], np.radians([-5.0, 0.0, 5.0]), [300.0, 600.0, 900.0])
    recording = VirtualBench(published("trento_hoosier")).run(program)
    assert {phase.kind for phase in phases(recording)} == {"points"}
    assert (transitions(recording) == "").all()


def test_few_or_no_rows():
    for rows in (0, 1, 10):
        recording = Recording(pd.DataFrame({"alpha": np.zeros(rows), "Fz": np.full(rows, 900.0)}), "iso", "a.csv")
        assert sum(phase.rows.stop - phase.rows.start for phase in phases(recording)) == rows
