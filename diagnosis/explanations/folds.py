"""Probabilities that do not depend on single sweeps: the leading explanations scored without each part of the blocks.

The evidence of an explanation on a part of the recording decides between two explanations by chance if both predict it
equally well. As in a bagged posterior (Huggins and Miller, Bayesian Analysis 18, 2023), probabilities are therefore
averaged over recordings without a part of the blocks of time. The columns of the refits serve for all of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ..thresholds import FOLDS, REFIT_MARGIN
from .evidence import caution
from .linearization import Linearization
from .table import Parts, Table

FloatArray = npt.NDArray[np.float64]


def fold_evidences(table: Table) -> dict[Parts, FloatArray]:
    """Return the scores that make the probabilities, without each fold of the blocks, shape (`FOLDS`,).

    Explanations with little probability differ from the leading one as on all rows.
    """
    divided = table.divided()
    best = max(divided.values())
    leading = table.leader.explanation.parts
    chosen = [parts for parts in table.refits if divided[parts] > best + 2.0 * REFIT_MARGIN or parts == leading]
    factor = caution(table.explained)
    change = {}
    for parts in chosen:
        table.shared.budget.check()
        refit = table.refits[parts]
        change[parts] = (without_folds(refit.linear) - refit.evidence) / factor
        refit.linear.simulator.forget()
    return {parts: divided[parts] + change.get(parts, change[leading]) for parts in divided}


def without_folds(linear: Linearization) -> FloatArray:
    """Return the logarithm of the evidence of an explanation without each fold of the blocks, shape (`FOLDS`,).

    The rows that remain count as often as makes them as many as all.
    """
    signals, equations = linear.simulator.signals, linear.equations()
    blocks = np.unique(signals.block)
    fold = (np.random.default_rng(0).permutation(len(blocks)) % FOLDS)[np.searchsorted(blocks, signals.block)]
    parts = [linear.products(np.flatnonzero(fold == k)) for k in range(FOLDS)]
    whole, times = np.sum(parts, axis=0), FOLDS / (FOLDS - 1.0)
    evidences = []
    for part in parts:
        rest = times * (whole - part)
        of_priors = equations.power - whole[-1, -1]
        fewer = replace(equations, matrix=rest[:-1, :-1], target=rest[:-1, -1], power=rest[-1, -1] + of_priors)
        evidences.append(fewer.solved()[1])
    return np.array(evidences)
