"""A coefficient is determined if its standard deviation is at most a quarter of its plausible range."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fitting.checks import Residuals
from tirefmu.fitting.checks.undetermined import at_bounds


@pytest.mark.parametrize(
    ("share", "expected"), [(0.5, "at a bound: the data pull beyond it"), (2.0, "at a bound: not")]
)
def test_a_coefficient_at_a_bound_is_determined_within_a_quarter_of_its_range(known, make, share, expected):
    """The noise of Fy gives PHY1 a standard deviation of `share` quarters of its range."""
    recording = make.sideways(known)
    coefficient, step, rows = known.symbolic_model.coefficients["PHY1"], 1e-5, 50.0
    moved = known.with_values(PHY1=known.values["PHY1"] + step)
    slope = moved.evaluate(recording)["Fy"].to_numpy() - known.evaluate(recording)["Fy"].to_numpy()
    information = np.mean((slope / step) ** 2)
    quarter = 0.25 * (coefficient.upper - coefficient.lower)
    noise = share * quarter * np.sqrt(rows * information)
    sign = np.where(np.arange(len(recording)) % 2, 1.0, -1.0)
    table = recording.with_signs("adapted-sae").table.assign(recording=0, segment=0)
    table["Fy"] += noise * sign
    (found,) = at_bounds(Residuals(table, ("bench",), known, "adapted-sae"), ["PHY1"], ["PHY1"], {"Fy": rows})
    assert found.coefficients == ("PHY1",)
    assert found.reason.startswith(expected)
