"""Linear disturbances of a recording (offsets, slow drift, cross-talk, errors of the load).

Offsets, drift and cross-talk are fitted together with the tire. The error of the load follows the direction of slip:
the controller of a bench lags behind the change of the loaded radius in a sweep, and load cells have hysteresis. The
recorded load is then too large while the slip grows and too small while it falls, or the reverse. All forces change in
proportion, as if friction and slip stiffness had a memory.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...measurements.virtual_bench.bench_errors import (
    CROSS_TALK_PRIOR_SHARE,
    DRIFT_WAVES,
    MAX_CROSS_TALK,
    cross_talk,
    half_waves,
)
from ...numerics.arrays import FloatArray
from ...numerics.periodic_lines import PeriodicLine
from ...tires.states.transient import followed
from ..thresholds import FREE_PRIOR
from .signals import Signals
from .simulation import Simulator

#: Prior standard deviation of drift, in noise standard deviations. Convention: a drift beyond the noise is seen in the
#: bench and repaired.
DRIFT_PRIOR = 1.0

#: How the names of cross-talk begin, before Fx_in_Fy.
CROSS_TALK = "cross_talk_"


@dataclass(frozen=True, eq=False)
class Disturbances:
    """Linear disturbances of the channels.

    - `names`: offset_Fy, drift1_Fy, ..., cross_talk_Fx_in_Fy.
    - `columns`, shape (n_channels, n, n_disturbances): change of the forces per unit of each, N and N m.
    - `deviation`, shape (n_disturbances,): standard deviation of the zero-mean prior of each.
    - `added`: names of columns that are no disturbances of a recording: errors of the functional form of a model.
    - `lines`: periodic disturbances; the columns of the first one are wave1_cosine_Fx, wave1_sine_Fx, ...
    """

    names: tuple[str, ...]
    columns: FloatArray
    deviation: FloatArray
    added: frozenset[str] = frozenset()
    lines: tuple[PeriodicLine, ...] = ()

    def subsampled(self, rows: slice) -> Disturbances:
        """Return the disturbances at a subset of the rows."""
        return replace(self, columns=self.columns[:, rows])

    def implausible(self, values: FloatArray) -> tuple[str, ...]:
        """Return the names of the cross-talk that is larger than that of a bench."""
        return tuple(
            name
            for name, value in zip(self.names, values, strict=True)
            if name.startswith(CROSS_TALK) and abs(value) > MAX_CROSS_TALK[name.removeprefix(CROSS_TALK)]
        )

    def of_recording(self) -> Disturbances:
        """Return the disturbances without the columns that `extended` added."""
        return self.without(self.added)

    def without(self, names: Collection[str]) -> Disturbances:
        """Return the disturbances without some of them."""
        remain = np.array([name not in names for name in self.names])
        return Disturbances(
            tuple(name for name in self.names if name not in names), self.columns[:, :, remain], self.deviation[remain],
            self.added.difference(names), self.lines,
        )  # fmt: skip

    def with_waves(
        self, line: PeriodicLine, at: FloatArray, noise: FloatArray, channels: Sequence[str]
    ) -> Disturbances:
        """Return the disturbances with a periodic disturbance of all channels.

        `at`, shape (n,): time or distance at the compared rows. `noise`, shape (n_channels,).
        """
        names, columns, deviation = [], [], []
        number = 1 + len(self.lines)
        for i, channel in enumerate(channels):
            for part, wave in zip(("cosine", "sine"), line.waves(at), strict=True):
                column = np.zeros(self.columns.shape[:2])
                column[i] = wave
                names.append(f"wave{number}_{part}_{channel}")
                columns.append(column)
                deviation.append(FREE_PRIOR * noise[i])
        extended = self.with_columns(tuple(names), np.stack(columns, axis=-1), np.array(deviation))
        return replace(extended, lines=(*self.lines, line))

    def with_columns(self, names: tuple[str, ...], columns: FloatArray, deviation: FloatArray) -> Disturbances:
        """Return the disturbances with further disturbances of the recording."""
        return replace(self.extended(names, columns, deviation), added=self.added)

    def extended(self, names: tuple[str, ...], columns: FloatArray, deviation: FloatArray) -> Disturbances:
        """Return the disturbances with additional columns, for structure that no coefficient of the model explains."""
        return Disturbances(
            (*self.names, *names),
            np.concatenate([self.columns, columns], axis=-1),
            np.concatenate([self.deviation, deviation]),
            self.added | set(names),
            self.lines,
        )


def disturbances_of(signals: Signals, noise: FloatArray, radius: float) -> Disturbances:
    """Return the disturbances that a recording may have.

    `noise`, shape (n_channels,): standard deviation of each channel's noise. `radius`, m: unloaded radius, the length
    to which cross-talk of a force into a moment refers.
    """
    n_channels, n = signals.measured.shape
    waves = half_waves(passed(signals, signals.t[signals.rows]), DRIFT_WAVES if signals.timed else 0)
    names, columns, deviation = [], [], []
    for i, channel in enumerate(signals.channels):
        for k, wave in enumerate(waves):
            column = np.zeros((n_channels, n))
            column[i] = wave
            names.append(f"{_slow_name(k)}_{channel}")
            columns.append(column)
            deviation.append(noise[i] * (FREE_PRIOR if k == 0 else DRIFT_PRIOR))
    for pair, target, change in cross_talk(signals.channels, signals.measured, radius):
        column = np.zeros((n_channels, n))
        column[target] = change
        names.append(f"{CROSS_TALK}{pair}")
        columns.append(column)
        deviation.append(CROSS_TALK_PRIOR_SHARE * MAX_CROSS_TALK[pair])
    return Disturbances(tuple(names), np.stack(columns, axis=-1), np.array(deviation))


def _slow_name(k: int) -> str:
    return "offset" if k == 0 else f"drift{k}"


def passed(signals: Signals, t: FloatArray) -> FloatArray:
    """Return the share of the recording that has passed at any times t, shape (n,), in s."""
    first, last = (float(signals.t[signals.rows[i]]) for i in (0, -1))
    return np.asarray((t - first) / max(last - first, 1e-9))


def reported_disturbances(disturbances: Disturbances, values: FloatArray, signals: Signals) -> dict[str, Any]:
    """Return the estimated disturbances of a recording.

    `values`, shape (n_disturbances,). Returns: offset, drift (root mean square) by channel; cross_talk; input_noise;
    periodic (waves over time or distance: frequency in 1/s or 1/m, amplitude, cosine and sine part by channel); skew
    (delay of the forces behind the inputs, s); removed (by channel: offset, drift as the amplitudes of cosine half
    waves over the recording) and removed_over (start and end of these waves, s).
    """
    named = dict(zip(disturbances.names, values.tolist(), strict=True))
    drift = {
        channel: float(
            np.sqrt(sum(v**2 for name, v in named.items() if name.startswith("drift") and name.endswith(channel)) / 2.0)
        )
        for channel in signals.channels
    }
    t = signals.t[signals.rows]
    return {
        "periodic": _reported_waves(disturbances, named, signals.channels),
        "skew": signals.skew,
        "removed": removed_from(disturbances, values, signals),
        "removed_over": [float(t[0]), float(t[-1])],
        "offset": {channel: named[f"offset_{channel}"] for channel in signals.channels},
        "drift": drift,
        "cross_talk": {name.removeprefix(CROSS_TALK): v for name, v in named.items() if name.startswith(CROSS_TALK)},
        "input_noise": dict(signals.origin.noise),
    }


def removed_from(disturbances: Disturbances, values: FloatArray, signals: Signals) -> dict[str, dict[str, Any]]:
    """Return what is subtracted from the residuals of each channel: offset, and drift as amplitudes of half waves.

    `values`, shape (n_disturbances,).
    """
    named = dict(zip(disturbances.names, values.tolist(), strict=True))
    return {
        channel: {
            "offset": named[f"offset_{channel}"],
            "drift": [v for name, v in named.items() if name.startswith("drift") and name.endswith(f"_{channel}")],
        }
        for channel in signals.channels
    }


def removed_at(
    disturbances: Disturbances, values: FloatArray, signals: Signals, t: FloatArray, measured: FloatArray, radius: float
) -> FloatArray:
    """Return what the disturbances contribute to the forces in every row of a recording, shape (n_channels, n_rows).

    `values`, shape (n_disturbances,). `t`, shape (n_rows,), s; without a recorded time, the number of the row.
    `measured`, shape (n_channels, n_rows): forces, in the signs of the formula. `radius`, m: unloaded radius.
    """
    named = dict(zip(disturbances.names, values.tolist(), strict=True))
    removed = np.zeros_like(measured)
    for k, wave in enumerate(half_waves(passed(signals, t))):
        for i, channel in enumerate(signals.channels):
            removed[i] += named.get(f"{_slow_name(k)}_{channel}", 0.0) * wave
    for pair, target, change in cross_talk(signals.channels, np.nan_to_num(measured), radius):
        removed[target] += named.get(f"{CROSS_TALK}{pair}", 0.0) * change
    axes = {"t": t}
    if any(line.over == "distance" for line in disturbances.lines):
        distance = signals.delayed(-signals.skew).named()["distance"]
        axes["distance"] = np.interp(np.arange(len(t)), signals.table_rows, distance)
    for number, line in enumerate(disturbances.lines, start=1):
        for part, wave in zip(("cosine", "sine"), line.waves(axes[line.over]), strict=True):
            for i, channel in enumerate(signals.channels):
                removed[i] += named[f"wave{number}_{part}_{channel}"] * wave
    return removed


def _reported_waves(
    disturbances: Disturbances, named: Mapping[str, float], channels: Sequence[str]
) -> list[dict[str, Any]]:
    """Return the periodic disturbances with their amplitudes."""
    waves = []
    for k, line in enumerate(disturbances.lines, start=1):
        parts = {
            part: {channel: named[f"wave{k}_{part}_{channel}"] for channel in channels} for part in ("cosine", "sine")
        }
        amplitude = {channel: float(np.hypot(parts["cosine"][channel], parts["sine"][channel])) for channel in channels}
        waves.append({"over": line.over, "frequency": line.frequency, "amplitude": amplitude, **parts})
    return waves


#: Time constants of the error behind the direction of slip, s: a load cell, and a controller.
LAGS = (0.0, 0.5)
#: Rate of change of slip, as a share of its root mean square, at which the error has three quarters of its size.
TURNING = 0.3


def load_error_responses(simulator: Simulator, parameters: FloatArray) -> FloatArray:
    """Return the change of the forces per relative error of the load, shape (n_channels, n, len(LAGS)).

    `simulator`: of a recording with time. `parameters`, shape (n_parameters,).
    """
    signals = simulator.signals
    named = dict(zip(signals.names, signals.inputs, strict=True))
    slip = np.hypot(np.tan(named["alpha"]), named["kappa"])
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.nan_to_num(np.gradient(slip, signals.t), posinf=0.0, neginf=0.0)
    direction = np.tanh(rate / (TURNING * float(np.sqrt(np.mean(rate**2))) + 1e-12))
    load, at = signals.names.index("Fz"), simulator.forces(parameters)
    responses = []
    for seconds in LAGS:
        rates = np.full(len(direction), 1.0 / seconds if seconds else np.inf)
        error = followed(signals.t, direction, rates, direction, hold=False).value
        inputs, step = signals.inputs.copy(), 0.01
        inputs[load] *= 1.0 + step * error
        responses.append((simulator.with_signals(replace(signals, inputs=inputs)).forces(parameters) - at) / step)
    return np.stack(responses, axis=-1)
