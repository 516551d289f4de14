"""Sensor noise of a virtual bench: random noise, offset, drift and quantization of each channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi, radians

import numpy as np

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from ...symbolic.channels import CHANNELS, channel


@dataclass(frozen=True)
class ChannelNoise:
    """The noise of one channel, in its SI unit.

    Parameters
    ----------
    constant : float
        Standard deviation of the part that does not depend on the value.
    proportional : float
        Standard deviation of the part that is proportional to the value, as a fraction of it.
    offset : float
        Standard deviation over recordings of a constant error.
    drift : float
        Root mean square over recordings of a slow sinusoidal error.
    step : float
        Quantization: the channel is rounded to multiples of the step. 0: not rounded.
    """

    constant: float = 0.0
    proportional: float = 0.0
    offset: float = 0.0
    drift: float = 0.0
    step: float = 0.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value >= 0.0:
                raise DataError(f"noise: {name} is {value}: it has to be 0 or more")


# From the scatter of an FSAE TTC recording (Calspan, 16x7.5-10 at 0.5 to 2.8 kN, 100 Hz) about a moving cubic of
# 0.5 s: Fy 1.3 % of its peak, Fx 10 N at rest and 1.4 % of its peak, Mz 3.7 N m,
# Fz 36 N, alpha 0.005 to 0.02 deg, gamma 0.005 to 0.008 deg, slip 0.0015, p 0.3 to 0.4 kPa, T 0.13 deg C,
# V 0.006 m/s, correlated over a few samples. Much of the scatter of the forces is ripple of the tire.
_TTC = {
    "kappa": ChannelNoise(constant=0.0015, offset=0.0005, step=0.001),
    "alpha": ChannelNoise(constant=radians(0.015), offset=radians(0.03), step=radians(0.001)),
    "gamma": ChannelNoise(constant=radians(0.008), offset=radians(0.02), step=radians(0.001)),
    "Fz": ChannelNoise(constant=8.0, proportional=0.01, offset=3.0, drift=3.0, step=0.05),
    "p": ChannelNoise(constant=400.0, offset=200.0, drift=200.0, step=50.0),
    "V": ChannelNoise(constant=0.006, offset=0.01, step=0.003),
    "T": ChannelNoise(constant=0.13, offset=0.5, step=0.01),
    "Fx": ChannelNoise(constant=8.0, proportional=0.01, offset=5.0, drift=5.0, step=0.02),
    "Fy": ChannelNoise(constant=8.0, proportional=0.01, offset=5.0, drift=5.0, step=0.02),
    "Mz": ChannelNoise(constant=1.0, proportional=0.02, offset=0.3, drift=0.3, step=0.02),
    "Mx": ChannelNoise(constant=1.0, proportional=0.02, offset=0.5, drift=0.5, step=0.02),
    "My": ChannelNoise(constant=1.0, proportional=0.02, offset=0.3, drift=0.3, step=0.02),
}


@dataclass(frozen=True)
class Noise:
    """The noise of a bench, of its inputs and its outputs.

    Parameters
    ----------
    channels : mapping of str to ChannelNoise
        By contract name. Other channels are recorded exactly. Default: similar to an FSAE TTC bench with loads of 0.2
        to 3 kN. `scaled` adapts it to other loads.
    correlation_time : float
        s, of the random part: first-order autoregressive, correlation exp(-dt/correlation_time).
    drift_period : float
        s, period of the drift.

    Raises
    ------
    UnknownName
        If a channel is not in the contract.

    Examples
    --------
    >>> Noise().channels["Fy"].proportional
    0.01
    >>> Noise.none().channels
    {}
    """

    channels: Mapping[str, ChannelNoise] = field(default_factory=lambda: dict(_TTC))
    correlation_time: float = 0.02
    drift_period: float = 900.0

    def __post_init__(self) -> None:
        for name in self.channels:
            channel(name)
        if not (self.correlation_time >= 0.0 and self.drift_period > 0.0):
            raise DataError("noise: correlation_time has to be 0 or more, drift_period positive")

    @classmethod
    def none(cls) -> Noise:
        """Return the noise of a bench that records exactly.

        Returns
        -------
        Noise
            All deviations are 0.
        """
        return cls(channels={})

    def scaled(self, factor: float) -> Noise:
        """Return the noise of a bench for other loads: that of forces and moments scaled, that of slips unchanged.

        Parameters
        ----------
        factor : float
            The largest load divided by that of the FSAE TTC bench (3 kN); 0.05 for a tire at 160 N.

        Returns
        -------
        Noise
            Deviations of forces and moments times the factor; those of slips as before.

        Examples
        --------
        >>> Noise().scaled(0.05).channels["Fy"].constant
        0.4
        """
        channels = dict(self.channels)
        for name, part in self.channels.items():
            if CHANNELS[name].quantity in ("force", "moment"):
                sizes = {size: factor * getattr(part, size) for size in ("constant", "offset", "drift", "step")}
                channels[name] = replace(part, **sizes)
        return replace(self, channels=channels)

    def record(self, name: str, exact: FloatArray, t: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return the values that the sensor of a channel records.

        Parameters
        ----------
        name : str
            The channel.
        exact : ndarray, shape (n,)
            Values without noise.
        t : ndarray, shape (n,), s
            Time of each row.
        rng : numpy.random.Generator
            Source of the random numbers.

        Returns
        -------
        ndarray, shape (n,)
            The values with noise, in the unit of the channel.

        Examples
        --------
        >>> times = np.arange(5) / 100.0
        >>> noise = Noise({"Fy": ChannelNoise(step=50.0)})
        >>> exact = np.array([0.0, 20.0, 30.0, 70.0, 80.0])
        >>> noise.record("Fy", exact, times, np.random.default_rng(0)).tolist()
        [0.0, 0.0, 50.0, 50.0, 100.0]
        """
        if name not in self.channels:
            return exact
        part = self.channels[name]
        deviation = np.hypot(part.constant, part.proportional * np.abs(exact))
        drift = np.sqrt(2.0) * np.sin(2.0 * pi * t / self.drift_period + rng.uniform(0.0, 2.0 * pi))
        random = deviation * correlated(t, self.correlation_time, rng)
        recorded = exact + random + part.offset * rng.standard_normal() + part.drift * drift
        return np.asarray(np.round(recorded / part.step) * part.step if part.step else recorded)


def correlated(t: FloatArray, correlation_time: float, rng: np.random.Generator) -> FloatArray:
    """Return first-order autoregressive noise of standard deviation 1 at the given times, shape (n,).

    `t`, shape (n,): ascending, with any steps. `correlation_time`: s; 0 gives white noise. The noise is stationary from
    the first row. Its correlation is exp(-|t_i - t_j|/correlation_time), so it decays over a pause.
    """
    white = rng.standard_normal(len(t))
    if correlation_time == 0.0:
        return white
    correlation = np.exp(-np.diff(t, prepend=-np.inf) / correlation_time)  # 0 for the first row
    innovation = np.sqrt(1.0 - correlation**2)
    noise, last = [], 0.0
    for rho, scale, draw in zip(correlation.tolist(), innovation.tolist(), white.tolist(), strict=True):
        last = rho * last + scale * draw
        noise.append(last)
    return np.array(noise)
