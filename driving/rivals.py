"""Explanations of a drive compared: changed factors of the tires, a wrong entry of the car, an effect that tires lack.

An explanation states which factors changed, and at most one more thing: an entry of the car that its file has wrong, or
an effect of the library. Its prior gives a changed factor the spread of factors, a wrong entry a multiple of its
uncertainty, an effect its typical size; all else keeps its prior. The likelihood of all is one, the Gaussian of the
estimate; integrated over the prior it is the evidence (MacKay, Information Theory, Inference, and Learning Algorithms,
2003, chapter 28).
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

#: Prior probability that a factor changed; odds that an entry of the car is wrong, or that the tires lack an effect;
#: how many times its uncertainty a wrong entry has. Judgement: who compares a drive expects other tires as likely as
#: not, and most numbers of a car right.
CHANGED, ODDS, WRONG_SPREAD = 0.5, 0.05, 10.0


@dataclass(frozen=True)
class Probabilities:
    """Posterior probabilities: of changed factors by axle and name, of wrong entries of the car, of effects."""

    factors: dict[tuple[str, str], float]
    car: dict[str, float]
    effects: dict[str, float]


def probabilities_of(
    grid: Grid, estimate: Estimate, unknowns: Unknowns, effects: list[tuple[str, FloatArray]]
) -> Probabilities:
    """Return the probabilities over all explanations. `effects`: `effect_columns`."""
    lateral = [pair for pair in unknowns.factors if pair[1] in ("LMUY", "LKY")]
    places = [unknowns.factor(*pair) for pair in lateral]
    n, names = len(unknowns), [name for name, _ in effects]
    added = np.stack([column for _, column in effects], axis=2) if effects else np.zeros((len(grid.t), 2, 0))
    information, score = estimate.information(grid, added)
    changed = np.array(list(itertools.product((False, True), repeat=len(places))))
    further = [("", -1, 1.0), *((name, i, ODDS) for i, name in enumerate(unknowns.car))]
    further += [(name, n + i, ODDS / names.count(name)) for i, name in enumerate(names)]
    logs = np.empty((len(changed), len(further)))
    for row, some in enumerate(changed):
        base = np.concatenate([np.ones(n), np.zeros(len(names))])
        base[places] = some
        for column, (_, place, odds) in enumerate(further):
            spread = base.copy()
            if place >= 0:
                spread[place] = WRONG_SPREAD if place < n else 1.0
            logs[row, column] = np.log(odds) + _evidence(information, score, spread)
        logs[row] += np.log(np.where(some, CHANGED, 1.0 - CHANGED)).sum()
    share = np.exp(logs - logs.max())
    share /= share.sum()
    sums: dict[str, float] = {}
    for (name, place, _), value in zip(further, share.sum(axis=0).tolist(), strict=True):
        key = name if place < n else f"effect {name}"
        sums[key] = sums.get(key, 0.0) + value
    return Probabilities(
        {pair: float(share[changed[:, i]].sum()) for i, pair in enumerate(lateral)},
        {name: sums[name] for name in unknowns.car},
        {name: sums[f"effect {name}"] for name in dict.fromkeys(names)},
    )


def _evidence(information: FloatArray, score: FloatArray, spread: FloatArray) -> float:
    """Return the logarithm of the evidence for a prior with standard deviations `spread`, up to a constant."""
    free = np.flatnonzero(spread)
    spread = spread[free]
    scaled = np.eye(len(free)) + spread[:, None] * information[np.ix_(free, free)] * spread[None, :]
    whole = spread * score[free]
    return float(whole @ np.linalg.solve(scaled, whole) - np.linalg.slogdet(scaled)[1]) / 2
