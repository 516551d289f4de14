"""What the rows of maneuvers determine: the parts of the sandwich covariance of a fit, before anything is measured.

A least-squares fit with weights w of the channels has, to first order, the covariance (White 1980; Newey, West 1987)

    C = H^-1 (B + P) H^-1,    H = sum J' w J + P,    B = sum f J' w s^2 w J,

with the derivatives J of the forces by the coefficients, in their typical sizes, and the prior P of one typical size.
The variance s^2 has the noise of the outputs and that of the inputs, which acts through the derivatives of the forces
by the inputs and is common to all channels. Noise of correlation time tau in rows of distance h counts
f = coth(h / 2 tau) times. Offsets and drift of a channel are common to all maneuvers: the sum of their scores is
squared, not the sum of squares.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.estimation.one_thread import one_blas_thread
from tirefmu.fitting.problem.influence import typical_size
from tirefmu.fitting.problem.weighted_residuals import coefficients_by_output
from tirefmu.measurements import Noise
from tirefmu.measurements.virtual_bench.sensor_noise import ChannelNoise
from tirefmu.tires import Tire
from tirefmu.tires.code import fastest_code

FloatArray = npt.NDArray[np.float64]
#: The channels that determine a plan.
CHANNELS = ("Fx", "Fy", "Mz")
#: Rows of a maneuver at which derivatives are evaluated; each stands for as many of its rows.
POINTS, WEIGHT_POINTS = 60, 20
#: Tires over which a plan is averaged: the given one and draws around it with this relative deviation.
TIRES, DEVIATION = 4, 0.1


def tires_around(tire: Tire) -> tuple[Tire, ...]:
    """Return a tire and random ones near it, in adapted SAE: the values are not known before the test.

    >>> from tirefmu.tires import published
    >>> [round(one.values["PDY1"], 2) for one in tires_around(published("trento_hoosier"))]
    [2.72, 2.68, 2.56, 2.88]
    """
    tire, random = tire.in_signs("adapted-sae"), np.random.default_rng(0)
    tires, free = [tire], free_coefficients(tire)
    for _ in range(TIRES - 1):
        factors = dict(zip(free, 1.0 + DEVIATION * random.standard_normal(len(free)), strict=True))
        tires.append(
            replace(tire, values={name: value * factors.get(name, 1.0) for name, value in tire.values.items()})
        )
    return tuple(tires)


def free_coefficients(tire: Tire) -> tuple[str, ...]:
    """Return the coefficients that a fit of the forces and the aligning moment frees."""
    model = tire.symbolic_model
    by_output = coefficients_by_output(model, straight=True)
    reach = frozenset[str]().union(*(by_output[name] for name in CHANNELS if name in by_output))
    live = model.live(tire.has) & reach
    return tuple(name for name, declared in model.coefficients.items() if name in live and declared.fitted)


@dataclass(frozen=True, eq=False)
class Experiment:
    """Tires of one model that may be on the bench, and its noise.

    - `tires`: in adapted SAE, the most plausible one first.
    """

    tires: tuple[Tire, ...]
    noise: Noise

    @cached_property
    def free(self) -> tuple[str, ...]:
        """The coefficients that the test has to determine."""
        return free_coefficients(self.tires[0])

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The measured channels."""
        return tuple(name for name in CHANNELS if name in self.tires[0].outputs)

    @cached_property
    def sources(self) -> tuple[str, ...]:
        """The channels with noise: outputs, then inputs."""
        return (*self.channels, *self.tires[0].inputs)

    def noise_of(self, source: str) -> ChannelNoise:
        """Return the noise of a channel."""
        return self.noise.channels.get(source, ChannelNoise())

    @cached_property
    def sizes(self) -> FloatArray:
        """The typical size of each free coefficient, shape (p,)."""
        declared = self.tires[0].symbolic_model.coefficients
        values = self.tires[0].values
        return np.array([typical_size(declared[n].lower, declared[n].upper, values[n]) for n in self.free])

    def derivatives(self, tire: Tire, inputs: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return forces (c, n), their derivatives by the coefficients in sizes (n, c, p), and by the inputs (n, c, u).

        `inputs`, shape (u, n): in the order of the model.
        """
        model = tire.symbolic_model
        code, parameters, names = fastest_code(model), tire.parameters(), list(model.parameters)
        rows, outputs = tire.effective_inputs(inputs), [tire.outputs.index(name) for name in self.channels]
        columns = [names.index(name) for name in self.free]
        factors = self.sizes * np.array([tire.rescaled.get(name, 1.0) for name in self.free])
        by_coefficients = code.jacobian_parameters(rows, parameters)[:, outputs][:, :, columns] * factors
        by_inputs = code.jacobian_inputs(rows, parameters)[:, outputs]
        return code.forces(rows, parameters)[outputs], np.nan_to_num(by_coefficients), np.nan_to_num(by_inputs)

    def deviations(self, forces: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the standard deviation of the random noise of each source at rows, shape (n_sources, n)."""
        values = np.concatenate([forces, inputs])
        parts = [self.noise_of(source) for source in self.sources]
        return np.array([np.hypot(p.constant, p.proportional * np.abs(v)) for p, v in zip(parts, values, strict=True)])

    def correlation_factor(self, t: FloatArray) -> float:
        """Return how often noise of rows counts that is correlated in time."""
        tau, step = self.noise.correlation_time, float(np.median(np.diff(t))) if len(t) > 1 else np.inf
        return 1.0 if tau == 0.0 or not np.isfinite(step) else float(1.0 / np.tanh(step / (2.0 * tau)))

    def inputs_of(self, table: pd.DataFrame) -> FloatArray:
        """Return the rows of a table in the order of the model, shape (u, n)."""
        tire = self.tires[0]
        columns = [
            table[n].to_numpy(float) if n in table else np.full(len(table), tire.nominal(n)) for n in tire.inputs
        ]
        return np.array(columns)

    @cached_property
    def spread(self) -> dict[str, ChannelNoise]:
        """The noise of each source."""
        return {source: self.noise_of(source) for source in self.sources}


@dataclass(frozen=True, eq=False)
class _Evaluated:
    """The rows of some tables at a tire, thinned.

    - `ends`: where the rows of the next table begin.
    - `counts`, `factors`, shape (m,): rows that a row stands for; how often their correlated noise counts.
    - `forces`, shape (c, n). `by_coefficients`, shape (n, c, p). `unit`, shape (n, c, k): effect of a unit error of
      each source on the channels. `deviations`, shape (k, n): standard deviation of the noise of each source.
    """

    ends: npt.NDArray[np.intp]
    counts: FloatArray
    factors: FloatArray
    forces: FloatArray
    by_coefficients: FloatArray
    unit: FloatArray
    deviations: FloatArray


def thinned(rows: int, points: int) -> npt.NDArray[np.intp]:
    """Return the indices of at most `points` rows, at equal distances.

    >>> thinned(100, 3).tolist()
    [0, 50, 99]
    """
    return np.unique(np.linspace(0, rows - 1, points).round().astype(np.intp))


def _evaluated(experiment: Experiment, tables: Sequence[pd.DataFrame], points: int) -> Iterator[_Evaluated]:
    """Yield the rows of some tables, `points` of each, for every tire."""
    some = [table.iloc[thinned(len(table), points)] for table in tables]
    inputs = np.concatenate([experiment.inputs_of(table) for table in some], axis=1)
    ends = np.cumsum([len(table) for table in some])[:-1]
    counts = np.array([len(table) / len(part) for table, part in zip(tables, some, strict=True)])
    factors = np.array([experiment.correlation_factor(table["t"].to_numpy(float)) for table in tables])
    for tire in experiment.tires:
        forces, by_coefficients, by_inputs = experiment.derivatives(tire, inputs)
        own = np.broadcast_to(np.eye(len(forces)), (inputs.shape[1], len(forces), len(forces)))
        unit = np.concatenate([own, by_inputs], axis=2)
        deviations = experiment.deviations(forces, inputs)
        yield _Evaluated(ends, counts, factors, forces, by_coefficients, unit, deviations)


def fisher(
    experiment: Experiment, tables: Sequence[pd.DataFrame], responses: Sequence[FloatArray] = (), points: int = POINTS
) -> FloatArray:
    """Return the Fisher information of the rows of each table by tire, shape (m, t, p + e + k, p + e + k).

    The noise has its covariance among channels. Offsets of the k sources, in their standard deviations, are estimated
    with the coefficients; drift has an independent value in each table. `responses`: of each tire, e further columns at
    the rows of `thinned`, shape (n, c, e). `points`: rows of a table at which derivatives are evaluated.
    """
    found = []
    spread = experiment.spread.values()
    offset, drift = (np.array([getattr(part, name) for part in spread]) for name in ("offset", "drift"))
    for number, rows in enumerate(_evaluated(experiment, tables, points)):
        noise = np.einsum("nck,kn,ndk->ncd", rows.unit, rows.deviations**2, rows.unit)
        noise += 1e-9 * np.einsum("ncc->nc", noise).max() * np.eye(noise.shape[-1])  # of channels without noise
        more = responses[number : number + 1]
        columns = np.concatenate([rows.by_coefficients, *more, rows.unit * offset, rows.unit * drift], axis=2)
        whitened = np.linalg.solve(np.linalg.cholesky(noise), columns)
        with one_blas_thread():
            parts = [part.reshape(-1, part.shape[-1]) for part in np.split(whitened, rows.ends)]
            found.append([
                _without_drift(count / factor * part.T @ part, len(offset))
                for part, count, factor in zip(parts, rows.counts, rows.factors, strict=True)
            ])  # fmt: skip
    return np.swapaxes(np.array(found), 0, 1)


def _without_drift(matrix: FloatArray, k: int) -> FloatArray:
    """Return the information without its last k parameters, which have a prior deviation of 1."""
    kept, cross, last = matrix[:-k, :-k], matrix[:-k, -k:], matrix[-k:, -k:]
    return np.asarray(kept - cross @ np.linalg.solve(last + np.eye(k), cross.T))


def energies(experiment: Experiment, tables: Sequence[pd.DataFrame]) -> FloatArray:
    """Return the sliding energy of each table, J, for the most plausible tire."""
    found = []
    for table in tables:
        forces, _, _ = experiment.derivatives(experiment.tires[0], experiment.inputs_of(table))
        named = dict(zip(experiment.channels, forces, strict=True))
        slip = {"Fx": table["kappa"].to_numpy(float), "Fy": np.tan(table["alpha"].to_numpy(float))}
        power = sum(np.abs(named[name] * slip[name]) for name in slip if name in named) * table["V"].to_numpy(float)
        found.append(float(np.mean(power) * (table["t"].iloc[-1] - table["t"].iloc[0])))
    return np.array(found)


@dataclass(frozen=True, eq=False)
class Information:
    """The parts of the covariance of a fit by maneuver m and tire t; p coefficients, k sources of noise.

    - `curvature`, `scores`, shape (m, t, p, p): H and B without prior, offsets and drift.
    - `systematic`, shape (m, t, k, p): the scores of a unit error of each source.
    """

    curvature: FloatArray
    scores: FloatArray
    systematic: FloatArray

    def with_independent(self, drift: FloatArray) -> Information:
        """Return the parts with a drift that has an independent value in each maneuver; its deviations, shape (k,)."""
        return replace(self, scores=self.scores + common_scores(self.systematic, drift))

    def take(self, chosen: Sequence[int]) -> Information:
        """Return some of the maneuvers."""
        index = np.array(chosen, dtype=int)
        return Information(*(part[index] for part in vars(self).values()))


def channel_weights(experiment: Experiment, tables: Sequence[pd.DataFrame]) -> FloatArray:
    """Return the weights that a fit gives the channels: one over the mean variance of their residuals, shape (c,)."""
    rows = next(_evaluated(experiment, tables, WEIGHT_POINTS))
    variances = np.einsum("nck,kn->nc", rows.unit**2, rows.deviations**2)
    return np.asarray(1.0 / np.maximum(variances.mean(axis=0), 1e-12))


def information(experiment: Experiment, tables: Sequence[pd.DataFrame], weights: FloatArray) -> Information:
    """Return what a fit learns from the rows of each table.

    `weights`, shape (c,): of `channel_weights`.
    """
    p = len(experiment.free)
    parts: list[list[tuple[FloatArray, FloatArray, FloatArray]]] = []
    for rows in _evaluated(experiment, tables, POINTS):
        unit = np.einsum("ncp,c,nck->nkp", rows.by_coefficients, weights, rows.unit)  # scores of a unit error
        split = zip(
            np.split(np.sqrt(weights)[:, None] * rows.by_coefficients, rows.ends), np.split(unit, rows.ends),
            np.split(unit * rows.deviations.T[:, :, None], rows.ends), rows.counts, rows.factors, strict=True,
        )  # fmt: skip
        with one_blas_thread():
            parts.append([
                (count * _square(root.reshape(-1, p)), count * factor * _square(noise.reshape(-1, p)),
                 count * scores.sum(axis=0))
                for root, scores, noise, count, factor in split
            ])  # fmt: skip
    curvature, scores, systematic = (np.array([[one[i] for one in tire] for tire in parts]) for i in range(3))
    return Information(*(np.swapaxes(part, 0, 1) for part in (curvature, scores, systematic)))


def _square(rows: FloatArray) -> FloatArray:
    return np.asarray(rows.T @ rows)


def covariances(experiment: Experiment, information: Information, times: FloatArray) -> FloatArray:
    """Return the covariance of the coefficients, in sizes, by tire, shape (t, p, p).

    `information`: the maneuvers of a program in their order. `times`, shape (m,): when each takes place, s: drift is a
    sine of the period of the bench with an unknown phase.
    """
    curvature = information.curvature.sum(axis=0)
    scores = information.scores.sum(axis=0)
    phase = 2.0 * pi * times / experiment.noise.drift_period
    parts = np.array([[part.offset, part.drift, part.drift] for part in experiment.spread.values()])
    shapes = np.array([np.ones(len(times)), np.sin(phase), np.cos(phase)])
    common = np.einsum("mtkp,sm,ks->tkps", information.systematic, shapes, parts)
    scores += np.einsum("tkps,tkqs->tpq", common, common)
    return sandwich(curvature, scores)


def common_scores(systematic: FloatArray, deviations: FloatArray) -> FloatArray:
    """Return the part of B of errors that are common to rows, shape (..., p, p).

    `systematic`, shape (..., k, p): sums of their scores. `deviations`, shape (k,).
    """
    scaled = systematic * deviations[:, None]
    return np.asarray(np.swapaxes(scaled, -1, -2) @ scaled)


def sandwich(curvature: FloatArray, scores: FloatArray) -> FloatArray:
    """Return the covariances for H and B without their priors, shape (t, p, p)."""
    inverse = inverse_of(curvature)
    with one_blas_thread():
        return np.asarray(inverse @ (scores + np.eye(scores.shape[-1])) @ inverse)


def inverse_of(curvature: FloatArray) -> FloatArray:
    """Return the inverse of H with its prior, shape (t, p, p); scaled to a unit diagonal first, for its accuracy."""
    matrix = curvature + np.eye(curvature.shape[-1])
    scale = 1.0 / np.sqrt(np.einsum("tpp->tp", matrix))
    both = scale[:, :, None] * scale[:, None, :]
    with one_blas_thread():
        return np.asarray(np.linalg.inv(matrix * both) * both)
