"""Linear disturbances of a recording (offsets, slow drift, cross-talk, errors of the load).

Offsets, drift and cross-talk are fitted together with the tire. The error of the load follows the direction of slip:
the controller of a bench lags behind the change of the loaded radius in a sweep, and load cells have hysteresis. The
recorded load is then too large while the slip grows and too small while it falls, or the reverse. All forces change in
proportion, as if friction and slip stiffness had a memory.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import hypot, sqrt
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
from ...numerics.smoothing import rate_of
from ...tires.states.transient import followed
from ..thresholds import FREE_PRIOR
from .signals import Signals
from .simulation import Simulator

#: Prior standard deviation of drift, in noise standard deviations. Convention: a drift beyond the noise is seen in the
#: bench and repaired.
DRIFT_PRIOR = 1.0

#: Deviation of a known value, as a share of that of an unknown one. Convention.
KNOWN = 1e-6
#: How the names of offsets begin, before Fx, those of cross-talk, before Fx_in_Fy, and of all disturbances of a
#: recording.
OFFSET, CROSS_TALK = "offset_", "cross_talk_"
OF_RECORDING = (OFFSET, "drift", CROSS_TALK, "wave")


@dataclass(frozen=True, eq=False)
class Disturbances:
    """Linear disturbances of the channels.

    - `names`: offset_Fy, drift1_Fy, ..., cross_talk_Fx_in_Fy.
    - `columns`, shape (n_channels, n, n_disturbances): change of the forces per unit of each, N and N m.
    - `deviation`, `center`, shape (n_disturbances,): standard deviation and mean of the prior of each.
    - `lines`: periodic disturbances; the columns of the first one are wave1_cosine_Fx, wave1_sine_Fx, ...
    """

    names: tuple[str, ...]
    columns: FloatArray
    deviation: FloatArray
    center: FloatArray
    lines: tuple[PeriodicLine, ...] = ()

    def known(self, values: Mapping[str, float]) -> Disturbances:
        """Return the disturbances with known values of some of them."""
        center, deviation = self.center.copy(), self.deviation.copy()
        for i, name in enumerate(self.names):
            if name in values:
                center[i], deviation[i] = values[name], KNOWN * deviation[i]
        return replace(self, center=center, deviation=deviation)

    def implausible(self, values: FloatArray) -> tuple[str, ...]:
        """Return the names of the cross-talk that is larger than that of a bench."""
        return tuple(
            name
            for name, value in zip(self.names, values, strict=True)
            if name.startswith(CROSS_TALK) and abs(value) > MAX_CROSS_TALK[name.removeprefix(CROSS_TALK)]
        )

    def of_recording(self) -> Disturbances:
        """Return the disturbances without the columns that `extended` added."""
        return self.without([name for name in self.names if not name.startswith(OF_RECORDING)])

    def without(self, names: Collection[str]) -> Disturbances:
        """Return the disturbances without some of them."""
        remain = np.array([name not in names for name in self.names])
        return Disturbances(
            tuple(name for name in self.names if name not in names), self.columns[:, :, remain], self.deviation[remain],
            self.center[remain], self.lines,
        )  # fmt: skip

    def with_lines(
        self, lines: Sequence[PeriodicLine], axes: Mapping[str, FloatArray], noise: FloatArray, channels: Sequence[str]
    ) -> Disturbances:
        """Return the disturbances with periodic disturbances of all channels.

        `axes`, shape (n,): time and distance at the compared rows. `noise`, shape (n_channels,).
        """
        names, columns, index = _columns(_waves(lines, axes, channels), self.columns.shape[:2])
        return replace(self.extended(names, columns, FREE_PRIOR * noise[index]), lines=tuple(lines))

    def extended(self, names: tuple[str, ...], columns: FloatArray, deviation: FloatArray) -> Disturbances:
        """Return the disturbances with additional columns, for structure that no coefficient of the model explains."""
        return Disturbances(
            (*self.names, *names),
            np.concatenate([self.columns, columns], axis=-1),
            np.concatenate([self.deviation, deviation]),
            np.concatenate([self.center, np.zeros(len(deviation))]),
            self.lines,
        )


#: Names of disturbances with the index of the channel that each changes, and its change per unit, shape (n,).
Changes = Iterator[tuple[str, int, FloatArray]]


def _slow(share: FloatArray, number: int, channels: Sequence[str]) -> Changes:
    """Yield offset and drift of each channel at shares of the recording that have passed, with a number of waves."""
    for i, channel in enumerate(channels):
        for k, wave in enumerate(half_waves(share, number)):
            yield f"drift{k}_{channel}" if k else f"{OFFSET}{channel}", i, wave


def _cross_talk(channels: Sequence[str], measured: FloatArray, radius: float) -> Changes:
    for pair, target, change in cross_talk(channels, measured, radius):
        yield f"{CROSS_TALK}{pair}", target, change


def _waves(lines: Iterable[PeriodicLine], axes: Mapping[str, FloatArray], channels: Sequence[str]) -> Changes:
    for number, line in enumerate(lines, start=1):
        for i, channel in enumerate(channels):
            for part, wave in zip(("cosine", "sine"), line.waves(axes[line.over]), strict=True):
                yield f"wave{number}_{part}_{channel}", i, wave


def _columns(changes: Changes, shape: tuple[int, ...]) -> tuple[tuple[str, ...], FloatArray, list[int]]:
    """Return names, columns of shape (n_channels, n, n_names), and the index of the channel of each."""
    names, channels, values = zip(*changes, strict=True)
    columns = np.zeros((*shape, len(names)))
    columns[channels, :, range(len(names))] = values
    return names, columns, list(channels)


def disturbances_of(signals: Signals, noise: FloatArray, radius: float) -> Disturbances:
    """Return the disturbances that a recording may have.

    `noise`, shape (n_channels,): standard deviation of each channel's noise. `radius`, m: unloaded radius, the length
    to which cross-talk of a force into a moment refers.
    """
    slow = _slow(passed(signals, signals.t[signals.rows]), DRIFT_WAVES if signals.timed else 0, signals.channels)
    changes = chain(slow, _cross_talk(signals.channels, signals.measured, radius))
    names, columns, channels = _columns(changes, signals.measured.shape)
    deviation = [
        CROSS_TALK_PRIOR_SHARE * MAX_CROSS_TALK[name.removeprefix(CROSS_TALK)]
        if name.startswith(CROSS_TALK)
        else noise[i] * (FREE_PRIOR if name.startswith(OFFSET) else DRIFT_PRIOR)
        for name, i in zip(names, channels, strict=True)
    ]
    return Disturbances(names, columns, np.array(deviation), np.zeros(len(names)))


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
    removed: dict[str, dict[str, Any]] = {
        channel: {
            "offset": named.get(f"{OFFSET}{channel}", 0.0),
            "drift": [v for name, v in named.items() if name.startswith("drift") and name.endswith(f"_{channel}")],
        }
        for channel in signals.channels
    }
    t = signals.t[signals.rows]
    return {
        "periodic": _reported_waves(disturbances, named, signals.channels),
        "skew": signals.skew,
        "removed": removed,
        "removed_over": [float(t[0]), float(t[-1])],
        "offset": {channel: slow["offset"] for channel, slow in removed.items()},
        "drift": {channel: hypot(*slow["drift"]) / sqrt(2.0) for channel, slow in removed.items()},
        "cross_talk": {name.removeprefix(CROSS_TALK): v for name, v in named.items() if name.startswith(CROSS_TALK)},
        "input_noise": dict(signals.origin.noise),
    }


def removed_at(
    disturbances: Disturbances, values: FloatArray, signals: Signals, t: FloatArray, measured: FloatArray, radius: float
) -> FloatArray:
    """Return what the disturbances contribute to the forces in every row of a recording, shape (n_channels, n_rows).

    `values`, shape (n_disturbances,). `t`, shape (n_rows,), s; without a recorded time, the number of the row.
    `measured`, shape (n_channels, n_rows): forces, in the signs of the formula. `radius`, m: unloaded radius.
    """
    named = dict(zip(disturbances.names, values.tolist(), strict=True))
    axes, removed = {"t": t}, np.zeros_like(measured)
    if any(line.over == "distance" for line in disturbances.lines):
        distance = signals.delayed(-signals.skew).named()["distance"]
        axes["distance"] = np.interp(np.arange(len(t)), signals.table_rows, distance)
    changes = chain(
        _slow(passed(signals, t), DRIFT_WAVES, signals.channels),
        _cross_talk(signals.channels, np.nan_to_num(measured), radius),
        _waves(disturbances.lines, axes, signals.channels),
    )
    for name, i, change in changes:
        removed[i] += named.get(name, 0.0) * change
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
    rate = rate_of(np.hypot(np.tan(named["alpha"]), named["kappa"]), signals.t)
    direction = np.tanh(rate / (TURNING * float(np.sqrt(np.mean(rate**2))) + 1e-12))
    rates = [np.full(len(direction), 1.0 / seconds if seconds else np.inf) for seconds in LAGS]
    errors = [followed(signals.t, direction, of_lag, direction, hold=False).value[signals.rows] for of_lag in rates]
    return simulator.growth("Fz", parameters)[:, :, None] * np.stack(errors, axis=-1)
