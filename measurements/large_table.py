"""A Parquet table of many rows, read and checked in parts: the memory does not depend on its size.

The checks of a table in memory are applied to a survey of a large one: random rows, and the rows with the smallest and
the largest value of each channel. So a single value beyond the limits of its channel is found. Shares of rows and
correlations are those of the random rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from ..boundary.errors import DataError
from ..numerics.arrays import FloatArray
from ..tires.signs import reversed_columns
from ..tires.tire import Tire
from .channels import CHANNELS, INPUTS
from .checks.columns.limits import check_plausible
from .column_names import check_names
from .files.parquet_table import parquet_header, parquet_parts
from .files.resolution import choices
from .files.table_recording import channel_table
from .recording import Recording

#: Rows from which a table is large: with every named quantity of an evaluation they need about 250 MB.
LARGE = 500_000
#: Rows of a part: large enough for the kernels, 25 MB with every named quantity.
PART = 50_000
#: Random rows of a survey.
SURVEYED = 200_000


class LargeTable:
    """A Parquet table that is read in parts of `PART` rows, each in SI with contract names.

    `signs`: the convention of the table. Raises `DataError` if the file is not a Parquet file, or its columns cannot be
    used. Raises `UnknownName` if the signs are not one of the three conventions.
    """

    def __init__(self, path: Path, signs: str = "iso") -> None:
        reversed_columns(signs, "iso")  # raises for an unknown convention
        self._path, self.signs = path, signs
        header, self.rows = parquet_header(path)
        chosen = choices(header, CHANNELS, str(path))
        self.columns = tuple(channel_table(header, chosen, str(path)).columns)
        self._declared = " ".join(name for name, choice in chosen.items() if choice.declared)

    @classmethod
    def of(cls, path: Path, signs: str | None = None) -> LargeTable | None:
        """Return the table of a file; None if it is no Parquet table with at least `LARGE` rows."""
        if path.suffix.lower() != ".parquet" or not path.is_file():
            return None
        table = cls(path, signs or "iso")
        return table if table.rows >= LARGE else None

    def rows_are_independent(self, tire: Tire, *, steady: bool = False) -> bool:
        """Return whether the result of a tire in a row depends on that row only, so that parts can be evaluated.

        `steady`: whether slips and states are those of the steady state.
        """
        if "t" not in self.columns:
            return True
        rolled = "distance" in tire.inputs and "distance" not in self.columns
        return not rolled and (steady or not (tire.lags or tire.states))

    def parts(self) -> Iterator[pd.DataFrame]:
        """Yield the rows in their order, at most `PART` at a time.

        Raises `DataError` if a value of a channel is not a finite number, except for an output, which may be NaN; or
        the file has changed.
        """
        count = 0
        for start, content in parquet_parts(self._path, PART):
            table = channel_table(content, choices(content, CHANNELS, str(self._path)), str(self._path))
            self._check_finite(table, start)
            yield table
            count += len(table)
        if count != self.rows:
            raise DataError(f"{self._path}: {count} of {self.rows} rows can be read")

    @cached_property
    def survey(self) -> Recording:
        """Some rows of the table after all checks: random ones, and those with the extremes of each channel.

        Raises `DataError`: as `recording_from`; a row without an input is refused as well.
        """
        check_names(self.columns, str(self._path))
        random, share = np.random.default_rng(0), SURVEYED / self.rows
        chosen: list[pd.DataFrame] = []
        extremes: dict[tuple[str, float], tuple[float, pd.DataFrame]] = {}
        for table in self.parts():
            chosen.append(table[random.random(len(table)) < share])
            for name in CHANNELS:
                if name in table and table[name].notna().any():
                    _update_extremes(extremes, table, name)
        rows = pd.concat([*chosen, *(row for _, row in extremes.values())], ignore_index=True)
        recording = Recording(rows, self.signs, self._path.name, {"declared": self._declared})
        check_plausible(recording)
        return recording

    def _check_finite(self, table: pd.DataFrame, start: int) -> None:
        for name in CHANNELS:
            if name in table:
                values = table[name].to_numpy()
                bad = np.flatnonzero(~np.isfinite(values) if name in INPUTS else np.isinf(values))
                if bad.size:
                    what = "NaN" if np.isnan(values[bad[0]]) else "infinite"
                    raise DataError(
                        f"{self._path}: row {start + bad[0] + 1}: {name} is {what}: "
                        "every row of a table that is read in parts needs every input"
                    )


def _update_extremes(
    extremes: dict[tuple[str, float], tuple[float, pd.DataFrame]], table: pd.DataFrame, name: str
) -> None:
    """Replace the rows with the smallest and the largest value of a channel if a part exceeds them."""
    values: FloatArray = table[name].to_numpy()
    for sign, row in ((-1.0, int(np.nanargmin(values))), (1.0, int(np.nanargmax(values)))):
        value = sign * float(values[row])
        if (name, sign) not in extremes or value > extremes[name, sign][0]:
            extremes[name, sign] = value, table.iloc[[row]]
