"""Errors of one output of an FMU against measured values, added up over parts of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, nan, sqrt

import numpy as np
import pandas as pd

from ...measurements.ties import graded
from .result import CheckedChannel, WorstPoint


@dataclass(frozen=True)
class ChannelErrors:
    """Sums over the measured rows of a channel.

    - `squared`: sum of squared errors.
    - `mean`, `about_mean`, `about_zero`: of the measured values: their mean, and the sums of squares about it and about
      zero.
    - `largest`: largest measured magnitude.
    - `worst`: none without a measured value.
    """

    name: str
    count: int = 0
    squared: float = 0.0
    mean: float = 0.0
    about_mean: float = 0.0
    about_zero: float = 0.0
    largest: float = 0.0
    worst: WorstPoint | None = None

    @classmethod
    def of(
        cls, name: str, table: pd.DataFrame, simulated: pd.DataFrame, inputs: Sequence[str], first: int = 0
    ) -> ChannelErrors:
        """Return the errors in the rows of a table; `first` numbers the first row."""
        data, model = table[name].to_numpy(dtype=np.float64), simulated[name].to_numpy()
        rows = np.flatnonzero(~np.isnan(data))
        if not rows.size:
            return cls(name)
        y, error = data[rows], model[rows] - data[rows]
        worst = int(rows[np.argmax(graded(np.abs(error)))])  # argmax treats a NaN of the FMU as the largest
        point = WorstPoint(
            first + worst,
            float(table["t"].iloc[worst]) if "t" in table else None,
            {column: float(table[column].iloc[worst]) + 0.0 for column in inputs},
            float(data[worst]),
            float(model[worst]),
        )
        mean = float(y.mean())
        about_mean, about_zero = float(((y - mean) ** 2).sum()), float((y**2).sum())
        return cls(name, len(rows), float(error @ error), mean, about_mean, about_zero, float(np.abs(y).max()), point)

    def merged(self, later: ChannelErrors) -> ChannelErrors:
        """Return the errors of both parts.

        >>> part = pd.DataFrame({"Fz": 900.0, "Fy": [0.0, 2.0]})
        >>> errors = ChannelErrors.of("Fy", part, part, ["Fz"])
        >>> both = errors.merged(ChannelErrors.of("Fy", part + 4.0, part, ["Fz"], first=2))
        >>> both.count, both.mean, both.about_mean, both.worst.row
        (4, 3.0, 20.0, 2)
        """
        if not (self.count and later.count):
            return self if self.count else later
        count, apart = self.count + later.count, later.mean - self.mean
        between = apart**2 * self.count * later.count / count
        return ChannelErrors(
            self.name,
            count,
            self.squared + later.squared,
            self.mean + apart * later.count / count,
            self.about_mean + later.about_mean + between,
            self.about_zero + later.about_zero,
            max(self.largest, later.largest),
            later.worst if _is_worse(later.worst, self.worst) else self.worst,
        )

    def channel(self, unit: str) -> CheckedChannel:
        """Return the goodness of fit; there is a measured value."""
        assert self.worst is not None
        rmse = sqrt(self.squared / self.count) if not isnan(self.squared) else nan
        return CheckedChannel(
            self.name,
            unit,
            self.count,
            rmse,
            rmse / self.largest if self.largest else nan,
            1.0 - self.squared / self.about_mean if self.about_mean else nan,
            1.0 - self.squared / self.about_zero if self.about_zero else nan,
            self.worst,
        )


def _is_worse(later: WorstPoint | None, earlier: WorstPoint | None) -> bool:
    """Return whether the error of a later point is larger; NaN is the largest."""
    assert later is not None
    assert earlier is not None
    error, so_far = (abs(point.simulated - point.measured) for point in (later, earlier))
    return not isnan(so_far) and not error <= so_far
