"""Errors of the form of a model: how large they are, and what they do to coefficients and predictions.

A Magic Formula describes no tire exactly, and a tire whose state changes with time is not one tire. Such an error is
described as an unknown relative change of a channel, F (1 + d): a random smooth function of the inputs (form), and of
time (state). A fit absorbs much of it in its coefficients, so its residual is smaller than the error. What a fit of
weights W with Jacobian J leaves of a function f is f - J H^-1 J^T W f, with H = J^T W J. The variances of both random
functions are those for which the sums of squared projections of the residual on their remainders have their
expected values (method of moments, as Rao's MINQUE, 1971). The noise in these sums is that of projections on functions
that change faster than any tire, or that of neighboring rows if it is smaller: in a long recording the sampled rows are
too few for such functions.

Both random functions are sums of random Fourier features (Rahimi and Recht, 2007), d = sum of w_k cos(a_k x + b_k) with
independent w_k. The error of a coefficient is a linear function of the w_k, and so is that of a prediction: what the
coefficients change minus the function itself. The residual shows some of these functions and excludes others, so that
their errors are the expected squares for w_k given the residual: where the residual shows an error, it is in the
interval; where it shows none, the interval is narrow. Beyond the range of the rows no residual excludes anything: the
error there has in addition the change of the function since the end of the range, which grows with the distance.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import nnls
from scipy.special import gammaincc, ndtri, stdtrit

from ...numerics.arrays import FloatArray
from ..problem.weighted_residuals import Problem
from .sample import Sample

#: Number of features of each random function.
FEATURES = 120
#: Length scales of the form, as shares of half the range of an input: of slips; of others, by half of the features.
SLIP_SCALE, SCALES = 0.4, (1.5, 0.4)
SLIPS = ("kappa", "alpha")
#: Shortest and longest length scale of the state, as shares of all rows; rows and share of the noise.
SLOW, FAST_ROWS, FAST = (0.01, 0.5), 3.0, 0.0015
#: The forces: what changes the friction of a tire changes both, so that both have the larger error.
FORCES = ("Fx", "Fy")
#: Normal quantile of 95 % intervals.
QUANTILE = float(ndtri(0.975))


@dataclass(frozen=True, eq=False)
class Features:
    """Random cosines of scaled inputs.

    - `names`: the inputs.
    - `lower`, `half`, shape (n_inputs,): the middle of each input's range is ``lower + half``.
    - `waves`, shape (n_inputs, FEATURES); 0 for an input that does not vary. `phases`, shape (FEATURES,).
    """

    names: tuple[str, ...]
    lower: FloatArray
    half: FloatArray
    waves: FloatArray
    phases: FloatArray

    @classmethod
    def of(cls, inputs: FloatArray, names: Sequence[str]) -> Features:
        """Return the features of rows with inputs of shape (n_inputs, n)."""
        rng = np.random.default_rng(0)
        lower, upper = np.quantile(inputs, (0.005, 0.995), axis=1)
        half = 0.5 * (upper - lower)
        varies = half > 0.005 * np.abs(inputs).max(axis=1)
        scale = np.repeat([[SLIP_SCALE] * 2 if name in SLIPS else SCALES for name in names], FEATURES // 2, axis=1)
        waves = rng.standard_normal((len(names), FEATURES)) / scale
        waves[~varies[:, None] | (rng.uniform(size=waves.shape) < 0.5)] = 0.0
        return cls(tuple(names), lower, np.where(varies, half, 1.0), waves, rng.uniform(0.0, 2.0 * np.pi, FEATURES))

    def at(self, inputs: FloatArray) -> FloatArray:
        """Return the features at inputs of shape (n_inputs, n), shape (n, FEATURES); mean square 1."""
        return np.asarray(np.sqrt(2.0) * np.cos(self._scaled(inputs).T @ self.waves + self.phases))

    def growth(self, inputs: FloatArray) -> FloatArray:
        """Return the mean square of the change of the function beyond the range of the rows, shape (n,).

        `inputs`, shape (n_inputs, n). The function goes on with the slope that it has at the end of the range, as no
        row shows that it returns.
        """
        scaled = self._scaled(inputs)
        beyond = scaled - np.clip(scaled, -1.0, 1.0)
        return np.asarray(np.mean((beyond.T @ self.waves) ** 2, axis=1))

    def _scaled(self, inputs: FloatArray) -> FloatArray:
        """Return inputs as shares of half their range, from its middle."""
        return np.asarray((inputs - self.lower[:, None]) / self.half[:, None] - 1.0)


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Error of the form of a model in one channel.

    - `form`, `state`: standard deviations of the relative error over the inputs, and over time.
    - `form_chance`, `state_chance`: probabilities of such large sums of squares under noise alone.
    - `features`: of the form.
    - `names`: the coefficients.
    - `response`, shape (n_coefficients, 2 FEATURES): their derivatives by the weights of both functions.
    - `information`, shape (2 FEATURES, 2 FEATURES), and `score`, shape (2 FEATURES,): of the weights in the residual.
    - `final`: whether the stage is the last one that fits the channel.
    """

    channel: str
    form: float
    state: float
    form_chance: float
    state_chance: float
    features: Features
    names: tuple[str, ...]
    response: FloatArray
    information: FloatArray
    score: FloatArray
    final: bool = True

    @cached_property
    def squares(self) -> FloatArray:
        """Expected products of the weights given the residual, shape (2 FEATURES, 2 FEATURES)."""
        scale = np.repeat([self.form, self.state], FEATURES) / FEATURES**0.5
        scaled = np.eye(2 * FEATURES) + scale[:, None] * self.information * scale
        covariance = scale[:, None] * np.linalg.inv(scaled) * scale
        mean = covariance @ self.score
        return np.asarray(covariance + np.outer(mean, mean))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the coefficients, shape (n_coefficients, n_coefficients)."""
        return np.asarray(self.response @ self.squares @ self.response.T)

    def of(self, names: Collection[str]) -> Discrepancy:
        """Return the same for some of the coefficients."""
        rows = [i for i, name in enumerate(self.names) if name in names]
        return replace(self, names=tuple(self.names[i] for i in rows), response=self.response[rows])

    def variance(self, slopes: FloatArray, values: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the variance of the error of predictions, shape (n,).

        `slopes`, shape (n_coefficients, n): derivatives by the coefficients. `values`, shape (n,): of predictions that
        are proportional to the channel, otherwise 0. `inputs`, shape (n_inputs, n): where the channel determines them.
        """
        error = self._error(slopes, values, inputs)
        unseen = self.state**2 + self.form**2 * self.features.growth(inputs)
        return np.asarray(np.sum((error @ self.squares) * error, axis=1) + unseen * values**2)

    def informed(
        self, slopes: FloatArray, values: FloatArray, inputs: FloatArray, error: FloatArray, deviation: FloatArray
    ) -> Discrepancy:
        """Return the same with errors of predictions that are known.

        The rows near zero slip and at the peak are few among the sampled ones; all of them contain much more
        information about these places.

        `slopes`, `values`, `inputs`: as for `variance`. `error`, `deviation`, shape (n,): prediction minus the value
        that was read from the data, and its standard deviation.
        """
        rows = self._error(slopes, values, inputs) / deviation[:, None]
        return replace(
            self, information=self.information + rows.T @ rows, score=self.score + rows.T @ (error / deviation)
        )

    def _error(self, slopes: FloatArray, values: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the errors of predictions by the weights, shape (n, 2 FEATURES)."""
        error = slopes.T @ self.response
        error[:, :FEATURES] -= values[:, None] * self.features.at(inputs)
        return np.asarray(error)


def discrepancies(problem: Problem, samples: Iterable[Sample], inverse: FloatArray) -> tuple[Discrepancy, ...]:
    """Return the error of the form in each channel that a stage fits.

    `samples`: of the channels. `inverse`, shape (n_free, n_free): of J^T W J; 0 for coefficients that are fixed, and
    along directions that are not identifiable.
    """
    estimated = (_of_channel(problem, inverse, problem.tire.outputs[sample.channel], sample) for sample in samples)
    present = [discrepancy for discrepancy in estimated if discrepancy]
    both = [discrepancy for discrepancy in present if discrepancy.channel in FORCES]
    form, state = (max((getattr(discrepancy, name) for discrepancy in both), default=0.0) for name in ("form", "state"))
    return tuple(
        replace(discrepancy, form=form, state=state) if discrepancy in both else discrepancy for discrepancy in present
    )


def _of_channel(problem: Problem, inverse: FloatArray, channel: str, sample: Sample) -> Discrepancy | None:
    """Return the error of the form in a channel; None if the fit leaves nothing of any function of inputs or time."""
    features = Features.of(sample.rows.inputs, problem.tire.inputs)
    rng = np.random.default_rng(1)

    def timed(lengths: FloatArray | float) -> FloatArray:
        waves = rng.standard_normal(FEATURES) / lengths
        phases = rng.uniform(0.0, 2.0 * np.pi, FEATURES)
        return np.asarray(np.sqrt(2.0) * np.cos(sample.place[:, None] * waves + phases))

    slow = timed(SLOW[0] * (SLOW[1] / SLOW[0]) ** rng.uniform(size=FEATURES))
    functions = [sample.computed[:, None] * function for function in (features.at(sample.rows.inputs), slow)]
    responses = [inverse @ (sample.gradient @ function) for function in functions]
    left = [function - sample.jacobian.T @ response for function, response in zip(functions, responses, strict=True)]
    fast = max(FAST_ROWS / sample.of, FAST)
    quick = sample.computed[:, None] * np.concatenate([timed(fast), timed(2.0 * fast)], axis=1)
    fast = sample.weight[:, None] * quick
    noise = float(np.sum((sample.residual @ fast) ** 2) / max(float(np.sum(fast**2)), 1e-300))
    noise = max(min(noise, sample.noise), 1e-300)
    estimate = _estimated(sample, left, noise)
    if estimate is None:
        return None
    response, shown = problem.scale[:, None] * np.hstack(responses), np.hstack(left)
    information, score = shown.T @ shown / noise, -(sample.residual @ shown) / noise
    return Discrepancy(channel, *estimate, features, problem.free, response, information, score)


def _estimated(sample: Sample, left: Sequence[FloatArray], noise: float) -> tuple[float, float, float, float] | None:
    """Return the standard deviations of form and state, and the chances of such sums of squares under noise alone.

    `left`: what the fit leaves of the features of both.
    """
    weighted = [sample.weight[:, None] * function for function in left]
    expected = noise * np.array([float(np.sum(function**2)) for function in weighted])
    excess = np.array([float(np.sum((sample.residual @ function) ** 2)) for function in weighted]) - expected
    matrix = np.array([[float(np.sum((a.T @ b) ** 2)) / FEATURES for b in left] for a in weighted])
    deviation = noise * np.sqrt(2.0) * np.array([float(np.sqrt(np.sum((w.T @ w) ** 2))) for w in weighted])
    if not (matrix.diagonal() > 0.0).all() or not (deviation > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(matrix.diagonal())
    variances = nnls(matrix * np.outer(scale, scale), excess * scale)[0] * scale
    variances *= [_for_few(a.T @ b) for a, b in zip(left, weighted, strict=True)]
    chances = gammaincc((expected / deviation) ** 2, (excess + expected) * expected / deviation**2)
    return float(variances[0] ** 0.5), float(variances[1] ** 0.5), float(chances[0]), float(chances[1])


def _for_few(left: FloatArray) -> float:
    """Return the factor of a variance that was estimated from few independent projections, for 95 % intervals.

    `left`, shape (n_features, n_features): L^T W L of what a fit leaves of the features. The estimate is a sum of
    squares with weights that are the squares of its eigenvalues: about chi-squared (Satterthwaite, 1946).
    """
    squares = np.linalg.eigvalsh(left) ** 2
    freedom = float(np.sum(squares) ** 2 / np.sum(squares**2))
    return float((stdtrit(freedom, 0.975) / QUANTILE) ** 2)
