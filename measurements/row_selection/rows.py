"""Conditions on the rows of a recording, as a tree."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

#: Returns the numbers of a name for every row: those of a channel in SI units, or a counter.
Columns = Callable[[str], NDArray[np.float64]]


class Rows(Protocol):
    """A condition that each row satisfies or not."""

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """Return for each row of a file whether it satisfies the condition; NaN satisfies no comparison."""

    def names(self) -> set[str]:
        """Return the names that the condition uses: channels, counters, "file"."""


@dataclass(frozen=True)
class InRanges:
    """A channel or a counter, or its magnitude, in one of several ranges. The limits are included."""

    name: str
    absolute: bool
    ranges: tuple[tuple[float, float], ...]

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """See `Rows`."""
        values = np.abs(columns(self.name)) if self.absolute else columns(self.name)
        return np.asarray(np.any([(values >= low) & (values <= high) for low, high in self.ranges], axis=0))

    def names(self) -> set[str]:
        """See `Rows`."""
        return {self.name}


@dataclass(frozen=True)
class InFile:
    """The rows of the file with this name."""

    file: str

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """See `Rows`."""
        return np.full(len(columns("sample")), self.file == file)

    def names(self) -> set[str]:
        """See `Rows`."""
        return {"file"}


@dataclass(frozen=True)
class Not:
    """All rows that do not satisfy a condition."""

    part: Rows

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """See `Rows`."""
        return ~self.part.matches(columns, file)

    def names(self) -> set[str]:
        """See `Rows`."""
        return self.part.names()


@dataclass(frozen=True)
class AllOf:
    """The rows that satisfy every one of several conditions."""

    parts: tuple[Rows, ...]

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """See `Rows`."""
        return np.asarray(np.all([part.matches(columns, file) for part in self.parts], axis=0))

    def names(self) -> set[str]:
        """See `Rows`."""
        return set().union(*(part.names() for part in self.parts))


@dataclass(frozen=True)
class AnyOf:
    """The rows that satisfy at least one of several conditions."""

    parts: tuple[Rows, ...]

    def matches(self, columns: Columns, file: str) -> NDArray[np.bool_]:
        """See `Rows`."""
        return np.asarray(np.any([part.matches(columns, file) for part in self.parts], axis=0))

    def names(self) -> set[str]:
        """See `Rows`."""
        return set().union(*(part.names() for part in self.parts))
