"""Whether the improved tire is delivered: it must not be worse than the baseline tire."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite

from ..thresholds import MAX_UNDETERMINED_CHANGE, MAX_WORSE, MAX_WORSE_CHANNEL
from .fit_error import FitErrors

#: The parts of a recording on which both tires are compared, as in a sentence.
PARTS = {"train": "fitted rows", "holdout": "hold-out set"}


def reasons_against(errors: FitErrors, undetermined: Mapping[str, float]) -> tuple[str, ...]:
    """Return the reasons why an improved tire is not delivered; none if it is not worse than the baseline tire.

    Parameters
    ----------
    errors : dict
        Of the delivered tires (`fit_error.fit_errors`).
    undetermined : mapping of str to float
        By effect: change over the operating range that the recording does not determine, relative to the spread among
        tires (`undetermined_change`).

    Examples
    --------
    >>> worse = {"Fx": {"before": 62.0, "after": 153.0, "floor": 20.0, "floor_with_history": 20.0}}
    >>> reasons_against({"train": worse, "holdout": worse}, {})[0]
    'its residual on the fitted rows is larger than that of the baseline tire (Fx: 153 instead of 62 N)'
    """
    reasons = []
    for part, text in PARTS.items():
        ratios = {name: one["after"] / one["before"] for name, one in errors[part].items() if one["before"] > 0.0}
        if not ratios:
            continue
        worst = max(ratios, key=lambda name: ratios[name] if isfinite(ratios[name]) else inf)
        total = (sum(ratio**2 for ratio in ratios.values()) / len(ratios)) ** 0.5
        if not (total <= MAX_WORSE and ratios[worst] <= MAX_WORSE_CHANNEL[part]):  # NaN is worse
            one, unit = errors[part][worst], "N" if worst.startswith("F") else "N m"
            reasons.append(
                f"its residual on the {text} is larger than that of the baseline tire ({worst}: {one['after']:.3g} "
                f"instead of {one['before']:.3g} {unit})"
            )
    reasons += [
        f"over the operating range {effect} changes a force by {ratio:.1f} times its spread among tires, which the "
        "recording does not determine"
        for effect, ratio in undetermined.items()
        if ratio > MAX_UNDETERMINED_CHANGE
    ]
    return tuple(reasons)
