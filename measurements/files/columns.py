"""Conversion of table columns to channels of the contract in SI units, with a clear message for each error."""

from __future__ import annotations

import re
from array import array
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, TirefmuError
from ...numerics.arrays import FloatArray
from ..channels import CHANNELS, INPUTS, channel
from ..column_names import check_names
from ..interpretation import Interpretation
from ..thresholds import MAX_INCOMPLETE
from ..units import to_si

#: Upper limits: columns of a table, characters of a header that may declare a unit.
MAX_COLUMNS, LONGEST_HEADER = 5000, 200
#: Inputs by their names in FSAE TTC files.
_BENCH_INPUTS = {
    name: CHANNELS[channel] for channel in INPUTS for name in CHANNELS[channel].bench_names if name not in CHANNELS
}
#: Quantities that the bench does not measure in SI units: without a declared unit the name may be meant either way.
_BENCH_UNITS = ("angle", "pressure", "speed")
_HEADER = re.compile(r"(?P<name>[^\[\]]*?)\s*\[(?P<unit>[^\[\]]*)\]")
_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")


@dataclass(frozen=True)
class Column:
    """One column of a table: its name and the unit that its header declares (``alpha [deg]``); None for SI."""

    name: str
    unit: str | None = None

    @classmethod
    def parse(cls, header: str) -> Column:
        """Read a header. Brackets declare a unit only after a name of the contract."""
        name, unit = name_and_unit(header)
        return cls(name, unit) if name in CHANNELS else cls(header.strip())


def name_and_unit(header: str) -> tuple[str, str | None]:
    """Return the name of a header, and the unit in brackets behind it.

    >>> name_and_unit("alpha [deg]"), name_and_unit("alpha")
    (('alpha', 'deg'), ('alpha', None))
    """
    match = _HEADER.fullmatch(header.strip()) if len(header) <= LONGEST_HEADER else None
    return (match["name"], match["unit"]) if match else (header.strip(), None)


def parse_header(headers: Sequence[str], source: str, interpretation: Interpretation | None = None) -> list[Column]:
    """Read the headers of a table, with the names that an interpretation gives them.

    A name of FSAE TTC files is that of the input if the table lacks it and the unit is clear. Other unknown columns are
    passed through, unless the name resembles an input that the table lacks (`check_names`). Raises
    `DataError` if there are more than `MAX_COLUMNS` columns, a name occurs twice, or no column is a channel.

    >>> [column.name for column in parse_header(["alpha", "TSTC", "IA [deg]", "remark"], "a.csv")]
    ['alpha', 'T', 'gamma', 'remark']
    """
    if interpretation:
        headers = interpretation.headers(headers, source)
    if len(headers) > MAX_COLUMNS:
        raise DataError(f"{source}: {len(headers)} columns: at most {MAX_COLUMNS} are read")
    columns = [
        Column.parse(header) if header.strip() else Column(f"column {number}")
        for number, header in enumerate(headers, start=1)
    ]
    given = {column.name for column in columns}
    columns = [_by_contract(column, given) for column in columns]
    names = Counter(column.name for column in columns)
    for name, count in names.items():
        if count > 1:
            raise DataError(f"{source}: column {name!r} occurs {count} times")
    check_names(names, source)
    if not any(name in CHANNELS for name in names):
        raise DataError(f"{source}: no column is a channel: known are {', '.join(CHANNELS)}")
    return columns


def _by_contract(column: Column, given: Collection[str]) -> Column:
    """Return a column under the name of the contract if it has a name of the bench and the table lacks the channel."""
    name, unit = name_and_unit(column.name)
    meant = _BENCH_INPUTS.get(name)
    if meant is None or meant.name in given or (unit is None and meant.quantity in _BENCH_UNITS):
        return column
    return Column(meant.name, unit)


def channels_in_si(
    table: pd.DataFrame, columns: Sequence[Column], source: str, location: Callable[[int], str]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return the table with contract names and SI units, with every channel checked, and metadata.

    `columns`: one for each column of the table, in the same order. `location`: converts the number of a row, counted
    from 0, to "line 12" or "row 12" for messages. Channels are floats; other columns are unchanged. The metadata
    ``declared`` has the channels whose unit the table declares, ``unit of NAME`` the unit. Raises `DataError` if there
    are no rows. Also raises what `converted_channels` and `check_finite` raise.
    """
    if table.empty:
        raise DataError(f"{source}: no rows")
    converted = converted_channels(table, columns, source, location)
    for column in columns:
        if column.name in CHANNELS:
            check_finite(converted[column.name].to_numpy(), column.name, source, location)
    units = {column.name: column.unit for column in columns if column.unit is not None}
    return converted, {"declared": " ".join(units), **{f"unit of {name}": unit for name, unit in units.items()}}


def converted_channels(
    table: pd.DataFrame, columns: Sequence[Column], source: str, location: Callable[[int], str]
) -> pd.DataFrame:
    """Return the table with contract names and SI units; see `channels_in_si`. A channel may contain NaN or infinities.

    Raises `DataError` if a cell of a channel is not a number, or a declared unit is unknown or one of another quantity.
    """
    converted: dict[str, pd.Series] = {}
    for number, column in enumerate(columns):
        cells = table.iloc[:, number].rename(column.name)
        if column.name in CHANNELS:
            values = numbers(cells, source, location)
            if column.unit is not None:
                values = in_si(values, column.unit, channel(column.name).quantity, f"{source}: column {column.name}")
            cells = pd.Series(values, name=column.name)
        converted[column.name] = cells.reset_index(drop=True)
    return pd.DataFrame(converted)


def in_si(values: FloatArray, unit: str, quantity: str, place: str) -> FloatArray:
    """Return `to_si` of the values; an error begins with the place in the file, such as "a.csv: column alpha"."""
    try:
        return to_si(values, unit, quantity)
    except TirefmuError as error:
        raise DataError(f"{place}: {error}") from None


def check_finite(values: FloatArray, name: str, source: str, location: Callable[[int], str]) -> None:
    """Check that a channel has no infinities, and an input few NaN.

    Rows without an input are excluded later (`without_incomplete_rows`). `location`: as for `channels_in_si`.
    Raises `DataError` with the first location, the channel and the number of rows.
    """
    infinite, unknown = np.isinf(values), np.isnan(values) & (name in INPUTS)
    for bad, kind, most in ((infinite, "infinite", 0.0), (unknown, "NaN", MAX_INCOMPLETE)):
        if bad.mean() > most:
            first = location(int(np.flatnonzero(bad)[0]))
            limit = f": up to {100.0 * most:g} % are excluded" if most else ""
            raise DataError(f"{source}: {first}: {name} is {kind} ({bad.sum()} of {len(values)} rows){limit}")


def numbers(cells: pd.Series, source: str, location: Callable[[int], str]) -> FloatArray:
    """Return the cells as floats, or report the first one that is not a number."""
    if pd.api.types.is_bool_dtype(cells):
        cells = cells.astype(str)  # a truth value is not a number
    if pd.api.types.is_numeric_dtype(cells):
        return cells.to_numpy(dtype=np.float64, na_value=np.nan)
    objects = cells.to_numpy(dtype=object, na_value=np.nan)
    try:
        return objects.astype(np.float64)  # float() reads decimals exactly
    except (TypeError, ValueError):
        row = next(row for row, cell in enumerate(objects) if not is_number(cell))
        shown = str(cells.iloc[row])
        hint = f": a decimal comma? write {shown.replace(',', '.')}" if _COMMA.fullmatch(shown.strip()) else ""
        raise DataError(f"{source}: {location(row)}: column {cells.name}: {shown!r} is not a number{hint}") from None


def is_number(cell: Any) -> bool:
    """Return whether `float` accepts a cell."""
    try:
        float(cell)
    except (TypeError, ValueError):
        return False
    return True


def rows_of_numbers(rows: Iterable[tuple[int, Sequence[str]]], names: Sequence[str], source: str) -> FloatArray:
    """Return the rows of a text file as numbers, shape (n, number of names).

    `rows`: line number and cells of each. Raises `DataError` if there is none, a row has another number of cells than
    there are names, or a cell is not a number.
    """
    numbers = array("d")  # 8 bytes each; a list of texts would need ten times as much
    for line, cells in rows:
        if len(cells) != len(names):
            raise DataError(f"{source}: line {line}: {len(cells)} cells for {len(names)} channels")
        try:
            numbers.extend(map(float, cells))
        except ValueError:
            name, cell = next(pair for pair in zip(names, cells, strict=True) if not is_number(pair[1]))
            raise DataError(f"{source}: line {line}: channel {name}: {cell!r} is not a number") from None
    if not numbers:
        raise DataError(f"{source}: no rows")
    return np.array(numbers).reshape(-1, len(names))
