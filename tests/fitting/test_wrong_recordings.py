"""Recordings with an error that the table does not show give no good tire, and their noise floor is their noise."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.results.verdict import GOOD, UNUSABLE, lacks_something

from . import wrong_recordings

#: What explains most of the error beyond the floor.
CAUSE = {
    "alpha late": "explained_by_time", "forces late": "explained_by_time", "Fy low-passed": "explained_by_time",
    "two tires interleaved": "between_repeats", "friction drifts": "explained_by_time",
    "friction bump at one load": "explained_by_inputs",
}  # fmt: skip


@pytest.fixture(scope="module")
def right():
    return wrong_recordings.right(seed=3)


def fitted(recording):
    return fit([recording], "mf96", nominal={"Fz0": 700.0, "R0": 0.23}, recipe="joint")


def test_the_right_recording_is_at_its_noise_floor(right):
    result, noise = fitted(right), wrong_recordings.noise_of(right)
    assert (result.verdict.word, result.verdict.reasons) == (GOOD, ())
    for c in result.channels:
        assert 0.75 * noise[c.channel] < c.noise_floor < 1.15 * noise[c.channel]
        assert not lacks_something(c)


#: The one of the fast suite.
TESTED = ("two tires interleaved",)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in TESTED)) for name in wrong_recordings.WRONG]
)
def test_a_wrong_recording_is_recognized(right, name):
    result, noise = fitted(wrong_recordings.WRONG[name](right)), wrong_recordings.noise_of(right)
    assert result.verdict.word == UNUSABLE
    for c in result.channels:
        assert c.noise_floor < 1.15 * noise[c.channel], c.channel
        parts = (c.noise_floor, c.explained_by_inputs, c.explained_by_time, c.between_repeats)
        assert np.linalg.norm(parts) == pytest.approx(c.fitted_rmse, rel=0.05)
    if name in CAUSE:
        (fy,) = [c for c in result.channels if c.channel == "Fy"]
        assert lacks_something(fy)
        parts = {each: getattr(fy, each) for each in ("explained_by_inputs", "explained_by_time", "between_repeats")}
        assert max(parts, key=parts.get) == CAUSE[name]
