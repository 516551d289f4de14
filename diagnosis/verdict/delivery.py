"""Whether the improved tire is delivered: it must not be worse than the baseline tire.

It is not delivered if the squared residual of a channel, or of all together, increases by more than its scatter. Per
block of time the residuals are r and r + d, r of the better tire; the increase is d'd + 2 r'd, of which the second term
is noise. A mere test of the increase over blocks would pass a tire that is far off in one block, a ratio one that is
worse everywhere by a little.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from ..thresholds import MAX_UNDETERMINED_CHANGE, WORSE_P
from .fit_error import FitErrors, Residuals

FloatArray = npt.NDArray[np.float64]

#: The parts of a recording on which both tires are compared, as in a sentence.
PARTS = {"train": "fitted rows", "holdout": "hold-out set"}


def reasons_against(errors: FitErrors, residuals: Residuals, undetermined: Mapping[str, float]) -> tuple[str, ...]:
    """Return the reasons why an improved tire is not delivered; none if it is not worse than the baseline tire.

    It is worse if the increase of the squared residual of a channel, or of all channels together, each relative to its
    size, exceeds what noise explains (`WORSE_P`).

    Parameters
    ----------
    errors : dict
        Of the delivered tires (`fit_error.fit_errors`).
    residuals : Residuals
        Of the same tires, from which the errors are computed.
    undetermined : mapping of str to float
        By effect: change over the operating range that the recording does not determine, relative to the spread among
        tires (`undetermined_change`).
    """
    reasons, comparisons = [], len(PARTS) * (len(residuals.before) + 1)
    for part, text in PARTS.items():
        increase, scatter = increases(residuals, residuals.holdout == (part == "holdout"))
        if not increase.size:
            continue
        rows = zip([*increase, increase.sum(axis=0)], [*scatter, scatter.sum(axis=0)], strict=True)
        limit = stdtrit(max(increase.shape[1] - 1, 1), 1.0 - WORSE_P / comparisons)
        if not all(one.sum() <= limit * np.sqrt(np.sum(other**2)) for one, other in rows):  # NaN is worse
            worst = list(errors[part])[int(np.argmax(increase.sum(axis=1)))]  # of NaN, the first one
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


def increases(residuals: Residuals, rows: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return the increase of the squared residual in each time block, and the part of it that noise explains.

    With residuals r of the better tire in a block, and r + d of the other one, the squared residuals differ by d'd +
    2 r'd. Only the second term depends on the noise, which r contains; d'd is a difference of the tires.

    Parameters
    ----------
    residuals : Residuals
    rows : ndarray of bool, shape (m,)

    Returns
    -------
    increase, scatter : ndarray, shape (n_channels, n_blocks)
        Relative to the mean square of the baseline tire; the variance of a sum of increases is the sum of the squared
        scatter, as blocks are independent.
    """
    numbers, block = np.unique(residuals.block[rows], return_inverse=True)
    increase, scatter = np.zeros((2, len(residuals.before), len(numbers)))
    for i, used in enumerate(residuals.used[:, rows]):
        before, after = (np.where(used, one[i, rows], 0.0) for one in (residuals.before, residuals.after))
        size = max(float(np.sum(before**2)) / max(int(used.sum()), 1), 1e-300)
        sums = [
            np.bincount(block, weights=values / size, minlength=len(numbers))
            for values in (after**2 - before**2, 2.0 * before * (after - before), 2.0 * after * (after - before))
        ]
        increase[i], scatter[i] = sums[0], np.where(sums[0] > 0.0, sums[1], sums[2])
    return increase, scatter
