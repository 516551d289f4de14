"""A fit recovers the true tire from data in any signs, and satisfies its bounds and constraints."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording, write_table
from tirefmu.tires import Tire


def differences(tire, truth, inputs):
    """Return the largest difference of each force, relative to the largest force."""
    found, true = (t.in_signs("iso").forces(**inputs) for t in (tire, truth))
    return {name: float(np.max(np.abs(found[name] - true[name])) / np.max(np.abs(true[name]))) for name in true}


# ------------------------------------------------------------------ recovery


@pytest.mark.parametrize("seed", [None, 1])
def test_known_coefficients_are_recovered_from_generic_values(known, make, seed):
    truth = known if seed is None else make.other_tire(seed)
    result = make.fit(make.bench(truth))
    assert result.status == "converged"
    assert [channel.channel for channel in result.channels] == ["Fx", "Fy", "Mz"]
    for channel in result.channels:
        assert channel.r2 > 0.99999
    # Also between the loads, cambers and slips of the program.
    for name, share in differences(result.tire, truth, make.anywhere()).items():
        assert share < 1e-3, name
    for name in ("PCY1", "PDY1", "PDY2", "PKY1", "PKY2", "PCX1", "PDX1", "PKX1", "PVY3", "QBZ1", "QDZ1"):
        assert make.coefficients(result)[name].value == pytest.approx(truth.values[name], rel=0.01), name
        assert make.coefficients(result)[name].determined


@pytest.mark.parametrize("data", ["iso", "adapted-sae", "sae"])
def test_the_signs_of_the_data_do_not_matter(side_fit, make, data):
    reference, recording = side_fit
    result = make.fit(recording.with_signs(data))
    assert result.tire.signs == "iso"
    for name, value in reference.tire.values.items():
        assert result.tire.values[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    assert result.signs == "iso"
    for ours, theirs in zip(result.coefficients, reference.coefficients, strict=True):
        expected = (theirs.guess, theirs.lower, theirs.upper, theirs.value)
        assert (ours.guess, ours.lower, ours.upper, ours.value) == pytest.approx(expected, rel=1e-9, abs=1e-12), ours
        assert (ours.at_bound, ours.determined, ours.stage) == (theirs.at_bound, theirs.determined, theirs.stage)
    side = result.channel(recording.source, "Fy")
    assert side.rmse == pytest.approx(reference.channel(recording.source, "Fy").rmse, rel=1e-6, abs=1e-9)


def test_recordings_of_different_signs_are_combined(known, make):
    whole = make.sideways(known)
    half = np.arange(len(whole)) < len(whole) // 2
    parts = [Recording(whole.table[rows], whole.signs, name) for rows, name in ((half, "one"), (~half, "two"))]
    result = make.fit([parts[0].with_signs("iso"), parts[1].with_signs("sae")])
    assert result.signs == "iso"
    assert {channel.recording for channel in result.channels} == {"one", "two"}
    assert all(channel.r2 > 0.99999 for channel in result.channels)
    assert {"one", "two"} == set(result.tire.about["data"].split(", "))


def test_files_are_read_like_recordings(side_fit, make, tmp_path):
    reference, recording = side_fit
    path = tmp_path / "sideways.csv"
    write_table(recording.table, path)
    result = make.fit(path, signs=recording.signs)
    assert dict(result.tire.values) == dict(reference.tire.values)  # to the last digit
    assert result.channels[0].recording == "sideways.csv"


# ------------------------------------------------------------------ bounds and constraints


def test_bounds_are_satisfied_and_reported(known, make, tmp_path):
    path = make.recipe(
        tmp_path,
        """
        [[stage]]
        name = "tight"
        channels = ["Fy"]
        [stage.free]
        PCY1 = { guess = 1.3, lower = 1, upper = 2 }
        PDY1 = { guess = 1.5, lower = 0.5, upper = 1.7 }
        PKY1 = { guess = 30, lower = 10, upper = 100 }
        PKY2 = { guess = 9, lower = 2.6, upper = 5 }
        """,
    )
    result = make.fit(make.sideways(known), recipe=path)
    coefficients = make.coefficients(result)
    assert set(coefficients) == {"PCY1", "PDY1", "PKY1", "PKY2"}
    for coefficient in coefficients.values():
        assert coefficient.lower <= coefficient.value <= coefficient.upper
    assert {name for name, c in coefficients.items() if c.at_bound} == {"PDY1", "PKY2"}
    assert coefficients["PDY1"].value == pytest.approx(1.7, rel=1e-3)  # the tire has 1.9
    assert coefficients["PKY2"].value == pytest.approx(2.6, rel=1e-3)  # and 2.2
    assert coefficients["PKY2"].guess == 5.0  # a guess beyond its bounds is moved onto them


def test_without_constraints_the_curvature_exceeds_one(known, make):
    """The counterpart: without constraints similar data lead to values above 1."""
    values = {**known.values, "PEY1": 0.6, "PEY2": 1.2}
    odd = Tire("mf96", values, effects=make.effects, signs="adapted-sae")
    recording = make.sideways(odd)
    constrained = make.fit(recording)
    unconstrained = make.fit(recording, without_constraints=["all"])
    assert unconstrained.margins == ()
    at_top = {"Fz": 1120.0, "alpha": 0.2}

    def curvature(result):
        return float(result.tire.evaluate(pd.DataFrame([at_top]))["E_y"].iloc[0])

    assert curvature(unconstrained) > 1.2
    assert curvature(constrained) <= 1.0 + 1e-6
    assert min(margin.margin for margin in constrained.margins) >= -1e-6
    assert unconstrained.channels[0].rmse < constrained.channels[0].rmse
