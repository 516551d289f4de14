"""What the rows of maneuvers determine: the parts of the sandwich covariance of a fit, before anything is measured.

A least-squares fit with weights w of the channels has, to first order, the covariance (White 1980; Newey, West 1987)

    C = H^-1 (B + P) H^-1,    H = sum J' w J + P,    B = sum f J' w s^2 w J,

with the derivatives J of the forces by the coefficients, in their typical sizes, and the prior P of one typical size.
The variance s^2 has the noise of the outputs and that of the inputs, which acts through the derivatives U of the forces
by the inputs and is common to all channels. Noise of correlation time tau in rows of distance h counts
f = coth(h / 2 tau) times. Offsets and drift of a channel are common to all maneuvers: the sum of their scores J' w U is
squared, not the sum of squares. H, these scores, and the products with responses of effects are parts of one matrix,
the products of all columns (J, responses, U).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...fitting.problem.influence import typical_size
from ...fitting.problem.weighted_residuals import coefficients_by_output
from ...measurements import ChannelNoise, Noise
from ...numerics.one_thread import one_blas_thread
from ...tires import Tire
from ...tires.code import fastest_code

FloatArray = npt.NDArray[np.float64]
#: The channels that determine a plan.
CHANNELS = ("Fx", "Fy", "Mz")
#: Rows of a maneuver at which derivatives are evaluated; a point counts as many of its rows.
POINTS = 60
#: Tires over which a plan is averaged: the given one and draws around it with this relative deviation.
TIRES, DEVIATION = 4, 0.1


def tires_around(tire: Tire) -> tuple[Tire, ...]:
    """Return a tire and random ones near it, in adapted SAE: the values are not known before the test.

    >>> from tirefmu.tires import published
    >>> [round(tire.values["PDY1"], 2) for tire in tires_around(published("trento_hoosier"))]
    [2.72, 2.68, 2.56, 2.88]
    """
    tire, random = tire.in_signs("adapted-sae"), np.random.default_rng(0)
    free = free_coefficients(tire)
    draws = 1.0 + DEVIATION * random.standard_normal((TIRES - 1, len(free)))
    changed = [{name: tire.values[name] * f for name, f in zip(free, draw, strict=True)} for draw in draws.tolist()]
    return (tire, *(replace(tire, values={**tire.values, **values}) for values in changed))


def free_coefficients(tire: Tire) -> tuple[str, ...]:
    """Return the coefficients that a fit of the forces and the aligning moment frees."""
    model = tire.symbolic_model
    by_output = coefficients_by_output(model, plain=True)
    influential = frozenset[str]().union(*(by_output[name] for name in CHANNELS if name in by_output))
    live = model.live(tire.has) & influential
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
        """The p coefficients that the test has to determine."""
        return free_coefficients(self.tires[0])

    @property
    def channels(self) -> tuple[str, ...]:
        """The measured channels."""
        return tuple(name for name in CHANNELS if name in self.tires[0].outputs)

    @cached_property
    def sources(self) -> tuple[ChannelNoise, ...]:
        """The noise of the k channels that have one: outputs, then inputs."""
        return tuple(self.noise.channels.get(n, ChannelNoise()) for n in (*self.channels, *self.tires[0].inputs))

    def deviations(self, kind: str) -> FloatArray:
        """Return the "offset" or the "drift" of each source, shape (k,)."""
        return np.array([getattr(source, kind) for source in self.sources])

    @cached_property
    def sizes(self) -> FloatArray:
        """The typical size of each free coefficient, shape (p,)."""
        declared, values = self.tires[0].symbolic_model.coefficients, self.tires[0].values
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

    def correlation_factor(self, t: FloatArray) -> float:
        """Return how often noise of rows counts that is correlated in time."""
        tau, step = self.noise.correlation_time, float(np.median(np.diff(t))) if len(t) > 1 else np.inf
        return 1.0 if tau == 0.0 or not np.isfinite(step) else float(1.0 / np.tanh(step / (2.0 * tau)))

    def inputs_of(self, table: pd.DataFrame) -> FloatArray:
        """Return the rows of a table in the order of the model, shape (u, n)."""
        tire = self.tires[0]
        return np.array([table.get(name, pd.Series(tire.nominal(name), table.index)) for name in tire.inputs], float)


def thinned(rows: int, points: int) -> npt.NDArray[np.intp]:
    """Return the indices of at most `points` rows, at equal distances.

    >>> thinned(100, 3).tolist()
    [0, 50, 99]
    """
    return np.unique(np.linspace(0, rows - 1, points).round().astype(np.intp))


@dataclass(frozen=True, eq=False)
class Information:
    """The parts of the covariance of a fit by maneuver m and tire t.

    - `products`, shape (m, t, q, q): weighted products of the p + e + k columns: derivatives by the coefficients,
      responses of effects, effects of unit errors of the sources of noise.
    - `noise`, shape (m, t, p, p): B without offsets and drift.
    """

    products: FloatArray
    noise: FloatArray

    def with_drift(self, experiment: Experiment) -> FloatArray:
        """Return the noise with a drift that has an independent value in each maneuver, shape (m, t, p, p)."""
        p = len(experiment.free)
        return self.noise + _common(self.products[:, :, p:, :p], experiment.deviations("drift"))

    def take(self, chosen: Sequence[int]) -> Information:
        """Return some of the maneuvers."""
        return Information(self.products[list(chosen)], self.noise[list(chosen)])


def information(
    experiment: Experiment, tables: Sequence[pd.DataFrame], responses: Sequence[FloatArray] = (), points: int = POINTS
) -> Information:
    """Return what a fit learns from the rows of each table.

    `responses`: of each tire, e further columns at the rows of `thinned`, shape (n, c, e). `points`: rows of a table
    that are evaluated. The weights of the channels are those of a fit: one over the mean variance of their residuals.
    """
    products, noise, weights = [], [], None
    ends = np.cumsum([len(thinned(len(table), points)) for table in tables])[:-1]
    factors = [experiment.correlation_factor(table["t"].to_numpy(float)) for table in tables]
    for number, (columns, deviations) in enumerate(_columns(experiment, tables, points)):
        p, k = len(experiment.free), len(experiment.sources)
        if weights is None:
            variances = np.einsum("nck,kn->nc", columns[:, :, p:] ** 2, deviations**2)
            weights = 1.0 / np.maximum(variances.mean(axis=0), 1e-12)
        scores = np.einsum("ncp,c,nck->nkp", columns[:, :, :p], weights, columns[:, :, p:]) * deviations.T[:, :, None]
        parts = [columns[:, :, :p], *responses[number : number + 1], columns[:, :, p:]]
        roots = np.split(np.sqrt(weights)[:, None] * np.concatenate(parts, axis=2), ends)
        counts = [len(table) / len(root) for table, root in zip(tables, roots, strict=True)]
        with one_blas_thread():
            products.append(
                [n * _square(root.reshape(-1, root.shape[2])) for n, root in zip(counts, roots, strict=True)]
            )
            rows = zip(counts, factors, np.split(scores, ends), strict=True)
            noise.append([n * f * _square(part.reshape(len(part) * k, p)) for n, f, part in rows])
    return Information(np.swapaxes(np.array(products), 0, 1), np.swapaxes(np.array(noise), 0, 1))


def _columns(
    experiment: Experiment, tables: Sequence[pd.DataFrame], points: int
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield for each tire the columns J and U, shape (n, c, p + k), and deviations of the noise, shape (k, n)."""
    inputs = np.concatenate([experiment.inputs_of(t.iloc[thinned(len(t), points)]) for t in tables], axis=1)
    for tire in experiment.tires:
        forces, by_coefficients, by_inputs = experiment.derivatives(tire, inputs)
        outputs = np.broadcast_to(np.eye(len(forces)), (inputs.shape[1], len(forces), len(forces)))
        values = zip(experiment.sources, np.concatenate([forces, inputs]), strict=True)
        deviations = np.array([np.hypot(part.constant, part.proportional * np.abs(value)) for part, value in values])
        yield np.concatenate([by_coefficients, outputs, by_inputs], axis=2), deviations


def _square(rows: FloatArray) -> FloatArray:
    return np.asarray(rows.T @ rows)


def energies(experiment: Experiment, tables: Sequence[pd.DataFrame]) -> FloatArray:
    """Return the sliding energy of each table, J, for the most plausible tire."""
    joules = []
    for table in tables:
        forces = experiment.tires[0].evaluate(table, signs="adapted-sae")
        power = (np.abs(forces["Fx"] * table["kappa"]) + np.abs(forces["Fy"] * np.tan(table["alpha"]))) * table["V"]
        joules.append(float(power.mean() * np.ptp(table["t"])))
    return np.array(joules)


def covariances(experiment: Experiment, information: Information, times: FloatArray) -> FloatArray:
    """Return the covariance of the coefficients, in sizes, by tire, shape (t, p, p).

    `information`: the maneuvers of a program in their order. `times`, shape (m,): when each takes place, s: drift is a
    sine of the period of the bench with an unknown phase.
    """
    p, phase = len(experiment.free), 2.0 * pi * times / experiment.noise.drift_period
    noise = information.noise.sum(axis=0)
    for wave in (np.sin(phase), np.cos(phase)):
        scores = np.einsum("mtkp,m->tkp", information.products[:, :, p:, :p], wave)
        noise += _common(scores, experiment.deviations("drift"))
    return with_offsets(experiment, information.products.sum(axis=0), noise)


def with_offsets(experiment: Experiment, products: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariances for sums of the parts of some maneuvers, shape (t, p, p)."""
    p = len(experiment.free)
    return sandwich(products[:, :p, :p], noise + _common(products[:, p:, :p], experiment.deviations("offset")))


def _common(scores: FloatArray, deviations: FloatArray) -> FloatArray:
    """Return the part of B of errors that are common to rows, shape (..., p, p).

    `scores`, shape (..., k, p): sums of those of unit errors. `deviations`, shape (k,).
    """
    scaled = scores * deviations[:, None]
    return np.asarray(np.swapaxes(scaled, -1, -2) @ scaled)


def sandwich(curvature: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariances for H and B without their priors, shape (t, p, p); H is scaled first, for its accuracy."""
    matrix = curvature + np.eye(curvature.shape[-1])
    scale = 1.0 / np.sqrt(np.einsum("tpp->tp", matrix))
    both = scale[:, :, None] * scale[:, None, :]
    with one_blas_thread():
        inverse = np.linalg.inv(matrix * both) * both
        return np.asarray(inverse @ (noise + np.eye(noise.shape[-1])) @ inverse)
