"""Profile likelihoods of coefficients: deviance over the value, with the interval and its quadratic approximation."""

from __future__ import annotations

import numpy as np

from ...drawing.figure import Figure, Panel, Series, in_rows
from ...drawing.labels import note
from ...drawing.style import BLUE, DASHED, ORANGE
from ..results.fit_result import FitResult
from ..results.resampled import Profile
from ..uncertainty.sandwich import QUANTILE


def profile_curves(result: FitResult) -> Figure:
    """Return a figure with a panel for each profile of a fit.

    `result`: with profiles.
    """
    half = {coefficient.name: coefficient.interval for coefficient in result.coefficients}
    panels = [_panel(profile, half[profile.name]) for profile in result.profiles]
    text = note(result.signs, f"the 95 % interval ends at a deviance of {QUANTILE**2:.2f}")
    return Figure("profile_likelihood", "Profile likelihood", in_rows(panels), text)


def _panel(profile: Profile, half: float) -> Panel:
    series = [Series("line", profile.values, profile.deviances, BLUE, "profile", marker="o")]
    if np.isfinite(half) and half > 0.0:
        dense = np.linspace(profile.values[0], profile.values[-1], 100)
        quadratic = (QUANTILE * (dense - profile.value) / half) ** 2
        series.append(Series("line", dense, quadratic, ORANGE, "standard error", DASHED))
    ends = tuple(float(end) for end in (profile.lower, profile.upper) if np.isfinite(end))
    unit = "" if profile.unit == "1" else f" ({profile.unit})"
    return Panel(
        f"{profile.name}{unit}", "deviance (-)", tuple(series), across=(QUANTILE**2,), upright=ends, y_limits=(0.0, 8.0)
    )
