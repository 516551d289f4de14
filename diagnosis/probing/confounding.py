"""Explanations that are confounded with an identified effect: other effects and sensor errors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.detection import Detection
from ..signals.skew import time_derivatives
from ..thresholds import SIDE
from .effect_probing import Screen

#: Share of an effect's norm from which the response of a single coefficient is compared as well. Convention: less
#: than a sixth of the power is not what makes two effects alike.
MIN_SHARE = 0.4

#: Sensor errors that are confounded with effects: the input and its error, rad, rad and 1.
ALIASES = {
    "slip_angle_zero_offset": ("alpha", 1e-3),
    "inclination_zero_offset": ("gamma", 2e-3),
    "slip_zero_offset": ("kappa", 1e-3),
}
#: Differences of friction between the signs of a slip, which no effect of the models describes: role and slip.
FRICTION_ALIASES: Mapping[str, tuple[str, str]] = {
    "drive_brake_friction": ("friction_x", "kappa"),
    "left_right_friction": ("friction_y", "alpha"),
}
#: All explanations that are no effects; the last one is reported where the temperature was not recorded.
SKEW_OF_FORCES, UNRECORDED_TEMPERATURE = "skew_of_forces", "unrecorded_temperature"
EXPLANATIONS = (*ALIASES, *FRICTION_ALIASES, SKEW_OF_FORCES, UNRECORDED_TEMPERATURE)


def alias_columns(screen: Screen) -> dict[str, FloatArray]:
    """Return the weighted responses of the forces to errors of sensors and other explanations without an effect.

    Each has the shape (n_channels, n, 1).
    """
    simulator, parameters = screen.problem.simulator, screen.solution.parameters
    at, signals, named = simulator.forces(parameters), simulator.signals, simulator.signals.named()
    changes = {}
    for name, (slip, error) in ALIASES.items():
        if slip in named:
            shifted = signals.inputs + error * (np.array(signals.names) == slip)[:, None]
            changes[name] = simulator.with_signals(replace(signals, inputs=shifted)).forces(parameters) - at
    for name, (role, slip) in FRICTION_ALIASES.items():
        leading = simulator.symbolic_model.leading(role)
        if slip in named and leading in simulator.index:
            response = simulator.jacobian(parameters, [leading])[:, :, 0] * parameters[simulator.index[leading]]
            changes[name] = response * np.tanh(named[slip] / SIDE)
    if simulator.signals.timed:
        changes[SKEW_OF_FORCES] = -time_derivatives(simulator, parameters)[:, :, 0]
    return {name: (screen.problem.inverse_noise * change)[:, :, None] for name, change in changes.items()}


def correlations(
    screen: Screen, coefficients: Sequence[str], others: Iterable[tuple[str, FloatArray]]
) -> dict[str, float]:
    """Return the correlation of an identified effect's response with that of each other explanation.

    `screen`: of the solution with the identified effect. `coefficients`: coefficients of the identified effect.
    `others`: other explanations, each with weighted responses of shape (n_channels, n, k); one may occur several times,
    as only one of its time constants is right. Returns: 0 to 1: the largest correlation of the effect's response with
    the best linear combination of the responses. The responses to the remaining coefficients and to the disturbances of
    the recording are projected out of both.
    """
    solution, simulator = screen.solution, screen.problem.simulator
    declarations, names = simulator.symbolic_model.coefficients, [n for n in solution.free if n in coefficients]
    values = np.array([solution.parameters[simulator.index[name]] - declarations[name].default for name in names])
    of_effect = np.zeros(screen.tangent.shape[-1], dtype=bool)
    of_effect[[solution.free.index(name) for name in names]] = True
    rest = screen.tangent[:, :, ~of_effect].reshape(-1, int((~of_effect).sum()))
    normal = rest.T @ rest + np.diag(screen.prior_precision[~of_effect])

    def projected_out(columns: FloatArray) -> FloatArray:
        flat = columns.reshape(rest.shape[0], -1)
        return np.asarray(flat - rest @ np.linalg.solve(normal, rest.T @ flat))

    parts = projected_out(screen.tangent[:, :, of_effect] * values)
    projected = parts.sum(axis=1)
    sizes, size = np.linalg.norm(parts, axis=0), float(np.linalg.norm(projected))
    directions = [projected / max(size, 1e-300)]  # the total response, and large single ones
    directions += [
        part / own_size for part, own_size in zip(parts.T, sizes, strict=True) if own_size > MIN_SHARE * size > 0.0
    ]
    correlation: dict[str, float] = {}
    for name, columns in others:
        flat = columns.reshape(rest.shape[0], -1)
        other = projected_out(columns)
        norms = np.linalg.norm(flat, axis=0)
        other = other[:, np.linalg.norm(other, axis=0) > np.maximum(1e-3 * norms, 1e-9)]
        if not other.shape[1] or size == 0.0:
            continue
        basis, _ = np.linalg.qr(other / np.linalg.norm(other, axis=0))
        along = [float(np.linalg.norm(basis.T @ direction)) for direction in directions]
        correlation[name] = max(correlation.get(name, 0.0), *along)
    return correlation


def separating_measurement(first: str, second: str, detections: Mapping[str, Detection]) -> str:
    """Return the cheapest measurement that separates two explanations.

    `first`, `second`: effects or sensor errors. `detections`: declarations of the effect files: of the pair, otherwise
    of the first or the second effect alone.

    >>> from tirefmu.symbolic.models import model_named
    >>> separating_measurement("plysteer", "slip_angle_zero_offset", model_named("mf61").detections)
    'turn the tire on the rim and repeat one alpha sweep'
    """
    pairs = ((first, second), (second, first))
    declared = [(detections[effect], other) for effect, other in pairs if effect in detections]
    for detection, other in declared:
        for pair in detection.confounded:
            if pair.other == other:
                return pair.separate_by
    separate_by = [detection.separate_by for detection, _ in declared if detection.separate_by]
    return separate_by[0] if separate_by else "repeat a sweep in which only one of their inputs changes"
