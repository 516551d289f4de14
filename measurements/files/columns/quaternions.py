"""Headings of quaternions in four columns, as robots and inertial sensors log them: ``orientation.w``, ``q_x``."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ....boundary.errors import DataError
from ....numerics.arrays import FloatArray
from .cells import numbers
from .content import Column, Content, name_and_unit

_PART = re.compile(r"(?P<stem>.+?)[\W_]*(?P<part>[wxyz])\W?", re.IGNORECASE)
#: Distance of the squared norm of a rotation from 1, and share of rows that are rotations: a sensor begins without one.
NORM, SHARE = 0.01, 0.5


def with_headings(content: Content) -> Content:
    """Return the content with a column ``STEM.heading``, in rad to the left about z, behind each quaternion.

    Rows without a rotation have none. A rotation that never changes is that of a sensor that knows none.
    """
    parts: dict[tuple[str, str], dict[str, Column]] = {}
    for column in content.columns:
        if match := _PART.fullmatch(name_and_unit(column.header)[0]):
            parts.setdefault((column.group, match["stem"]), {}).setdefault(match["part"].casefold(), column)
    columns = list(content.columns)
    for (_, stem), quaternion in parts.items():
        if len(quaternion) == len("wxyz") and (heading := _heading(quaternion)) is not None:
            last = max(columns.index(column) for column in quaternion.values())
            columns.insert(last + 1, replace(columns[last], header=f"{stem}.heading", cells=heading, unit="rad"))
    return replace(content, columns=tuple(columns))


def _heading(quaternion: dict[str, Column]) -> FloatArray | None:
    """Return the angles of rotation about z; None if the columns are not of a rotation that changes."""
    try:
        w, x, y, z = (numbers(quaternion[part].cells, "", "", str)[0] for part in "wxyz")
    except DataError:
        return None
    if len({len(w), len(x), len(y), len(z)}) > 1:
        return None
    with np.errstate(all="ignore"):
        rotation = np.abs(w * w + x * x + y * y + z * z - 1.0) < NORM
        heading = np.where(rotation, np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)), np.nan)
    if not rotation.any() or np.mean(rotation) < SHARE or np.ptp(heading[rotation]) == 0.0:
        return None
    return np.asarray(heading)
