"""A recording of a test bench: the table, its sign convention, its source and metadata."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import wraps
from itertools import pairwise
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
import pandas as pd

from ..boundary.errors import DataError
from ..boundary.escaping import excerpt
from ..numerics.arrays import IntArray
from ..symbolic.channels import CHANNELS, OUTPUTS
from ..tires.notebook import html_summary, html_table
from ..tires.signs import convert_signs, reversed_columns
from .column_names import check_names
from .thresholds import LOGGING_GAP

T = TypeVar("T")
P = ParamSpec("P")
#: Characters of the longest source that a summary shows.
LONGEST_SOURCE = 80


def once(compute: Callable[Concatenate[Recording, P], T]) -> Callable[Concatenate[Recording, P], T]:
    """Let a function of a recording compute each result once: a recording does not change.

    Further arguments must be hashable. The results are stored in the recording.
    """

    @wraps(compute)
    def stored(recording: Recording, /, *args: P.args, **kwargs: P.kwargs) -> T:
        results = vars(recording).setdefault("_results", {})
        key = compute, args, tuple(kwargs.items())
        if key not in results:
            results[key] = compute(recording, *args, **kwargs)
        return results[key]  # type: ignore[no-any-return]

    return stored


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """A recording of a test bench, in SI units. Neither it nor its table changes: another table is another recording.

    Parameters
    ----------
    table : pandas.DataFrame
        The recorded columns of the public contract (``t kappa alpha gamma Fz p V T phit``, ``Fx Fy Mz Mx My``) in SI
        units. Other columns are passed through.
    signs : str
        ``iso``, ``sae`` or ``adapted-sae``.
    source : str
        The file's name, or "virtual bench: ...".
    about : mapping of str to str
        Metadata: tireid, testid, credit, units, declared (channels whose unit the file declares).
    checked : bool
        Whether `recording_from` has checked it. A recording that is made of it (`replace`) is checked again.

    Raises
    ------
    UnknownName
        If the signs are not one of the three conventions.

    Examples
    --------
    >>> bench = Recording(pd.DataFrame({"alpha": [0.1], "Fz": [-900.0], "Fy": [-800.0]}), "sae", "run.mat")
    >>> bench.with_signs("iso").table.iloc[0].to_dict()
    {'alpha': -0.1, 'Fz': 900.0, 'Fy': 800.0}
    """

    table: pd.DataFrame
    signs: str
    source: str
    about: Mapping[str, str] = field(default_factory=dict)
    checked: bool = field(default=False, init=False)

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields: results computed from them (`once`) are not sent to other processes."""
        return {part.name: getattr(self, part.name) for part in fields(self)}

    def __post_init__(self) -> None:
        reversed_columns(self.signs, "iso")  # raises for an unknown convention

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.table)

    def __repr__(self) -> str:
        """Return source, rows, signs and the range of each channel in a few lines."""
        ranges = [f"{name} {low:.4g} to {high:.4g} {unit}".rstrip() for name, low, high, unit in self._ranges()]
        return "\n".join([self._title(), *(f"  {', '.join(ranges[i : i + 4])}" for i in range(0, len(ranges), 4))])

    def _repr_html_(self) -> str:
        """Return the same as a table, for a notebook."""
        return html_summary(self._title(), html_table(["channel", "from", "to", "unit"], self._ranges()))

    def _title(self) -> str:
        return f"Recording {excerpt(self.source, LONGEST_SOURCE)!r}: {len(self)} rows, {self.signs} signs"

    def _ranges(self) -> list[tuple[str, float, float, str]]:
        """Return name, smallest and largest value and unit of each channel that has numbers."""
        numbers = {name: pd.to_numeric(self.table[name], errors="coerce") for name in CHANNELS if name in self.table}
        return [
            (name, float(values.min()), float(values.max()), CHANNELS[name].after.strip())
            for name, values in numbers.items()
            if values.notna().any()
        ]

    def with_signs(self, target: str) -> Recording:
        """Return the recording in another sign convention.

        Parameters
        ----------
        target : str
            ``iso``, ``sae`` or ``adapted-sae``.

        Returns
        -------
        Recording
            The same rows in the other convention.

        Raises
        ------
        UnknownName
            If the convention is not one of the three.
        """
        if target == self.signs:
            return self
        return replace(self, table=convert_signs(self.table, self.signs, target), signs=target)

    def measured(self) -> tuple[str, ...]:
        """Return the output channels that hold at least one measured value.

        Returns
        -------
        tuple of str
            In the order of `OUTPUTS`.

        Raises
        ------
        DataError
            If there is none, or a column resembles an output that the table lacks (`check_names`).

        Examples
        --------
        >>> Recording(pd.DataFrame({"Fz": [900.0], "FX": [1.0]}), "iso", "a.csv").measured()
        Traceback (most recent call last):
        ...
        tirefmu.boundary.errors.DataError: a.csv: column 'FX' is not a channel: did you mean Fx? ...
        """
        check_names(map(str, self.table.columns), self.source, OUTPUTS)
        measured = tuple(name for name in OUTPUTS if name in self.table and self.table[name].notna().any())
        if not measured:
            raise DataError(f"{self.source}: no measured output ({', '.join(OUTPUTS)}){self._where_outputs_may_be()}")
        return measured

    def _where_outputs_may_be(self) -> str:
        """Return what a message about absent outputs adds: columns without a value, or those that were not read."""
        if empty := [name for name in OUTPUTS if name in self.table]:
            return f": {', '.join(empty)} {'has' if len(empty) == 1 else 'have'} no value"
        ignored = self.about.get("ignored", "")
        return f"; not read: {excerpt(ignored)} (--columns Fy=NAME takes one)" if ignored else ""

    @once
    def segments(self) -> list[slice]:
        """Return the segments: consecutive rows that were logged without interruption.

        A segment ends where ``t`` increases by more than five median steps, or decreases. Without ``t`` the table is
        one segment.

        Returns
        -------
        list of slice
            In the order of the rows. Together they contain every row once.

        Examples
        --------
        >>> rows = pd.DataFrame({"t": [0.0, 0.01, 0.02, 20.0, 20.01]})
        >>> Recording(rows, "iso", "run.csv").segments()
        [slice(0, 3, None), slice(3, 5, None)]
        """
        if not len(self):
            return []
        if "t" not in self.table:
            return [slice(0, len(self))]
        steps = np.diff(self.table["t"].to_numpy(dtype=np.float64))
        forward = steps[steps > 0.0]
        median = float(np.median(forward)) if len(forward) else np.inf
        cuts = np.flatnonzero((steps > LOGGING_GAP * median) | (steps < 0.0)) + 1
        edges = [0, *cuts.tolist(), len(self)]
        return [slice(start, stop) for start, stop in pairwise(edges)]

    def segment_numbers(self) -> IntArray:
        """Return the number of the segment (`segments`) of each row, counted from 0.

        Returns
        -------
        ndarray of int, shape (n,)
            It never decreases.

        Examples
        --------
        >>> Recording(pd.DataFrame({"t": [0.0, 0.01, 0.02, 20.0, 20.01]}), "iso", "run.csv").segment_numbers().tolist()
        [0, 0, 0, 1, 1]
        """
        pieces = self.segments()
        return np.repeat(np.arange(len(pieces)), [piece.stop - piece.start for piece in pieces])


def distinct(names: Sequence[str]) -> list[str]:
    """Return the names with repeated ones numbered: two folders may contain files of the same name.

    >>> distinct(["run.mat", "other.mat", "run.mat"])
    ['run.mat', 'other.mat', 'run.mat (2)']
    """
    return [name if name not in names[:i] else f"{name} ({names[:i].count(name) + 1})" for i, name in enumerate(names)]
