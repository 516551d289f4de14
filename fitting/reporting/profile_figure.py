"""Profile likelihoods of coefficients: deviance over the value, with the interval and its quadratic approximation."""

from __future__ import annotations

import numpy as np

from tirefmu.tires.drawing.own_matplotlib import Figure, own_settings
from tirefmu.tires.drawing.style import panels, write_footnote

from ..evidence.uncertainty import QUANTILE
from ..results.fit_result import FitResult


@own_settings()
def profile_curves(result: FitResult) -> Figure:
    """Return a figure with a panel for each profile of a fit.

    Parameters
    ----------
    result : FitResult
        With profiles.
    """
    figure, axes = panels(len(result.profiles), "Profile likelihood")
    half = {one.name: one.interval for one in result.coefficients}
    for axis, profile in zip(axes, result.profiles, strict=True):
        axis.plot(profile.values, profile.deviances, ".-", label="profile")
        if np.isfinite(half[profile.name]) and half[profile.name] > 0.0:
            dense = np.linspace(profile.values[0], profile.values[-1], 100)
            deviations = QUANTILE * (dense - profile.value) / half[profile.name]
            axis.plot(dense, deviations**2, "--", label="standard error")
        axis.axhline(QUANTILE**2, color="0.5", linewidth=0.8)
        for end in (profile.lower, profile.upper):
            if np.isfinite(end):
                axis.axvline(end, color="0.5", linewidth=0.8)
        axis.set_xlabel(profile.name + ("" if profile.unit == "1" else f" ({profile.unit})"))
        axis.set_ylabel("deviance (-)")
        axis.set_ylim(0.0, 8.0)
        axis.legend(loc="upper center")
        axis.grid(alpha=0.3)
    write_footnote(figure, result.signs, f"the 95 % interval ends at a deviance of {QUANTILE**2:.2f}")
    return figure
