"""Formulas for what a model does not explain: features and products of two features at the locations of the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from ..probing.effect_probing import Screen
from ..thresholds import SHORTLIST
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
        return [chosen[k] for k in np.argsort(-graded(scores), kind="stable")[:SHORTLIST]]
