"""The consequence of a bound is that of a fit without it."""

from __future__ import annotations

import pytest

from tirefmu.fitting.results.records import BoundConsequence

STAGE = """
[[stage]]
name = "all"
weights = "noise"

[[stage]]
name = "friction alone"
weights = "noise"
[stage.free]
PDY1 = { guess = 1.5, upper = %s }
"""


@pytest.fixture(scope="module")
def recording(known, make):
    return make.sideways(known)


def bounded(recording, make, folder, limit):
    return make.fit(recording, recipe=make.recipe(folder, STAGE % limit))


def test_a_bound_below_the_true_friction_has_a_consequence(recording, make, tmp_path):
    result = bounded(recording, make, tmp_path, 1.7)
    (found,) = [each for each in result.bounds if each.name == "PDY1"]
    assert found.value == pytest.approx(1.9, rel=0.02)
    assert found.matters
    assert found.rmse_beyond < 0.2 * found.rmse_at_bound
    assert any(reason.startswith("PDY1 at a bound: beyond the bound, at 1.9") for reason in result.verdict.reasons)


def test_without_a_bound_there_is_no_consequence(recording, make, tmp_path):
    assert "PDY1" not in {each.name for each in bounded(recording, make, tmp_path, 3.0).bounds}


def test_texts():
    assert BoundConsequence("PCY1", 0.94, "Fy", 66.6, 66.5, 0.004).text() == "no consequence"
    assert BoundConsequence("PCY1").text() == "no solution beyond the bound"
    assert BoundConsequence("PCY1", 0.7, "Fy", 66.6, 60.0, 0.05).matters
