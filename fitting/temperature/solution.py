"""Gauss-Newton steps for the logarithms of coefficients of a heat balance and for start temperatures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from tirefmu.estimation.correlation import correlation_length

from .heat_balance import HeatBalance, integrated

FloatArray = npt.NDArray[np.float64]
Used = Sequence[npt.NDArray[np.bool_]]

#: Standard deviations of the priors: of a logarithm, and of a start temperature about the first recorded one, K.
SPREAD, START_SPREAD = 1.0, 10.0
#: Noise, K, and its correlation length, blocks, before residuals are known; rounds that estimate them.
FIRST_NOISE, FIRST_LENGTH, ROUNDS = 2.0, 50.0, 2
#: Step of a difference of a logarithm, its largest change in one step, iterations, and the change that ends them, in
#: standard deviations of the result.
STEP, LONGEST_STEP, ITERATIONS, CONVERGED = 1e-4, 1.0, 20, 0.03
#: Halvings of a step that does not reduce the cost.
HALVINGS = 6


@dataclass(frozen=True)
class Solution:
    """Values of coefficients and starts.

    - `free`: names of coefficients; `center`, `x`, shape (p,): prior mean and value of their logarithms.
    - `starts`, shape (n_recordings, m): start temperatures, K.
    - `noise`, `length`: standard deviation of the residual of a block, K, and its correlation length in blocks.
    - `spread`, shape (p,): standard deviations of the logarithms.
    """

    free: tuple[str, ...]
    center: FloatArray
    x: FloatArray
    starts: FloatArray
    noise: float = FIRST_NOISE
    length: float = FIRST_LENGTH
    spread: FloatArray = field(default_factory=lambda: np.empty(0))

    def values(self) -> dict[str, float]:
        """Return the coefficients by name."""
        return dict(zip(self.free, np.exp(self.x).tolist(), strict=True))

    def errors(self, balances: Sequence[HeatBalance]) -> list[FloatArray]:
        """Return predicted minus measured temperature at the nodes of each recording, K; NaN in pauses."""
        values = self.values()
        return [balance.temperatures(values, start)[:, 0] - balance.measured
                for balance, start in zip(balances, self.starts, strict=True)]  # fmt: skip


def solved(balances: Sequence[HeatBalance], used: Used, free: Sequence[str], begin: Solution | None = None) -> Solution:
    """Return the coefficients with the largest posterior density, for the used nodes of recordings.

    The residual is correlated: its sum of squares is divided by the correlation length, so that a recording counts as
    many rows as it has independent ones.
    """
    solution = begin or _first(balances, free)
    for _ in range(ROUNDS):
        solution = _converged(balances, used, solution)
        errors = [error[part] for error, part in zip(solution.errors(balances), used, strict=True)]
        segments = [np.cumsum(np.isnan(balance.measured))[part] + 1e6 * i
                    for i, (balance, part) in enumerate(zip(balances, used, strict=True))]  # fmt: skip
        error = np.concatenate(errors)
        noise, length = float(np.sqrt(np.mean(error**2))), correlation_length(error, np.concatenate(segments))
        solution = replace(solution, noise=max(noise, 1e-3), length=length)
    return _converged(balances, used, solution)


def _first(balances: Sequence[HeatBalance], free: Sequence[str]) -> Solution:
    declared = balances[0].tire.symbolic_model.coefficients
    center = np.log([declared[name].default for name in free])
    starts = [np.full(len(b.states), b.measured[np.isfinite(b.measured)][0]) for b in balances]
    return Solution(tuple(free), center, center.copy(), np.stack(starts))


def _converged(balances: Sequence[HeatBalance], used: Used, solution: Solution) -> Solution:
    for _ in range(ITERATIONS):
        residual, jacobian = _linearized(balances, used, solution)
        normal = jacobian.T @ jacobian
        change = np.asarray(np.linalg.solve(normal, -jacobian.T @ residual), dtype=np.float64)
        p = len(solution.x)
        change *= min(1.0, LONGEST_STEP / max(float(np.abs(change[:p]).max(initial=0.0)), 1e-12))
        spread = np.sqrt(np.diag(np.linalg.inv(normal)))[:p]
        for halving in range(HALVINGS):
            moved = _moved(solution, change * 0.5**halving)
            if _cost(balances, used, moved) <= float(residual @ residual):
                break
        else:
            return replace(solution, spread=spread)
        solution = replace(moved, spread=spread)
        if (np.abs(change[:p]) < CONVERGED * spread).all():
            break
    return solution


def _moved(solution: Solution, change: FloatArray) -> Solution:
    p = len(solution.x)
    return replace(
        solution, x=solution.x + change[:p], starts=solution.starts + change[p:].reshape(solution.starts.shape)
    )


def _prior(balances: Sequence[HeatBalance], solution: Solution) -> FloatArray:
    first = np.stack([b.measured[np.isfinite(b.measured)][:1] for b in balances])
    return np.concatenate([(solution.x - solution.center) / SPREAD, ((solution.starts - first) / START_SPREAD).ravel()])


def _cost(balances: Sequence[HeatBalance], used: Used, solution: Solution) -> float:
    weight = 1.0 / (solution.noise * np.sqrt(solution.length))
    errors = [weight * error[part] for error, part in zip(solution.errors(balances), used, strict=True)]
    residual = np.concatenate([*errors, _prior(balances, solution)])
    return float(residual @ residual)


def _linearized(balances: Sequence[HeatBalance], used: Used, solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Return residual and Jacobian, prior included, in standard deviations."""
    weight = 1.0 / (solution.noise * np.sqrt(solution.length))
    p, (k, m) = len(solution.x), solution.starts.shape
    residuals, slopes = [], []
    for i, (balance, part, start) in enumerate(zip(balances, used, solution.starts, strict=True)):
        matrix, supply = balance.system(solution.values())
        now = integrated(balance.t, matrix, supply, start)[:, 0]
        columns = np.zeros((int(part.sum()), p + k * m))
        for j in range(p):
            changed = replace(solution, x=solution.x + STEP * (np.arange(p) == j)).values()
            columns[:, j] = ((balance.temperatures(changed, start)[:, 0] - now) / STEP)[part]
        for j, unit in enumerate(np.eye(m)):
            columns[:, p + i * m + j] = integrated(balance.t, matrix, np.zeros_like(supply), unit)[part, 0]
        residuals.append(weight * (now - balance.measured)[part])
        slopes.append(weight * columns)
    spreads = np.concatenate([np.full(p, SPREAD), np.full(k * m, START_SPREAD)])
    return (
        np.concatenate([*residuals, _prior(balances, solution)]),
        np.concatenate([*slopes, np.diag(1.0 / spreads)]),
    )
