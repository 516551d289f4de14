"""How columns of a table are to be read: which column is which channel, with which sign, in which unit.

The options ``--columns`` and ``--units`` are an interpretation, and so is each hypothesis about a table
(`tirefmu.measurements.checks.columns`): what a message advises is what an option does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..boundary.errors import DataError
from ..numerics.arrays import FloatArray
from ..symbolic.channels import CHANNELS, channel
from .recording import Recording
from .units import Unit, to_si, unit_of

#: The source of a channel that is not read.
NOT_READ = "none"


@dataclass(frozen=True)
class Interpretation:
    """Columns and units that replace those of a table.

    Raises `UnknownName` if a channel or a unit does not exist. Raises `DataError` if a unit is one of another quantity.

    - `columns`: by channel, the column that has it: a header with or without unit, or a channel. A leading minus
      reverses the sign: ``{"alpha": "-SA"}``. ``none``: the column is not read.
    - `units`: by channel, the unit of its numbers in the file: ``{"Fz": "lbf"}``.

    >>> import pandas as pd
    >>> table = pd.DataFrame({"alpha": [0.1], "Fz": [100.0], "Fy": [900.0]})
    >>> read = Interpretation({"alpha": "-alpha"}, {"Fz": "lbf"}).applied(Recording(table, "iso", "a.csv"))
    >>> read.table.round(1).iloc[0].to_dict()
    {'alpha': -0.1, 'Fz': 444.8, 'Fy': 900.0}
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.columns:
            channel(name)
        for name, unit in self.units.items():
            _unit(name, unit)

    def __bool__(self) -> bool:
        """Return whether it changes anything."""
        return bool(self.columns or self.units)

    def applied(self, recording: Recording) -> Recording:
        """Return a recording in SI units read in this way; its columns name channels.

        Channels with a unit, or named as themselves (``alpha=alpha``), are those that the user asserts: no other
        reading of them is suggested (``about["asserted"]``). Raises `DataError` if a channel that is the
        source of another one is missing.
        """
        table, about = recording.table.copy(), dict(recording.about)
        for name, text in self.columns.items():
            source = text.removeprefix("-")
            if source == NOT_READ:
                table = table.drop(columns=name, errors="ignore")
                continue
            if source not in recording.table:
                raise DataError(f"{recording.source}: no column {source!r} ({name})")
            values = recording.table[source].to_numpy(dtype=np.float64)
            table[name] = -values if text.startswith("-") else values
            about[f"unit of {name}"] = recording.about.get(f"unit of {source}", "")
        for name, unit in self.units.items():
            if name not in table:
                raise DataError(f"{recording.source}: no column {name!r}, whose unit is given as {unit}")
            table[name] = in_unit(table[name].to_numpy(dtype=np.float64), name, about.get(f"unit of {name}", ""), unit)
            about[f"unit of {name}"] = unit
        stated = [name for name, text in self.columns.items() if text == name]
        about["asserted"] = " ".join(dict.fromkeys([*about.get("asserted", "").split(), *stated, *self.units]))
        declared = dict.fromkeys([*about.get("declared", "").split(), *self.units])
        return replace(recording, table=table, about={**about, "declared": " ".join(declared)})

    def __str__(self) -> str:
        """Return the options of a command."""
        parts = [("--columns", self.columns), ("--units", self.units)]
        return " ".join(
            f"{option} {','.join(f'{name}={value}' for name, value in values.items())}"
            for option, values in parts
            if values
        )


def in_unit(values: FloatArray, name: str, read_as: str, unit: str) -> FloatArray:
    """Return the SI values of a channel whose numbers were read in one unit and are in another one.

    `read_as`: the unit that the file declares; empty for SI.
    """
    before = _unit(name, read_as) if read_as else Unit(CHANNELS[name].quantity)
    return to_si((values - before.offset) / before.factor, unit, CHANNELS[name].quantity)


def _unit(name: str, spelling: str) -> Unit:
    return unit_of(spelling, channel(name).quantity)
