"""What measured data show of a tire, and what they never show: one rule for fits and drives.

A force saturates: the more of its peak it has reached, the flatter it is. The share of the peak therefore follows from
the slope at the end of the data, relative to that at zero slip, without the peak, which may be beyond the data. Shapes
differ: at half of its peak the slope of a tire is 65 to 95 % of that at zero, at 90 % it is 10 to 35 %. The rule is
that of a Magic Formula in between.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import nan

import numpy as np

from ....numerics.arrays import FloatArray

#: Share of the peak of a force from which data determine the peak. Judgement: there the slope has fallen to a fifth,
#: and the peak is within some percent of the largest force, whatever the shape of the curve.
PEAK_SHARE = 0.9
#: Share of the peak of a force below which data determine the slope at zero slip: there it is 90 % of that at zero.
SMALL_SHARE = 0.3
#: Shape and curvature factor of the typical force.
SHAPE, CURVATURE = 1.4, -0.5


@dataclass(frozen=True)
class ChannelCoverage:
    """Whether data determine a characteristic of a channel.

    - `characteristic`: "peak friction", "slip stiffness", "other side" (of zero slip), "combined slip", or "influence
      of load", "influence of camber", "influence of pressure"; empty for a channel as a whole.
    - `share`: of the peak friction, the largest share of the peak that the data reach; of the slip stiffness, the
      smallest one.
    - `reason`: what the data lack; empty if they lack nothing. A determined peak may lack loads.
    """

    characteristic: str
    channel: str
    determined: bool
    reason: str = ""
    share: float = nan


def _typical_shape() -> tuple[FloatArray, FloatArray]:
    """Return slopes from the peak to zero slip, relative to the one there, and the shares of the peak at them."""
    u = np.linspace(0.0, 10.0, 2001)
    force = np.sin(SHAPE * np.arctan(u - CURVATURE * (u - np.arctan(u))))
    end = int(force.argmax()) + 1
    slope = np.gradient(force, u)[:end]
    return (slope / slope[0])[::-1], (force[:end] / force[end - 1])[::-1]


_SLOPES, _SHARES = _typical_shape()


def flatness(slip: FloatArray, force: FloatArray) -> float:
    """Return the smallest slope of a force over a slip from zero, relative to the largest one; 0 beyond a peak.

    `slip`, `force`, shape (n,): increasing magnitudes.
    """
    slope = np.gradient(force, slip)
    steepest = float(slope.max())
    return max(float(slope.min()) / steepest, 0.0) if steepest > 0.0 else 1.0


def share_of_peak(flat: float) -> float:
    """Return about the share of its peak that a force reaches whose slope has fallen to a share of that at zero slip.

    >>> [round(share_of_peak(flat), 1) for flat in (1.0, 0.8, 0.25, 0.0)]
    [0.0, 0.5, 0.9, 1.0]
    """
    return float(np.interp(flat, _SLOPES, _SHARES))


def lacking_peak(channel: str, share: float, flat: float | None = None) -> str:
    """Return what data lack that reach a share of the peak of a force; empty if they determine it.

    `flat`: the slope at their end, relative to that at zero slip, from which the share was estimated.
    """
    if share >= PEAK_SHARE:
        return ""
    if flat is None:
        return f"{channel} reaches {share:.0%} of its peak"
    return f"the slope of {channel} at the end of the data is {flat:.0%} of that at zero slip"


def coverage_texts(coverage: Iterable[ChannelCoverage]) -> list[str]:
    """Return a sentence for each reason, with the channels that have it in common.

    >>> coverage_texts([ChannelCoverage("influence of load", name, False, "one load") for name in ("Fx", "Fy")])
    ['the influence of load on Fx, Fy is not determined: one load']
    """
    by_reason: dict[tuple[str, bool, str], list[str]] = {}
    for entry in coverage:
        if entry.reason:
            by_reason.setdefault((entry.characteristic, entry.determined, entry.reason), []).append(entry.channel)
    return [
        f"{_subject(characteristic, channels)} {'extrapolated' if determined else 'not determined'}: {reason}"
        for (characteristic, determined, reason), channels in by_reason.items()
    ]


def _subject(characteristic: str, channels: list[str]) -> str:
    names = ", ".join(channels)
    if not characteristic:
        return f"{names} {'is' if len(channels) == 1 else 'are'}"
    return f"the {characteristic} {'on' if characteristic.startswith('influence') else 'of'} {names} is"
