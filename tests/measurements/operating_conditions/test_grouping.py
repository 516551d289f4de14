"""The weight of an operating condition does not depend on how often it was recorded."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.measurements import (
    Grouping,
    Recording,
    VirtualBench,
    alpha_sweeps,
    concatenate,
    group_by_condition,
    read_recording,
)
from tirefmu.tires import published


@given(st.lists(st.integers(1, 900), min_size=1, max_size=6))
def test_no_condition_outweighs_the_median_one(counts):
    labels = np.repeat(np.arange(len(counts)), counts)
    weights = Grouping(labels, ((),) * len(counts)).weights()
    assert weights.mean() == pytest.approx(1.0)
    share = weights / weights.max()
    median = sorted(counts)[(len(counts) - 1) // 2]
    for number, count in enumerate(counts):
        (weight,) = set(share[labels == number])
        assert weight == pytest.approx(1.0 if count <= 1.25 * median else median / count)


def test_sweeps_of_different_inputs_are_weighted_separately():
    labels = np.repeat([0, 1, 2, 3], [600, 600, 300, 300])
    kinds = (("alpha",), ("alpha",), ("kappa",), ("kappa",))
    assert (Grouping(labels, ((),) * 4, kinds).weights() == 1.0).all()


def test_unselected_rows_have_weight_zero():
    labels = np.repeat([0, 1], [30, 90])
    rows = np.arange(120) < 60
    weights = Grouping(labels, ((),) * 2).weights(rows)
    assert (weights[~rows] == 0.0).all()
    assert weights[rows].mean() == pytest.approx(1.0)
    assert weights[0] == pytest.approx(weights[30])
    assert (Grouping(labels, ((),) * 2).weights(~(labels >= 0)) == 0.0).all()


@pytest.mark.parametrize("signs", ["iso", "sae"])
def test_a_load_with_five_times_the_rows_does_not_outweigh_the_others(signs):
    program = concatenate([alpha_sweeps([300.0, 600.0, 900.0], [0.0, 0.05]), *[alpha_sweeps([900.0], [0.0])] * 4])
    recording = VirtualBench(published("trento_hoosier"), seed=3).run(program).with_signs(signs)
    groups = group_by_condition(recording)
    assert len(groups.conditions) == 6
    assert sorted(groups.counts) == [1201] * 5 + [5 * 1201]
    assert np.bincount(groups.labels, groups.weights()) == pytest.approx(np.full(6, len(recording) / 6), rel=0.01)
    assert set(groups.moving) == {("alpha",)}
    for number, condition in enumerate(groups.conditions):
        rows = recording.table[groups.labels == number]
        for name, level in condition:
            assert rows[name].median() == pytest.approx(level, abs=0.02 * abs(recording.table[name]).max())


def test_slow_sweeps_are_weighted_down_and_wide_ones_are_not():
    def sweep(number, rows, reach, load):
        angle = np.interp(np.arange(rows) / rows, [0.0, 0.25, 0.75, 1.0], [0.0, reach, -reach, 0.0])
        return pd.DataFrame({"t": 100.0 * number + np.arange(rows) / 100.0, "alpha": angle, "Fz": load})

    parts = [(300, 0.1, 300.0), (300, 0.1, 450.0), (1200, 0.1, 600.0), (600, 0.2, 900.0)]  # the third is slow
    table = pd.concat([sweep(number, *part) for number, part in enumerate(parts)], ignore_index=True)
    groups = group_by_condition(Recording(table, "iso", "a.csv"))
    weights = groups.weights()
    assert len(groups.conditions) == 4
    share = {float(table["Fz"][row]): weights[row] / weights.max() for row in np.flatnonzero(table["t"] % 100 == 0)}
    assert share == pytest.approx({300.0: 1.0, 450.0: 1.0, 600.0: 0.25, 900.0: 1.0}, rel=0.05)


def test_repeated_steady_points_count_once_and_swept_ones_are_unchanged():
    points = pd.DataFrame({"alpha": np.tile([0.0, 0.1, 0.2], 20), "Fz": np.repeat([300.0, 600.0], 30)})
    repeated = pd.concat([points, *[points[points["alpha"] == 0.2]] * 4], ignore_index=True)
    groups = group_by_condition(Recording(repeated, "iso", "a.csv"))
    assert len(groups.conditions) == 6
    assert np.bincount(groups.labels, groups.weights()) == pytest.approx(np.full(6, len(repeated) / 6))
    swept = points.assign(alpha=np.random.default_rng(0).uniform(-0.2, 0.2, 60))
    assert (group_by_condition(Recording(swept, "iso", "a.csv")).weights() == 1.0).all()


def test_an_input_with_many_levels_was_swept_in_steps():
    table = pd.DataFrame({"alpha": np.repeat(np.linspace(-0.3, 0.3, 15), 40), "Fz": np.tile([300.0, 600.0], 300)})
    recording = Recording(table, "iso", "a.csv")
    assert len(group_by_condition(recording).conditions) == 30
    assert group_by_condition(recording, most_levels=12).conditions == ((("Fz", 300.0),), (("Fz", 600.0),))


def test_swept_inputs_define_no_conditions():
    table = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500)})
    groups = group_by_condition(Recording(table, "iso", "a.csv"))
    assert (groups.conditions, groups.moving) == (((),), (("alpha",),))
    assert groups.counts.tolist() == [500]


def test_measured_files_are_grouped_by_their_conditions(data_folder):
    for name, swept, conditions, fewest in (
        ("cornering", "alpha", 5 * 3 * 3, 1200), ("drivebrake", "kappa", 4 * 3 * 3 * 3, 600),
    ):  # fmt: skip
        groups = group_by_condition(read_recording(data_folder / f"{name}.mat"))
        of_sweeps = np.array([kind == (swept,) for kind in groups.moving])
        assert of_sweeps.sum() == conditions
        assert groups.counts[of_sweeps].min() > fewest
        assert groups.counts[~of_sweeps].sum() < 50  # one change of load that was not cut out
