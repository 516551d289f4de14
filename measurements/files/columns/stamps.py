"""Times in two columns, of whole seconds and of fractions, as in tables of ROS: ``stamp.secs`` and ``stamp.nsecs``."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ....boundary.errors import DataError
from ....numerics.arrays import FloatArray
from .cells import numbers
from .content import Column, Content

_SECONDS = re.compile(r"(?P<stem>(?:.*[\W_])?)s(?:ecs?(?:onds?)?)?\W?", re.IGNORECASE)
_FRACTION = re.compile(r"(?P<stem>(?:.*[\W_])?)(?P<part>n|nano|u|micro|m|milli)s(?:ecs?(?:onds?)?)?\W?", re.IGNORECASE)
#: s, by the first letter of the part.
_PARTS = {"n": 1e-9, "u": 1e-6, "m": 1e-3}


def with_whole_stamps(content: Content) -> Content:
    """Return the content with a column of times, from 0 on, before each pair of whole seconds and fractions.

    It has the name before both, otherwise ``time``, unless another column has it. A fraction is less than a second.
    """
    fractions, names = {}, {(column.group, column.header.strip()) for column in content.columns}
    for column in content.columns:
        if match := _FRACTION.fullmatch(column.header.strip()):
            part = "u" if match["part"].casefold() == "micro" else match["part"][0].casefold()
            fractions[column.group, match["stem"]] = column, _PARTS[part]
    columns: list[Column] = []
    for column in content.columns:
        match = _SECONDS.fullmatch(column.header.strip())
        fraction, part = fractions.get((column.group, match["stem"]), (None, 0.0)) if match else (None, 0.0)
        if match and fraction and (times := _times(column, fraction, part)) is not None:
            name = match["stem"].strip("._/ ([") or "time"
            if (column.group, name) not in names:
                columns.append(replace(column, header=name, cells=times, unit="s"))
        columns.append(column)
    return replace(content, columns=tuple(columns))


def _times(whole: Column, fraction: Column, part: float) -> FloatArray | None:
    """Return the times in s from the first whole second on; None if the columns are not of such a pair."""
    try:
        seconds, _ = numbers(whole.cells, "", "", str, clock=True)
        fractions, _ = numbers(fraction.cells, "", "", str)
    except DataError:
        return None
    usable = np.isfinite(seconds) & np.isfinite(fractions) if len(seconds) == len(fractions) else np.zeros(0, bool)
    parts = fractions[usable] * part if usable.any() else np.ones(1)
    if (parts < 0.0).any() or (parts >= 1.0).any() or (seconds[usable] % 1.0 != 0.0).any():
        return None
    return np.asarray(seconds - seconds[usable][0] + fractions * part)
