"""Whether tires predict: the car simulated over parts of a drive that their estimate did not see.

The drive is divided into manoeuvres. What the others say of the unknowns follows from the linearized estimate without
the information of one; with tires as given, their factors are held at 1 and the car is that of the other parts, too.
Only what the simulated car does better in the parts that were left out, beyond the scatter over them, is found.

The simulated car returns to the recorded motion with a time constant: a predictor with a constant observer gain. The
motion of a car that slides is not stable, so that errors of a free simulation grow on the right tires and stay small
on others that are stable (Forssell and Ljung, IEEE Trans. Automatic Control 45, 2000).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from ....tires import Tire
from ..estimate import Estimate
from ..inputs.car import Car
from ..inputs.grid import Grid
from ..inputs.unknowns import AXLES, FACTORS, Unknowns
from ..simulation import errors_of, estimated_motion, horizon, pieces_of, rows_of, simulated_pieces

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Most parts of a drive, and fewest; a part has at least a piece of the simulation. Convention.
PARTS, FEWEST = 10, 3
#: One-sided probability of a gain by chance at which it is none. Convention.
CHANCE = 0.025
#: Time constant with which a simulated car returns to the recorded motion, in the length of a piece. Convention: 0.5 s
#: of a typical car, longer than its response, and short enough to forget the start of a piece.
MEMORY = 0.25
#: Standard deviations by which an entry of the car may explain what a factor that is fixed would. Convention.
MOST = 2.0


@dataclass(frozen=True)
class LeftOut:
    """Errors of the simulated car in the parts that were left out of its estimate.

    - `before`, `after`: rms of yaw rate, ay and lateral speed.
    - `parts`: first and last time of each part, s, and the rms of the error of the yaw rate, rad/s, before and after.
    """

    JSON_KEYS: ClassVar = ("before", "after", "better")

    before: Annotated[Mapping[str, float], "tires as given"]
    after: Annotated[Mapping[str, float], "new tires"]
    parts: tuple[tuple[float, float, float, float], ...]
    better: Annotated[bool, "whether the new tires are better, beyond the scatter over the parts"]


@dataclass(frozen=True)
class Parts:
    """A drive in parts.

    `number`, shape (n_pieces,): of the part of each piece. `z`, shape (n_parts, n_z), and `covariance`, shape (n_parts,
    n_z, n_z): what all parts but one say of the unknowns.
    """

    grid: Grid
    estimate: Estimate
    unknowns: Unknowns
    car: Car
    number: IntArray
    z: FloatArray
    covariance: FloatArray

    def errors(
        self, tires: Mapping[str, Tire], fixed: Sequence[Sequence[tuple[str, str]]]
    ) -> list[tuple[FloatArray, dict[str, float]]]:
        """Return the squared error of each part, (rad/s)^2, and the rms of signals, with some factors fixed at 1.

        `fixed`: the factors of each car that is simulated.
        """
        rows, given = rows_of(self.grid, self.car), (self.grid, self.estimate, self.unknowns, self.car)
        z = np.concatenate([self._z_without(some)[self.number] for some in fixed]).T
        factors = {
            axle: {
                name: np.exp(self.unknowns.spread[i] * z[i])
                for name in FACTORS
                for i in [self.unknowns.factor(axle, name)]
            }
            for axle in AXLES
        }
        wanted = estimated_motion(self.grid, self.estimate)
        speed = (self.estimate.states[self.grid.left, 0] + self.estimate.states[self.grid.right, 0]) / 2
        scale = np.stack([np.ones_like(speed), speed, speed], axis=1)
        result = []
        for pieces in simulated_pieces(*given, tires, z=z, factors=factors, memory=MEMORY * horizon(self.car)):
            of_piece = np.mean(((pieces - wanted[rows]) / scale[rows]) ** 2, axis=(1, 2))
            of_part = np.bincount(self.number, of_piece) / np.bincount(self.number)
            motion = np.full_like(wanted, np.nan)
            motion[rows] = pieces
            result.append((of_part, errors_of(motion, *given)))
        return result

    def _z_without(self, fixed: Sequence[tuple[str, str]]) -> FloatArray:
        """Return the unknowns of all parts if some factors are fixed at 1, shape (n_parts, n_z)."""
        if not fixed:
            return self.z
        places = [self.unknowns.factor(*pair) for pair in fixed]
        block = np.linalg.inv(self.covariance[:, places][:, :, places]) @ self.z[:, places, None]
        most = np.maximum(np.abs(self.z), MOST)
        z = np.clip(self.z - (self.covariance[:, :, places] @ block)[:, :, 0], -most, most)
        z[:, places] = 0.0
        return z


def parts_of(grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car) -> Parts | None:
    """Return a drive in parts, or None if it is too short for that."""
    starts = pieces_of(grid, car)
    n = min(PARTS, len(starts))
    if n < FEWEST:
        return None
    number = np.arange(len(starts)) * n // len(starts)
    edges = np.concatenate([starts[np.flatnonzero(np.diff(number, prepend=-1))], [len(grid.t)]])
    edges[0] = 0
    rows = [np.arange(first, last) for first, last in itertools.pairwise(edges)]
    informations, slopes = zip(*(estimate.of_part(grid, some) for some in rows), strict=True)
    # At the optimum the slopes of all parts and of the prior add to 0.
    shared = (np.sum(slopes, axis=0) + estimate.z) / n
    precision = np.linalg.inv(estimate.covariance)
    covariance = np.linalg.inv(precision - np.array(informations))
    z = estimate.z + np.einsum("kij,kj->ki", covariance, np.array(slopes) - shared)
    return Parts(grid, estimate, unknowns, car, number, z, covariance)


def widened(estimate: Estimate, parts: Parts | None) -> Estimate:
    """Return an estimate whose deviations are at least those of the scatter over its parts (jackknife).

    A wrong model has another answer in each manoeuvre, with a precision that only noise deserves (Huggins and
    Miller, Bayesian Analysis 18, 2023, average over resamples for the same reason).
    """
    if not parts:
        return estimate
    n = len(parts.z)
    scatter = np.sqrt((n - 1) / n * np.sum((parts.z - parts.z.mean(axis=0)) ** 2, axis=0))
    deviation = np.sqrt(np.diag(estimate.covariance))
    scale = np.clip(scatter, deviation, np.maximum(deviation, 1.0)) / deviation
    wide = estimate.covariance * np.outer(scale, scale)
    return replace(estimate, covariance=wide, scatter=wide - estimate.covariance)


def is_better(before: FloatArray, after: FloatArray) -> bool:
    """Return whether errors of parts fall beyond their scatter: a test of the mean gain by the signs of all gains.

    By chance, each gain has the other sign as likely (Fisher's permutation test); a part that gains far more than the
    others hides nothing. Few parts, which have equal signs by chance, need a normal distribution (Student's test).
    """
    gain, n = np.log(before / after), len(before)
    if 0.5**n > CHANCE:
        return bool(gain.mean() > stdtrit(n - 1, 1.0 - CHANCE) * gain.std(ddof=1) / np.sqrt(n))
    signs = 1.0 - 2.0 * (np.arange(2**n)[:, None] >> np.arange(n) & 1)
    return bool(np.mean(signs @ gain >= gain.sum() * (1.0 - 1e-12)) < CHANCE)


def left_out(
    parts: Parts, base: Parts, tires: Mapping[str, Tire], new: Mapping[str, Tire], pairs: Sequence[tuple[str, str]]
) -> tuple[LeftOut, frozenset[tuple[str, str]], bool]:
    """Return the errors with the given tires (factors of 1) and with the new tires (estimated factors).

    `parts`: of the answer; `base`: of the estimate without an effect, which is the same if the answer has none. Also
    returned: those of some factors, by axle and name, without which the error is larger, and whether it is with the
    estimated factors of `base`.
    """
    everything, one_each = base.unknowns.factors, [(pair,) for pair in pairs]
    if parts is base:
        (before, rms_before), (after, rms_after), *others = parts.errors(new, [everything, (), *one_each])
        scaled = after
    else:
        (before, rms_before), (scaled, _) = base.errors(tires, [everything, ()])
        (after, rms_after), *others = parts.errors(new, [(), *one_each])
    starts = parts.grid.t[pieces_of(parts.grid, parts.car)]
    spans = [starts[parts.number == i] for i in range(len(before))]
    rows = tuple(
        (float(some[0]), float(some[-1] + horizon(parts.car)), float(np.sqrt(first)), float(np.sqrt(second)))
        for some, first, second in zip(spans, before, after, strict=True)
    )
    better = frozenset(pair for pair, (without, _) in zip(pairs, others, strict=True) if is_better(without, after))
    return LeftOut(rms_before, rms_after, rows, is_better(before, after)), better, is_better(scaled, after)
