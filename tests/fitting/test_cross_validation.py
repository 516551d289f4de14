"""Cross-validation holds out whole operating conditions and predicts them."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.fitting import cross_validate, cross_validation
from tirefmu.measurements import Noise, group_by_condition
from tirefmu.measurements.operating_conditions.levels import MAX_LEVELS

LOADS, CAMBERS = (220.0, 400.0, 600.0, 800.0, 1000.0, 1120.0), (0.0, 2.0, 4.0)


def test_a_true_model_predicts_out_of_sample(known, make):
    recording = make.sideways(known, loads=LOADS, cambers=CAMBERS, noise=Noise())
    (held,) = cross_validate([recording], "mf96", effects=make.effects, nominal=make.nominal)
    assert (held.recording, held.channel, held.unit, held.rows) == (recording.source, "Fy", "N", len(recording))
    assert 0.98 * held.in_sample < held.held_out < 1.1 * held.in_sample


def test_each_condition_is_held_out_once_and_completely(known, make, monkeypatch):
    recording = make.sideways(known, loads=LOADS, cambers=CAMBERS)
    conditions = group_by_condition(recording, most_levels=MAX_LEVELS).labels
    assert len(set(conditions)) == 18
    seen, run = [], cross_validation.fit

    def recorded(recordings, model, **options):
        seen.append([table.table.index for table in recordings])
        return run(recordings, model, **options)

    monkeypatch.setattr(cross_validation, "fit", recorded)
    cross_validate([recording], "mf96", folds=3, effects=make.effects)
    whole, *parts = seen
    assert len(whole[0]) == len(recording)
    held_out = [set(recording.table.index) - set(part[0]) for part in parts]
    assert len(held_out) == 3
    assert sum(len(rows) for rows in held_out) == len(recording)  # each once
    assert set().union(*held_out) == set(recording.table.index)
    for rows in held_out:
        chosen = np.isin(recording.table.index, list(rows))
        assert not set(conditions[chosen]) & set(conditions[~chosen])
        assert len(set(conditions[chosen])) == 6


def test_nominal_values_are_those_of_the_fit_of_all_data(known, make, monkeypatch):
    nominal_values, run = [], cross_validation.fit

    def recorded(recordings, model, **options):
        nominal_values.append(options.get("nominal"))
        return run(recordings, model, **options)

    monkeypatch.setattr(cross_validation, "fit", recorded)
    cross_validate([make.sideways(known, loads=LOADS)], "mf96", folds=2, effects=make.effects)
    assert nominal_values[0] is None
    assert nominal_values[1] == nominal_values[2]
    assert set(nominal_values[1]) == {"Fz0", "R0"}


@pytest.mark.parametrize("folds", [0, 1, 50])
def test_invalid_numbers_of_folds_are_rejected(known, make, folds):
    with pytest.raises(FitError, match=r"at least two are required|operating conditions in one recording"):
        cross_validate([make.sideways(known)], "mf96", folds=folds, effects=make.effects)
