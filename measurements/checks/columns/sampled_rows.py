"""Some rows of a table in ISO signs, and the regressions from which its traits are computed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from ....numerics.arrays import BoolArray, FloatArray
from ....symbolic.channels import CONTROLLED_INPUTS, OUTPUTS
from ...recording import Recording
from ...thresholds import (
    FAR_SLIP,
    LIGHT_LOAD,
    MAX_SAMPLED_ROWS,
    MIN_RESPONSE,
    MIN_SLIP_DEVIATION,
    MIN_SPREAD,
    MIN_TRAIT_ROWS,
    NEAR_SLIP,
    SMALL_SLIP,
    SPIKE_QUANTILE,
)

#: Shares of the largest slip: up to which a change from row to row is noise; over which a memory fades.
HELD_SHARE, FADING_SHARE = 1e-3, 0.1
#: The channels that are read.
_READ = tuple(name for name in (*CONTROLLED_INPUTS, *OUTPUTS) if name != "phit")


@dataclass(frozen=True, eq=False)
class SampledRows:
    """BoolArray of a table in ISO signs: finite inputs, loads that are not small, every k-th row of many.

    `columns`: the channels as arrays, shape (n,); an absent one is missing. `load`: the magnitude of Fz, shape (n,);
    ones without Fz.
    """

    columns: dict[str, FloatArray]

    @classmethod
    def of(cls, table: pd.DataFrame) -> SampledRows:
        """Return rows of a table in ISO signs."""
        thin = _thin(table)
        columns = {name: thin[name].to_numpy(dtype=np.float64) for name in _READ if name in thin}
        if "Fz" in columns:
            size = np.abs(columns["Fz"])
            loaded = (size >= LIGHT_LOAD * np.nanquantile(size, 0.95)) & (size > 0.0) if len(size) else size > 0.0
            columns = {name: values[loaded] for name, values in columns.items()}
        return cls({name: values for name, values in columns.items() if np.isfinite(values).any()})

    @staticmethod
    def thinned(recording: Recording) -> Recording:
        """Return the recording with the rows that are read, at most `MAX_SAMPLED_ROWS`."""
        return replace(recording, table=_thin(recording.table))

    def __contains__(self, name: str) -> bool:
        """Return whether the channel has numbers."""
        return name in self.columns

    def __getitem__(self, name: str) -> FloatArray:
        """Return a channel, zeros for a slip or camber that is absent."""
        return self.columns[name] if name in self.columns else np.zeros(self.count)

    @property
    def count(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values()), ()))

    @cached_property
    def load(self) -> FloatArray:
        """The magnitude of the load, shape (n,)."""
        return np.abs(self.columns["Fz"]) if "Fz" in self.columns else np.ones(self.count)

    def largest(self, name: str) -> float:
        """Return the largest magnitude of a channel without its spikes."""
        if name not in self._largest:
            self._largest[name] = float(np.nanquantile(np.abs(self[name]), 1.0 - SPIKE_QUANTILE)) if self.count else 0.0
        return self._largest[name]

    @cached_property
    def _largest(self) -> dict[str, float]:
        return {}

    def near_zero(self, slip: str, share: float = NEAR_SLIP, least: float = SMALL_SLIP) -> BoolArray:
        """Return the rows at which a slip is a small share of its largest value, or at most `least`."""
        return np.asarray(np.abs(self[slip]) <= max(least, share * self.largest(slip)))

    def far(self, slip: str) -> BoolArray:
        """Return the rows at which a slip is a large share of its largest value."""
        return np.asarray(np.abs(self[slip]) >= FAR_SLIP * self.largest(slip))

    def memory(self, slip: str) -> FloatArray:
        """Return what a force with memory depends on, shape (n, 2).

        The direction of the last change of a slip, and the same fading with the distance since the slip turned. Noise
        of a held slip is no change.
        """
        largest = self.largest(slip) or 1.0
        steps = np.diff(self[slip], prepend=self[slip][:1])
        steps = np.where(np.abs(steps) > HELD_SHARE * largest, steps, 0.0)
        rows = np.arange(self.count)
        direction = np.sign(steps[np.maximum.accumulate(np.where(steps != 0.0, rows, 0))])
        turned = np.maximum.accumulate(np.where(np.diff(direction, prepend=0.0) != 0.0, rows, 0))
        path = np.cumsum(np.abs(steps))
        fading = np.exp(-(path - path[turned]) / (FADING_SHARE * largest))
        return np.column_stack([direction, direction * fading])

    def slope(self, name: str, over: str, rows: BoolArray, divisor: FloatArray | None = None) -> float:
        """Return the slope of a channel over another one, both about their means; NaN without enough rows.

        `divisor`: divides the channel, such as the load.
        """
        y = self[name] if divisor is None else self[name] / divisor
        x = self[over]
        chosen = rows & np.isfinite(x) & np.isfinite(y)
        if np.count_nonzero(chosen) < MIN_TRAIT_ROWS:
            return np.nan
        x, y = x[chosen], clipped(y[chosen])
        x = x - x.mean()
        if x.std() <= MIN_SPREAD * self.largest(over):
            return np.nan
        return float(x @ (y - y.mean())) / float(x @ x)

    def correlation(self, slip: str, force: str, rows: BoolArray) -> float:
        """Return the correlation of a slip with a force, the weaker one of those about the means and about zero.

        Beyond its peak a force falls with its slip but keeps its sign; an offset at a held slip has a sign but no
        slope. Both must agree; 0 otherwise, and for a slip that is not swept.
        """
        if slip not in self or force not in self:
            return 0.0
        chosen = rows & np.isfinite(self[slip]) & np.isfinite(self[force])
        x, y = self[slip][chosen], self[force][chosen]
        if len(x) < 3 or not (x.std() >= MIN_SLIP_DEVIATION or self._responds(force, chosen)):
            return 0.0
        y = clipped(y)
        about_mean, about_zero = _cosine(x - x.mean(), y - y.mean()), _cosine(x, y)
        weaker = min(abs(about_mean), abs(about_zero))
        return float(np.copysign(weaker, about_mean)) if about_mean * about_zero > 0.0 else 0.0

    def _responds(self, force: str, rows: BoolArray) -> bool:
        """Return whether a force changes by a considerable share of the load, as it does in a sweep of its slip."""
        return "Fz" in self and bool(np.ptp(clipped(self[force][rows] / self.load[rows])) > MIN_RESPONSE)


def _thin(table: pd.DataFrame) -> pd.DataFrame:
    return table.iloc[:: max(1, -(-len(table) // MAX_SAMPLED_ROWS))]


def clipped(values: FloatArray) -> FloatArray:
    """Return values limited to their quantiles, so that spikes have no influence."""
    return np.clip(values, *np.quantile(values, [SPIKE_QUANTILE, 1.0 - SPIKE_QUANTILE]))


def _cosine(x: FloatArray, y: FloatArray) -> float:
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size > 0.0 else 0.0
