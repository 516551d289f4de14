"""Columns of the linear problem in noise standard deviations, each stored for the channels in which it is not zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..numerics.arrays import FloatArray, IndexArray


@dataclass(frozen=True, eq=False)
class WeightedColumns:
    """Columns in noise standard deviations. Most are errors of one channel, so products are taken by channel.

    - `number`: of columns.
    - `of_channels`: for each channel, the indices (k,) of the columns that are not zero in it, and their rows (n, k).
    """

    number: int
    of_channels: tuple[tuple[IndexArray, FloatArray], ...]

    def times(self, other: WeightedColumns) -> FloatArray:
        """Return the products with other columns, shape (number, other.number).

        >>> alone, both = np.array([0]), np.array([0, 1])
        >>> one = WeightedColumns(2, ((alone, np.ones((3, 1))), (both, np.ones((3, 2)))))
        >>> one.times(one).tolist()
        [[6.0, 3.0], [3.0, 3.0]]
        """
        products = np.zeros((self.number, other.number))
        for (chosen, rows), (others, columns) in zip(self.of_channels, other.of_channels, strict=True):
            products[np.ix_(chosen, others)] += rows.T @ columns
        return products

    def at(self, rows: IndexArray) -> WeightedColumns:
        """Return the columns at some of the rows."""
        return replace(self, of_channels=tuple((chosen, columns[rows]) for chosen, columns in self.of_channels))

    def along(self, weighted: FloatArray) -> FloatArray:
        """Return the products with weighted rows, shape (n_channels, n), shape (number,)."""
        products = np.zeros(self.number)
        for (chosen, rows), channel in zip(self.of_channels, weighted, strict=True):
            products[chosen] += channel @ rows
        return products


def joined(parts: Sequence[WeightedColumns]) -> WeightedColumns:
    """Return the columns of all parts, one after another."""
    begins = np.cumsum([0, *(part.number for part in parts)])
    return WeightedColumns(
        int(begins[-1]),
        tuple(
            (
                np.concatenate([begin + chosen for begin, (chosen, _) in zip(begins[:-1], channel, strict=True)]),
                np.concatenate([rows for _, rows in channel], axis=1),
            )
            for channel in zip(*(part.of_channels for part in parts), strict=True)
        ),
    )
