"""Long tables: a row for each value, with the name of its signal, as databases and telemetry systems export them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from ....boundary.errors import DataError
from ....boundary.escaping import quoted
from ....numerics.arrays import FloatArray
from .cells import is_number, is_time, numbers
from .content import Column, Content, listed, name_and_unit

#: Names of the columns that have the names, the values and the units of signals, in lower case without signs.
NAMES = ("name", "signal", "signalname", "channel", "channelname", "parameter", "variable", "sensor", "telemetryname",
         "measurement", "field", "metric", "key")  # fmt: skip
VALUES = ("value", "signalvalue", "telemetryvalue", "val")
UNITS = ("unit", "units")
#: Most cells of the table with a column for each signal; mean rows of a signal that a name must have at least.
LARGEST, MIN_ROWS = 50_000_000, 2


def with_columns_of_signals(content: Content, source: str) -> Content:
    """Return the content of a long table with a column for each signal, empty in the rows of others.

    A table without a column of repeated names and one of values is returned as it is. Raises `DataError` if another
    column of texts distinguishes rows of one signal, such as those of several cars.
    """
    values = [column for column in content.columns if _word(column) in VALUES]
    named = ((column, _texts(column)) for column in content.columns if values and _word(column) in NAMES)
    names = [(column, texts) for column, texts in named if texts is not None]
    if len(values) != 1 or not names:
        return content
    column, texts = max(names, key=lambda pair: pair[1].nunique())
    signals = list(dict.fromkeys(texts))
    if len(signals) * MIN_ROWS > len(texts) or len(signals) * len(texts) > LARGEST:
        return content
    cells = _numbers(values[0], content, source)
    units = next(
        (cells for cells in (_texts(other) for other in content.columns if _word(other) in UNITS) if cells is not None),
        None,
    )
    others = [other for other in content.columns if other not in (column, values[0]) and _word(other) not in UNITS]
    for other in others:
        _refuse_several(other, texts, source)
    for signal in signals:
        rows = (texts == signal).to_numpy()
        unit = "" if units is None else units[rows].iloc[0].strip()
        others.append(Column(signal.strip(), np.where(rows, cells, np.nan), unit))
    return replace(content, columns=tuple(others))


def _word(column: Column) -> str:
    return "".join(filter(str.isalnum, name_and_unit(column.header)[0].casefold()))


def _texts(column: Column) -> pd.Series | None:
    """Return the cells of a column of texts that are neither numbers nor times; None for another column."""
    cells = pd.Series(column.cells).reset_index(drop=True)
    plain = len(cells) > 0 and all(
        isinstance(cell, str) and not is_number(cell) and not is_time(cell) for cell in cells
    )
    return cells if plain else None


def _numbers(column: Column, content: Content, source: str) -> FloatArray:
    return numbers(column.cells, source, f"column {column.header.strip()}", content.location)[0]


def _refuse_several(column: Column, signals: pd.Series, source: str) -> None:
    texts = _texts(column)
    if texts is None or len(texts) < MIN_ROWS * texts.nunique() or texts.groupby(signals).nunique().max() == 1:
        return
    several = quoted(listed(list(dict.fromkeys(texts))))
    raise DataError(
        f"{source}: column {column.header.strip()}: {several} in rows of one signal: save a table with the rows of one"
    )
