"""How much too narrow the replicates of a bootstrap by sweeps are, because the fit has followed each sweep.

The residuals of a sweep that determines a coefficient are smaller than its noise. Neither random weights of sweeps
nor the sandwich estimator with sweeps as clusters accounts for this: their standard errors are too small by some
percent, the more the fewer sweeps determine a coefficient. The jackknife leaves out each sweep in turn, so that its
residuals are those from a fit to the others. It is the estimator CR3 of Bell and McCaffrey, Survey Methodology 28
(2002), which MacKinnon, Nielsen and Webb, J. Applied Econometrics 38 (2023), recommend for few or unequal clusters. Its
change of the coefficients by one sweep is, to first order,

    (H - A_g)^-1 s_g    instead of    H^-1 s_g,

with the gradient s_g and the Gauss-Newton matrix A_g of the sweep, and their sum H over all sweeps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..results.solved_stage import SolvedStage

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def standard_error_ratios(stage: SolvedStage, sweeps: IntArray) -> dict[str, float]:
    """Return the standard error by the jackknife relative to that by random weights of sweeps.

    Coefficients at a bound are fixed; physical constraints are not taken into account, nor are slopes that are targets:
    these are combinations of the same residuals.

    Parameters
    ----------
    stage : SolvedStage
    sweeps : ndarray of int, shape (n,)
        Number of the sweep of each row of all recordings.

    Returns
    -------
    dict of str to float
        By free coefficient, at least 1; 1 for a coefficient at a bound.
    """
    problem, own = stage.problem, sweeps[stage.rows]
    inside = np.flatnonzero((stage.x > stage.lower) & (stage.x < stage.upper))
    scores, matrices = [], []
    order = np.argsort(own, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(own[order])) + 1):
        _, gradient, matrix = replace(problem, rows=problem.rows.take(rows), targets=()).derivatives(stage.x)
        scores.append(gradient[inside])
        matrices.append(matrix[np.ix_(inside, inside)])
    whole = np.sum(matrices, axis=0) + stage.ridge * np.eye(len(inside))
    weighted = np.linalg.solve(whole, np.transpose(scores))
    left_out = [np.linalg.solve(whole - matrix, score) for matrix, score in zip(matrices, scores, strict=True)]
    count = len(scores)
    jackknife = (count - 1) / count * np.sum(np.square(left_out), axis=0)
    ratios = np.ones(len(stage.x))
    ratios[inside] = np.sqrt(np.maximum(jackknife / np.sum(weighted**2, axis=1), 1.0))
    return dict(zip(problem.free, ratios.tolist(), strict=True))
