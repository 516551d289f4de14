"""Effect screening: finite probes of each effect, tested on the residual with the baseline model projected out."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...numerics.arrays import FloatArray, IntArray
from ...numerics.block_regression import (
    BlockSums,
    Regression,
    autocovariance,
    block_sums,
    coloured_covariance,
    regression,
)
from ...symbolic.detection import Form, Probe
from ..least_squares import LeastSquares, Solution
from ..signals.simulation import Simulator
from ..thresholds import FREE_PRIOR, MIN_INDEPENDENT_SHARE, MIN_ROWS_OF_BLOCK
from .baseline_fit import readable
from .candidates import Candidate, counts_from_neutral, is_testable

#: Longest lag of the noise covariance in the test, s; the block jackknife covers longer correlations. Convention.
MAX_CORRELATION_TIME = 1.0
#: Largest change of the residual of a block that is not used, in root mean squares of the channel. Convention.
LARGEST_CHANGE = 3.0


@dataclass(frozen=True, eq=False)
class Response:
    """Response of the forces to the probes of a form, and its estimate from the residual.

    - `columns`, shape (n_channels, n, k): weighted responses, one per probe.
    - `estimate`, shape (k,): amplitudes, in units of the probes.
    - `coloured`, shape (k,): standard errors of the estimate from the autocovariance of the noise.
    - `error`, shape (k,): the larger one of these and of those from the jackknife over blocks.
    - `independent_share`: largest share of a response's norm that is orthogonal to the baseline's tangent space.
    """

    columns: FloatArray
    estimate: FloatArray
    coloured: FloatArray
    error: FloatArray
    independent_share: float


class Screen:
    """Linearization at a solution, for tests of responses on its residual."""

    def __init__(self, problem: LeastSquares, solution: Solution) -> None:
        self.problem, self.solution = problem, solution
        self.signals = problem.simulator.signals
        jacobian = problem.simulator.jacobian(solution.parameters, solution.free)
        self.tangent = problem.weighted(np.concatenate([jacobian, problem.disturbances.columns], axis=-1))
        self.residual = problem.weighted(solution.residual)
        center, deviation = problem.prior(solution.free)
        values = solution.parameters[[problem.simulator.index[name] for name in solution.free]]
        errors = problem.disturbances
        self.prior_precision = np.concatenate([deviation, errors.deviation]) ** -2.0
        self.prior_gradient = np.concatenate(
            [(center - values) / deviation**2, (errors.center - solution.disturbance) / errors.deviation**2]
        )
        self.edges = _edges(self.signals.block, problem.inverse_noise)
        self._baseline_forces = problem.simulator.forces(solution.parameters)

    @cached_property
    def sums(self) -> BlockSums:
        """The cross products by block."""
        return block_sums(self.tangent, self.residual, self.edges)

    @cached_property
    def baseline(self) -> Regression:
        """The regression of the residual on the tangent space, also without each block."""
        return regression(self.sums, self.prior_precision, self.prior_gradient)

    @property
    def n_blocks(self) -> int:
        """The number of blocks with data."""
        return len(self.edges) - 1

    @cached_property
    def change_without_block(self) -> FloatArray:
        """The change of the residuals of each block if it is not used for the estimate, N and N m.

        All coefficients follow linearly, and those that one block alone determines would follow too far: it is at most
        `LARGEST_CHANGE` root mean squares of the channel's residual.
        """
        change, inverse_noise = np.zeros_like(self.residual), self.problem.inverse_noise
        for g, (first, last) in enumerate(pairwise(self.edges.tolist())):
            shift = self.baseline.others[g] - self.baseline.estimate
            change[:, first:last] -= self.tangent[:, first:last] @ shift
        used = inverse_noise > 0.0
        change = np.divide(change, inverse_noise, out=np.zeros_like(change), where=used)
        squares = np.sum(self.solution.residual**2, axis=1, where=used, keepdims=True)
        limit = LARGEST_CHANGE * np.sqrt(squares / np.maximum(used.sum(axis=1, keepdims=True), 1))
        return np.clip(change, -limit, limit)

    def losses(self, edges: IntArray) -> FloatArray:
        """Return the squared misfit of each part between edges with the estimate from the others."""
        sums = block_sums(self.tangent, self.residual, edges)
        return regression(sums, self.prior_precision, self.prior_gradient).loss

    def columns(self, form: Form) -> FloatArray:
        """Return the weighted responses of the forces to a form's probes, shape (n_channels, n, k)."""
        simulator = self.problem.simulator
        moved = [simulator.forces(probed(simulator, self.solution, form, probe)) for probe in form.probes]
        return self.problem.weighted(np.nan_to_num(np.stack(moved, axis=-1) - self._baseline_forces[:, :, None]))

    def project(self, columns: FloatArray) -> FloatArray:
        """Return columns with the baseline's tangent space projected out."""
        q, k = self.tangent.shape[-1], columns.shape[-1]
        cross = self.tangent.reshape(-1, q).T @ columns.reshape(-1, k)
        return np.asarray(columns - self.tangent @ (self.baseline.inverse @ cross))

    def _autocovariance(self, noise: FloatArray) -> FloatArray:
        t, used = self.signals.t[self.signals.rows], self.problem.inverse_noise > 0.0
        step = float(np.median(np.diff(t))) if self.signals.timed else MAX_CORRELATION_TIME / 25.0
        lags = int(np.clip(MAX_CORRELATION_TIME / max(step, 1e-6), 5, 200))
        return autocovariance(np.where(used, noise, 0.0), used, lags)

    def standard_errors(self) -> FloatArray:
        """Return standard errors of coefficients and disturbances.

        They are those of the sandwich estimator for coloured noise, or the mean with the jackknife's if that is larger.
        """
        inverse = self.baseline.inverse
        coloured = np.diag(inverse @ coloured_covariance(self.tangent, self._autocovariance(self.residual)) @ inverse)
        blocks = np.maximum(np.diag(self.baseline.jackknife), 0.0)
        # With few correlated rows the sandwich estimate can be negative. It is then ignored.
        return np.sqrt(np.where(coloured > 0.0, np.maximum(coloured, 0.5 * (coloured + blocks)), blocks))

    def responses(self, groups: Sequence[FloatArray]) -> list[Response]:
        """Return the regressions of the residual on groups of columns, each of shape (n_channels, n, k).

        The noise is the part of the residual that no combination of all of them explains.
        """
        if not groups:
            return []
        columns, q = np.concatenate(groups, axis=-1), self.tangent.shape[-1]
        free = self.project(columns)
        flat = free.reshape(-1, free.shape[-1])
        matrix = flat.T @ flat
        matrix += np.diag(1e-3 * np.diag(matrix) + 1e-9)
        explained = free @ np.linalg.solve(matrix, flat.T @ self.residual.ravel())
        covariance = self._autocovariance(self.residual - explained)
        sums = block_sums(np.concatenate([self.tangent, columns], axis=-1), self.residual, self.edges)
        ends = np.cumsum([0, *(group.shape[-1] for group in groups)]).tolist()
        responses = []
        for group, begin, end in zip(groups, ends, ends[1:], strict=False):
            at = np.r_[:q, q + begin : q + end]
            beside = BlockSums(sums.matrix[:, at[:, None], at], sums.target[:, at], sums.power)
            responses.append(self._response(group, free[:, :, begin:end], beside, covariance))
        return responses

    def _response(self, columns: FloatArray, free: FloatArray, sums: BlockSums, covariance: FloatArray) -> Response:
        """Return the regression on columns, which are the last ones of the cross products; `free`: projected."""
        k, q = columns.shape[-1], self.tangent.shape[-1]
        independent, size = np.sqrt(np.sum(free**2, axis=(0, 1))), np.sqrt(np.sum(columns**2, axis=(0, 1)))
        testable = independent > np.maximum(MIN_INDEPENDENT_SHARE * size, 1e-6)
        share = float(np.max(independent / np.maximum(size, 1e-300)))
        if not testable.any():
            return Response(columns, np.zeros(k), np.full(k, np.inf), np.full(k, np.inf), share)
        prior = np.concatenate([self.prior_precision, np.full(k, FREE_PRIOR**-2.0)])
        fit = regression(sums, prior, np.concatenate([self.prior_gradient, np.zeros(k)]))
        inner = fit.inverse[q:, q:]
        coloured = np.diag(inner @ coloured_covariance(free, covariance) @ inner)
        variance = np.maximum(coloured, np.diag(fit.jackknife)[q:])
        alone, larger = (np.sqrt(np.maximum(square, 1e-300)) for square in (coloured, variance))
        return Response(columns, fit.estimate[q:], alone, larger, share)


@dataclass(frozen=True, eq=False)
class Tried:
    """A form of a candidate at a point of its grid, with its response in a residual."""

    name: str
    form: Form
    response: Response


def tried(screen: Screen, candidates: Mapping[str, Candidate]) -> list[Tried]:
    """Estimate the noise, and return each form of the candidates that a recording can show, with its response."""
    simulator, free = screen.problem.simulator, screen.solution.free
    forms = [
        (name, form)
        for name, candidate in candidates.items()
        if is_testable(screen.signals, simulator.tire, candidate)
        for declared in candidate.forms
        for point in declared.points()
        if (form := unfitted(point, simulator, free)) is not None
    ]
    responses = screen.responses([screen.columns(form) for _, form in forms])
    return [Tried(name, form, response) for (name, form), response in zip(forms, responses, strict=True)]


def probed(simulator: Simulator, solution: Solution, form: Form, probe: Probe) -> FloatArray:
    """Return the parameters of a solution with a probe applied, at the first point of the form's grid.

    Coefficients that are already fitted are shifted by the probe, and their values on the grid are ignored.
    """
    parameters = solution.parameters.copy()
    declarations = simulator.symbolic_model.coefficients
    for name, values in form.grid.items():
        if name not in solution.free:
            parameters[simulator.index[name]] = values[0]
    for name, size in probe.items():
        index, declaration = simulator.index[name], declarations[name]
        adds = counts_from_neutral(declaration) and (declaration.neutral != 0.0 or name in solution.free)
        parameters[index] = parameters[index] + size if adds else size
    if form.holds and not set(probe) & set(solution.free):
        _hold(simulator, form.holds, solution.parameters, parameters)
    return parameters


def _hold(simulator: Simulator, role: str, before: FloatArray, parameters: FloatArray) -> None:
    """Rescale the leading coefficient of a role so that its quantity at nominal inputs is as before."""
    leading = simulator.symbolic_model.leading(role)
    if leading in simulator.index:
        first, last = (simulator.at_nominal(role, point) for point in (before, parameters))
        parameters[simulator.index[leading]] *= first / last if first * last > 0.0 else 1.0


def starts(simulator: Simulator, solution: Solution, form: Form, estimate: FloatArray) -> list[FloatArray]:
    """Return initial values for a fit with a form: by the estimated amplitudes, or by each probe."""
    if not form.scalable:
        return [probed(simulator, solution, form, probe) for probe in form.probes]
    start = probed(simulator, solution, form, {})
    for probe, times in zip(form.probes, estimate, strict=True):
        for name, value in probe.items():
            start[simulator.index[name]] += float(np.clip(times, -3.0, 3.0)) * value
    return [start]


def unfitted(form: Form, simulator: Simulator, free: Collection[str]) -> Form | None:
    """Return a form with the coefficients that influence a measured channel and are not free, or None."""
    names = [n for n in readable(form.free, simulator.signals, simulator.symbolic_model) if n not in free]
    probes = tuple(probe for probe in form.probes if set(probe) & set(names))
    return replace(form, free=tuple(names), probes=probes) if names and probes else None


def _edges(block: IntArray, inverse_noise: FloatArray) -> IntArray:
    """Return the first row of each block with data, and the number of rows; hold-out rows join their neighbours."""
    first = np.flatnonzero(np.diff(block, prepend=-1))
    counts = np.add.reduceat((inverse_noise > 0.0).any(axis=0).astype(np.int64), first)
    least = min(MIN_ROWS_OF_BLOCK, 0.5 * float(np.median(counts[counts > 0])))
    return np.concatenate([first[counts > least], [len(block)]]).astype(np.int64)
