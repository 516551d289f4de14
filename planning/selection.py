"""The choice of maneuvers: greedy addition, then exchange (Fedorov, Theory of Optimal Experiments, 1972).

The criterion is the sum over the targets of the logarithm of their mean relative variance in a fit, averaged over the
tires (Chaloner and Verdinelli, Bayesian experimental design: a review, Statistical Science 10, 1995): halving the
interval of one target counts as much as halving that of another. With a program to compare with, it is the sum of the
squares of the ratios to its variances instead, which is large for a target that the program determines better. The
Fisher information of the maneuvers gives a shortlist, as it adds up and its derivative is a product; the shortlist is
evaluated exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.one_thread import one_blas_thread

from .aims import Target
from .information import Information, common_scores, inverse_of, sandwich

FloatArray = npt.NDArray[np.float64]
#: Maneuvers of the shortlist that are evaluated exactly; rounds of exchange.
SHORTLIST, EXCHANGES = 6, 2
#: Number of maneuvers below which no fit is possible: all are compared by the Fisher information of the first tire.
FEW = 16


@dataclass(frozen=True, eq=False)
class Selection:
    """Chooses maneuvers within limits of time and energy.

    - `fisher`, shape (m, t, q, q): information of each maneuver on the coefficients and the offsets.
    - `information`: what a fit learns from each maneuver; drift has an independent value in each.
    - `offsets`, shape (k,): of the sources of noise.
    - `seconds`, `energy`, shape (m,): what each maneuver costs.
    - `budget`, `most_energy`: of the whole program.
    - `compared`, shape (t, p, p): covariances of the program to compare with.
    """

    fisher: FloatArray
    information: Information
    offsets: FloatArray
    targets: tuple[Target, ...]
    seconds: FloatArray
    energy: FloatArray
    budget: float
    most_energy: float
    compared: FloatArray | None = None

    def chosen(self, start: Sequence[int], progress: Callable[[float], None]) -> list[int]:
        """Return the indices of the best maneuvers, with repetitions.

        `start`: maneuvers that are in the program at first. `progress`: called with the share of the time that is used.
        """
        chosen = list(start)
        with one_blas_thread():
            self._fill(chosen, progress)
            for _ in range(EXCHANGES):
                exchanged = self._without_least(chosen)
                self._fill(exchanged, progress)
                if self._value(self._sums(exchanged)) >= self._value(self._sums(chosen)):
                    break
                chosen = exchanged
        return chosen

    def _fill(self, chosen: list[int], progress: Callable[[float], None]) -> None:
        """Add the best maneuvers while there is time."""
        while True:
            seconds, energy = self.seconds[chosen].sum(), self.energy[chosen].sum()
            progress(min(float(seconds / self.budget), 1.0))
            possible = (self.seconds + seconds <= self.budget) & (self.energy + energy <= self.most_energy)
            if not possible.any():
                return
            best = self._first if len(chosen) < FEW else self._best
            chosen.append(best(self._sums(chosen), np.flatnonzero(possible)))

    def _first(self, sums: Sums, possible: npt.NDArray[np.intp]) -> int:
        """Return the maneuver with most information per second, for the first tire."""
        covariances = inverse_of(sums[0][0] + self.fisher[[*possible], 0]), inverse_of(sums[0][:1])
        after, now = (sum(np.log(_traces(one[0], c)) for one in self._padded) for c in covariances)
        return int(possible[np.argmin((after - now) / self.seconds[possible])])

    def _best(self, sums: Sums, possible: npt.NDArray[np.intp]) -> int:
        """Return the maneuver that lowers the criterion most per second."""
        rates = self._derivatives(sums)[possible] / self.seconds[possible]
        shortlist = possible[np.argsort(rates)[:SHORTLIST]]
        now = self._value(sums)
        values = [self._value(_added(sums, self._sums([i]))) for i in shortlist]
        return int(shortlist[np.argmin((np.array(values) - now) / self.seconds[shortlist])])

    def _without_least(self, chosen: list[int]) -> list[int]:
        """Return a program without the third of its maneuvers that contributes least per second."""
        order = np.argsort((self._derivatives(self._sums(chosen)) / self.seconds)[chosen])
        return [chosen[k] for k in order[: len(chosen) - len(chosen) // 3]]

    def _sums(self, chosen: Sequence[int]) -> Sums:
        """Return the sums of the Fisher information and of the parts of `Information`."""
        index = np.array(chosen, dtype=int)
        parts = (self.fisher, *vars(self.information).values())
        return tuple(np.asarray(part[index].sum(axis=0)) for part in parts)

    @cached_property
    def _padded(self) -> list[FloatArray]:
        """Mean squares of the derivatives of each target, with zeros for the offsets, shape (t, q, q)."""
        more = self.fisher.shape[-1] - self.targets[0].rows.shape[-1]
        return [np.pad(target.squares, ((0, 0), (0, more), (0, more))) for target in self.targets]

    @cached_property
    def _references(self) -> list[FloatArray]:
        """Variances of the targets by the program to compare with, shape (t,)."""
        return [] if self.compared is None else [_traces(target.squares, self.compared) for target in self.targets]

    def _variances(self, sums: Sums) -> list[FloatArray]:
        """Return the mean relative variance of each target in a fit, shape (t,)."""
        _, curvature, scores, systematic = sums
        covariance = sandwich(curvature, scores + common_scores(systematic, self.offsets))
        return [_traces(target.squares, covariance) for target in self.targets]

    def _value(self, sums: Sums) -> float:
        """Return the criterion."""
        variances = self._variances(sums)
        if not self._references:
            return float(sum(np.log(variance).mean() for variance in variances))
        pairs = zip(variances, self._references, strict=True)
        return float(sum(np.square(variance / reference).mean() for variance, reference in pairs))

    def _derivatives(self, sums: Sums) -> FloatArray:
        """Return the derivative of the criterion by the Fisher information of each maneuver, shape (m,)."""
        covariance, weight = inverse_of(sums[0]), np.zeros_like(sums[0])
        for i, (squares, variance) in enumerate(zip(self._padded, self._variances(sums), strict=True)):
            slope = 2.0 * variance / self._references[i] ** 2 if self._references else 1.0 / variance
            weight += squares * slope[:, None, None]
        outer = covariance @ (weight / len(covariance)) @ covariance
        return np.asarray(-(self.fisher.reshape(len(self.fisher), -1) @ outer.ravel()))


#: Fisher information, H, B and systematic scores of a program.
Sums = tuple[FloatArray, ...]


def _added(first: Sums, second: Sums) -> Sums:
    return tuple(a + b for a, b in zip(first, second, strict=True))


def _traces(squares: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the traces of products of symmetric matrices, shape (n,)."""
    return np.asarray(np.maximum(np.sum(squares * covariance, axis=(-2, -1)), 1e-30))
