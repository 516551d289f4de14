"""Measured rows of a least-squares problem, which are gone through block by block."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from ...numerics.arrays import FloatArray, IntArray
from ...tires.tire import Tire

#: Rows of a block: what is computed from them needs 15 MB. A multiple of the rows that kernels and intervals take.
BLOCK = 65_280


def inputs_of(table: pd.DataFrame, tire: Tire) -> FloatArray:
    """Return the inputs of a tire, shape (n_inputs, n), from a table; an absent input is nominal."""
    return np.stack([
        table[name].to_numpy(dtype=float) if name in table else np.full(len(table), tire.nominal(name))
        for name in tire.inputs
    ])  # fmt: skip


@dataclass(frozen=True)
class Rows:
    """Measured rows.

    - `inputs`, shape (n_inputs, n): in the model's order, SI units.
    - `measured`, shape (n, n_forces): NaN if a channel was not measured or is not fitted.
    - `group`, shape (n,): number of the recording of each row.
    - `segment`, shape (n,): number of the segment without gaps of each row; by default each recording is one segment.
    - `weight`, shape (n,): weight of each row within its recording; by default 1.
    - `time`, shape (n,): s; by default NaN.
    """

    inputs: FloatArray
    measured: FloatArray
    group: IntArray
    segment: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    weight: FloatArray = field(default_factory=lambda: np.zeros(0))
    time: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.segment) != len(self.group):
            object.__setattr__(self, "segment", self.group)
        if len(self.weight) != len(self.group):
            object.__setattr__(self, "weight", np.ones(len(self.group)))
        if len(self.time) != len(self.group):
            object.__setattr__(self, "time", np.broadcast_to(np.nan, len(self.group)))

    @classmethod
    def of(cls, table: pd.DataFrame, tire: Tire, channels: Sequence[str]) -> Rows:
        """Return the rows of a table; only the given channels are fitted."""
        absent = pd.Series(np.nan, table.index)
        measured = [table.get(name, absent) if name in channels else absent for name in tire.outputs]
        group = table["recording"] if "recording" in table else pd.Series(0, table.index)
        segment, weight = table.get("segment", group), table.get("weight", pd.Series(1.0, table.index))
        return cls(
            inputs_of(table, tire),
            np.stack([column.to_numpy(dtype=float) for column in measured]).T,
            np.asarray(group, dtype=np.int64),
            np.asarray(segment, dtype=np.int64),
            np.asarray(weight, dtype=float),
            np.asarray(table.get("t", absent), dtype=float),
        )

    def in_table(self, table: pd.DataFrame, tire: Tire) -> pd.DataFrame:
        """Return the table of these rows with their arrays as columns, which need no memory of their own then."""
        arrays = dict(zip((*tire.inputs, *tire.outputs), (*self.inputs, *self.measured.T), strict=True))
        arrays |= {"recording": self.group, "segment": self.segment, "weight": self.weight, "t": self.time}
        # A column of the table shares the memory of others, which would not be released.
        columns = {name: arrays[name] if name in arrays else table[name].to_numpy(copy=True) for name in table}
        return pd.DataFrame(columns, table.index, copy=False)

    def __len__(self) -> int:
        return len(self.measured)

    def blocks(self) -> Iterator[Rows]:
        """Yield the rows in their order, `BLOCK` at most at a time, without a copy."""
        for start in range(0, len(self.group), BLOCK):
            rows = slice(start, start + BLOCK)
            yield self.take(rows)

    def of_recording(self, group: int) -> Rows:
        """Return the rows of one recording."""
        members = self.group == group
        return self if members.all() else self.take(np.flatnonzero(members))  # a copy is much memory

    def only(self, fitted: Sequence[bool]) -> Rows:
        """Return the rows with some of their forces, and NaN instead of the others; all else is shared."""
        dropped = ~np.array(fitted, dtype=np.bool_) & ~np.isnan(self.measured).all(axis=0)
        if not dropped.any():
            return self
        measured = self.measured.copy(order="K")
        measured[:, dropped] = np.nan
        return replace(self, measured=measured)

    def sample(self, n: int | None, seed: int = 0) -> Rows:
        """Return n random rows, in their order; all rows if n is None or there are no more.

        Every k-th row would alias with sweeps. Rows are drawn from the recordings in the order of their size, so the
        sample does not depend on the order in which they are given.
        """
        if n is None or n >= len(self.group):
            return self
        groups, sizes = np.unique(self.group, return_counts=True)
        equal = np.isin(
            sizes, [size for size, times in zip(*np.unique(sizes, return_counts=True), strict=True) if times > 1]
        )
        contents = [
            self.measured[self.group == group].tobytes() if tied else b""
            for group, tied in zip(groups, equal, strict=True)
        ]
        order = sorted(range(len(groups)), key=lambda i: (sizes[i], contents[i]))
        rows = np.concatenate([np.flatnonzero(self.group == groups[i]) for i in order])
        return self.take(np.sort(np.random.default_rng(seed).choice(rows, n, replace=False)))

    def take(self, chosen: IntArray | slice) -> Rows:
        """Return some of the rows; a slice is no copy."""
        return Rows(
            self.inputs[:, chosen], self.measured[chosen], self.group[chosen], self.segment[chosen],
            self.weight[chosen], self.time[chosen],
        )  # fmt: skip
