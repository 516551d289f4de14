"""Results of Modelica tools (Dymola, OpenModelica): a ``.mat`` file of names, descriptions and two tables of values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..columns.content import Column, Content, is_unit

#: Variables of such a file.
PARTS = frozenset(("Aclass", "name", "description", "dataInfo", "data_1", "data_2"))


def is_result(fields: Mapping[str, Any]) -> bool:
    """Return whether the variables of a ``.mat`` file are those of a result of a Modelica tool."""
    return fields.keys() >= PARTS


def result_content(fields: Mapping[str, Any]) -> Content:
    """Return the variables that change; their units are behind their descriptions.

    `fields`: the variables of the file. Alias variables are columns of their own, with their sign. Parameters, which
    are in a table of two rows, are not read. Raises `IndexError` or `ValueError` if names and tables do not fit.
    """
    info, table = np.atleast_2d(fields["dataInfo"]), np.atleast_2d(fields["data_2"])
    names, descriptions = _texts(fields["name"]), _texts(fields["description"])
    if _texts(fields["Aclass"])[3:4] == ["binTrans"]:
        info, table = info.T, table.T
        names, descriptions = (_texts(fields[part], len(info)) for part in ("name", "description"))
    columns = []
    for name, description, (matrix, place, *_) in zip(names, descriptions, info, strict=True):
        if matrix != 1:  # 0 is the time, 1 the table of parameters
            unit = description.rpartition("[")[2].partition("]")[0].partition("|")[0]
            values = table[:, abs(int(place)) - 1]
            values = -values if place < 0 else values
            columns.append(Column(name, values, unit if is_unit(unit) else "", meant="t" if matrix == 0 else ""))
    parameters = len(names) - len(columns)
    return Content(tuple(columns), ignored=(f"{parameters} parameters",) if parameters else ())


def _texts(rows: Any, columns: int = 0) -> list[str]:
    """Return the texts of a matrix of characters; `columns`: their number if the matrix is transposed."""
    lines = [str(row) for row in np.ravel(rows)]
    if columns:
        lines = ["".join(letters) for letters in zip(*(line.ljust(columns) for line in lines), strict=True)]
    return [line.rstrip(" \0") for line in lines]
