"""Tables with the rows of several cars: a column whose values have a clock each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ....boundary.escaping import quoted
from ....measurements.files.columns.cells import is_time
from ....measurements.files.columns.content import Column, Content, listed

FloatArray = npt.NDArray[np.float64]

#: Most values of the column, fewest rows of one, smallest share of rows with another value than the one before, and
#: rows that show what the cells are.
MOST, MIN_ROWS, CHANGING, HEAD = 50, 10, 0.1, 1000
#: Judgement: share of its median steps that a value has over the span of its rows (packets are lost, but a gear or a
#: flag has its rows now and then), and how much rougher the rows of the table are than those of one value (those
#: of a counter are smoother).
STEADY, ROUGHER = 0.6, 2.0


def several_cars(content: Content, clock: FloatArray, channels: Sequence[tuple[Column, FloatArray]]) -> str:
    """Return that a column divides the rows of a table into those of several cars; empty without one.

    The times of each of its values rise. Those of the table go back, or rows of several values with steady clocks
    alternate and differ more than those of one.

    `clock`, shape (n,): times of the rows in s. `channels`: columns that are read, and their values, shape (n,).
    """
    read = {id(column) for column, _ in channels}
    for column, codes, names in _candidates(content):
        for _, values in channels if id(column) not in read else ():
            usable = np.isfinite(clock) & np.isfinite(values)
            if len(codes) == len(values) and _divides(codes[usable], clock[usable], values[usable]):
                cars = quoted(listed([name if isinstance(name, str) else f"{float(name):g}" for name in names]))
                return f"column {column.header.strip()}: each of {cars} has times of its own: save the rows of one"
    return ""


def _candidates(content: Content) -> Iterator[tuple[Column, npt.NDArray[np.intp], Sequence[Any]]]:
    """Yield the columns of names or of whole numbers of which each has many rows: column, number of the name, names."""
    for column in content.columns:
        cells = pd.Series(column.cells)
        if column.times is None and all(map(_is_label, cells.head(HEAD).unique())):
            codes, names = pd.factorize(cells)
            if 2 <= len(names) <= min(MOST, len(cells) / MIN_ROWS) and all(map(_is_label, names)):
                yield column, codes, list(names)


def _is_label(cell: object) -> bool:
    try:
        return float(cell).is_integer()  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return isinstance(cell, str) and not is_time(cell)


def _divides(codes: npt.NDArray[np.intp], times: FloatArray, values: FloatArray) -> bool:
    changes, backward = np.diff(codes) != 0, bool((np.diff(times) < 0.0).any())
    if not changes.any() or (np.mean(changes) < CHANGING and not backward):
        return False
    order = np.argsort(codes, kind="stable")
    same = codes[order][1:] == codes[order][:-1]
    steps = np.diff(times[order])[same]
    if backward or (steps <= 0.0).any():
        return backward and bool((steps > 0.0).all())
    groups = pd.Series(steps).groupby(codes[order][1:][same])
    steady = (groups.sum() < groups.size() * groups.median() / STEADY).all()
    between, within = np.abs(np.diff(values))[changes], np.abs(np.diff(values[order]))[same]
    return bool(steady and np.median(between) > ROUGHER * np.median(within))
