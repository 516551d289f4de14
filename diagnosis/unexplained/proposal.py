"""Formulas for what a model does not explain: which ones are compared, and whether one generalizes over the recording.

Each of thousands of features and products of two features could be chosen. The chosen formula must therefore predict
blocks of time and long stretches from which it was not estimated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.block_regression import block_sums, error_of_sum, regression

from ..probing.effect_probing import Screen
from ..thresholds import (
    MIN_RETAINED_GAIN,
    MIN_STRETCHES,
    PROBE_PRIOR,
    SHORTLIST,
    STRETCHES,
    STRUCTURE_ERRORS,
    STRUCTURE_GAIN,
    STRUCTURE_P,
    STRUCTURE_P_OF_BLOCKS,
)
from .features import Feature, Location, determined, directions, features, locations_of

FloatArray = npt.NDArray[np.float64]

#: Rows from which features are shortlisted. Convention: computing time.
SHORTLIST_ROWS = 1500


class Dictionary:
    """Features and products of two features at the locations of the model.

    - `terms`: each location with a feature.
    - `acting`: change of the forces per unit of a feature, by location, shape (n_channels, n).
    """

    def __init__(self, screen: Screen) -> None:
        problem, signals = screen.problem, screen.signals
        self._weights = problem.inverse_noise
        tire = problem.simulator.tire
        even, odd = features(signals, tire)
        simple = [feature for feature in even if feature.expressible]
        pairs = [feature * other for i, feature in enumerate(simple) for other in simple[i:]]
        odd_pairs = [feature * other for feature in odd for other in simple]
        self.acting = directions(problem.simulator, screen.solution.parameters)
        self.terms: list[tuple[Location, Feature]] = [
            (location, feature)
            for location in locations_of(problem.simulator.symbolic_model)
            if np.any(self._weights * self.acting[location.name])
            for feature in ([*even, *pairs] if location.how == "factor" else [*odd, *odd_pairs, *even])
            if determined(location, feature, signals, tire)
        ]

    def column(self, i: int) -> FloatArray:
        """Return the change of the forces per unit of a term, N and N m, shape (n_channels, n)."""
        location, feature = self.terms[i]
        return np.asarray(self.acting[location.name] * feature.values)

    def shortlisted(self, screen: Screen, chosen: Sequence[int]) -> list[int]:
        """Return those of the chosen terms that explain most of a residual, each alone and from some rows."""
        rows = slice(None, None, max(1, screen.residual.shape[1] // SHORTLIST_ROWS))
        acting = {name: (self._weights * response)[:, rows] for name, response in self.acting.items()}
        columns = [acting[self.terms[i][0].name] * self.terms[i][1].values[rows] for i in chosen]
        rest = screen.residual[:, rows].ravel()
        flat = np.stack(columns, axis=-1).reshape(len(rest), -1)
        tangent = screen.tangent[:, rows].reshape(len(rest), -1)
        matrix = tangent.T @ tangent + np.diag(screen.prior_precision)
        inner = np.linalg.solve(matrix, tangent.T @ flat)
        total = np.einsum("nk,nk->k", flat, flat)
        power = total - np.einsum("qk,qk->k", tangent.T @ flat, inner)
        target = flat.T @ rest - inner.T @ (tangent.T @ rest)
        independent = power > 1e-3 * total
        scores = np.where(independent, target**2 / np.where(independent, power, 1.0), 0.0)
        return [chosen[k] for k in np.argsort(-scores)[:SHORTLIST]]


def generalizes(screen: Screen, formula: FloatArray, tests: int) -> bool:
    """Return whether a formula is significant, material, and present in nearly every long stretch.

    `formula`, shape (n_channels, n, k): change of the forces per unit of each term. `tests`: number of tested terms.
    """
    columns = screen.problem.inverse_noise[:, :, None] * formula
    screen.learn_noise({0: columns})
    response = screen.response(columns)
    gains, total = screen.baseline.loss - response.loss, float(screen.baseline.loss.sum())
    gain, error = float(gains.sum()) / total, error_of_sum(gains) / total
    if response.p_coloured * tests > STRUCTURE_P or response.p_blocks > STRUCTURE_P_OF_BLOCKS:
        return False
    if gain < max(STRUCTURE_ERRORS * error, STRUCTURE_GAIN):
        return False
    edges, added = screen.stretches(STRETCHES), response.columns.shape[-1]
    prior = np.concatenate([screen.prior_precision, np.full(added, PROBE_PRIOR**-2.0)])
    gradient = np.concatenate([screen.prior_gradient, np.zeros(added)])
    sums = block_sums(np.concatenate([screen.tangent, response.columns], axis=-1), screen.residual, edges)
    before = screen.stretch_losses(edges)
    gained = (before - regression(sums, prior, gradient).loss) / before.sum()
    return int(np.sum(gained > 0.0)) >= MIN_STRETCHES and float(gained.sum()) > MIN_RETAINED_GAIN * gain
