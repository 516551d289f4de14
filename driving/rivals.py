"""Explanations of a drive compared: changed factors of the tires, and a wrong entry of the car.

An explanation states which factors changed, and at most one entry of the car that its file has wrong. Its prior gives a
changed factor the spread of factors, a wrong entry a multiple of its uncertainty; all else keeps its prior. The
likelihood of all is one, the Gaussian of the estimate; integrated over the prior it is the evidence (MacKay,
Information Theory, Inference, and Learning Algorithms, 2003, chapter 28).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .estimate import Estimate
from .inputs.grid import Grid
from .unknowns import Unknowns

FloatArray = npt.NDArray[np.float64]

#: Prior probability that a factor changed; odds that an entry of the car is wrong, and that the tires lack an effect;
#: how many times its uncertainty a wrong entry has. Judgement: who compares a drive expects other tires as likely as
#: not, and most numbers of a car right.
CHANGED, ODDS, WRONG_SPREAD = 0.5, 0.05, 10.0


@dataclass(frozen=True)
class Probabilities:
    """Posterior probabilities: of changed factors by axle and name, of wrong entries of the car.

    `wrong_car`: logarithm by which the evidence of an estimate grows if an entry of the car may be wrong.
    """

    factors: dict[tuple[str, str], float]
    car: dict[str, float]
    wrong_car: float


def probabilities_of(grid: Grid, estimate: Estimate, unknowns: Unknowns) -> Probabilities:
    """Return the probabilities over all explanations."""
    lateral = [pair for pair in unknowns.factors if pair[1] in ("LMUY", "LKY")]
    places = [unknowns.factor(*pair) for pair in lateral]
    information, score = estimate.information(grid, np.zeros((len(grid.t), 2, 0)))
    changed = np.array(list(itertools.product((False, True), repeat=len(places))))
    logs = np.empty((len(changed), 1 + len(unknowns.car)))
    for row, some in enumerate(changed):
        for column in range(logs.shape[1]):
            spread = np.ones(len(estimate.z))
            spread[places] = some
            if column:
                spread[column - 1] = WRONG_SPREAD
            logs[row, column] = (np.log(ODDS) if column else 0.0) + evidence_of(information, score, spread)
        logs[row] += np.log(np.where(some, CHANGED, 1.0 - CHANGED)).sum()
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return Probabilities(
        {pair: float(share[changed[:, i]].sum()) for i, pair in enumerate(lateral)},
        dict(zip(unknowns.car, share[:, 1:].sum(axis=0).tolist(), strict=True)),
        float(-np.log(max(share[:, 0].sum(), 1e-300))),
    )


def evidence_of(information: FloatArray, score: FloatArray, spread: FloatArray) -> float:
    """Return the logarithm of the evidence for a prior with standard deviations `spread`, up to a constant."""
    free = np.flatnonzero(spread)
    spread = spread[free]
    scaled = np.eye(len(free)) + spread[:, None] * information[np.ix_(free, free)] * spread[None, :]
    whole = spread * score[free]
    return float(whole @ np.linalg.solve(scaled, whole) - np.linalg.slogdet(scaled)[1]) / 2
