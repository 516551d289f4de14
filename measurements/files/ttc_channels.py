"""Channels and units of FSAE Tire Test Consortium (Calspan) files, common to all their formats."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, TirefmuError, nearest
from ...numerics.arrays import FloatArray
from ...symbolic.channels import CHANNELS, OUTPUTS
from ..checks.columns.radii import deflection, median_radius
from ..column_names import intended_channel
from ..thresholds import FREE_ROLLING_FORCE, LOWEST_KPA
from ..units import POUND, to_si, unit_named
from .columns.cells import numbers
from .columns.content import Column, Content, name_and_unit

if TYPE_CHECKING:
    from .columns.resolution import ColumnChoice

#: kappa is read from SL, the slip that is zero at zero FX, and never from SR. N is unusable in many runs and ignored.
MANDATORY = ("ET", "SA", "IA", "FZ")
_SI = {
    "time": "sec", "angle": "deg", "force": "N", "pressure": "kPa", "speed": "kph",
    "temperature": "deg C", "absolute temperature": "deg C", "moment": "N-m",
}  # fmt: skip
_USCS = _SI | {
    "force": "lb",
    "pressure": "psi",
    "speed": "mph",
    "temperature": "deg F",
    "absolute temperature": "deg F",
    "moment": "lb-ft",
}
_BENCH_NAMES = {name: channel for channel in CHANNELS.values() for name in channel.bench_names}
#: What shows the units of a file that declares none: channel, largest median in USCS, smallest in SI, and why. The
#: loaded radius of these tires is 7 to 12 in (18 to 30 cm); the air is at 60 to 100 deg F (15 to 38 deg C); the belt
#: runs at 25 mph (40 km/h) or slower.
_EVIDENCE = (
    ("p", LOWEST_KPA, LOWEST_KPA, "too small for kPa", "too large for psi"),
    ("rl", 13.0, 17.0, "a radius in inches", "a radius in cm"),
)


def as_bench_table(content: Content, name: str) -> Content:
    """Return the content of a table that has the columns of an FSAE TTC file with their meaning; others unchanged.

    Such a table has ET, SA, IA and FZ, and none of alpha, gamma and Fz. `name`: of the file.
    """
    names = {name_and_unit(column.header)[0] for column in content.columns}
    if content.format or not set(MANDATORY) <= names or {"alpha", "gamma", "Fz"} & names:
        return content
    about = {"tireid": "", "testid": "", "credit": ""}
    return bench_content(replace(content, about=about | dict(content.about), signs=content.signs or "sae"), name)


def bench_content(content: Content, name: str) -> Content:
    """Return the content of a bench file with channels for its names, in any case, and units for those that lack one.

    Without any declared unit `assumed_units` are used. `name`: of the file.
    """
    folded = {name_and_unit(column.header)[0].casefold(): column for column in reversed(content.columns)}
    meant = {}
    for channel in CHANNELS.values():
        first = next((bench.casefold() for bench in channel.bench_names if bench.casefold() in folded), None)
        if first is not None:
            meant[id(folded[first])] = channel.name
    columns = tuple(
        replace(column, meant=meant.get(id(column), ""), place=f"channel {name_and_unit(column.header)[0]}")
        for column in content.columns
    )
    assumed: Mapping[str, str]
    if any(column.declared_unit for column in columns if column.meant):
        assumed, reason = _SI, "declared in the file"
    else:
        assumed, reason = assumed_units(name, folded)
    units = {channel.name: channel.bench_unit or assumed[channel.quantity] for channel in _BENCH_NAMES.values()}
    return replace(content, columns=columns, format="ttc", units=units, about={**content.about, "units": reason})


def assumed_units(name: str, columns: Mapping[str, Column]) -> tuple[Mapping[str, str], str]:
    """Return the units by quantity of a file that declares none, and the reason for them.

    `name`: names like ``A1464run30`` mean US customary units, ``B1464run30`` SI. `columns`: by name in lower case. A
    pressure or a loaded radius that is possible in one system only decides.

    >>> assumed_units("A1464run30.mat", {})[1]
    "assumed USCS: the file's name begins with A"
    >>> assumed_units("run.mat", {"p": Column("P", np.full(9, 12.0))})[1]
    'assumed USCS: the file declares none, and P is about 12, too small for kPa'
    """
    letter = re.match(r"[AaBb](?=\d)", name)
    if letter is not None:
        uscs, reason = letter[0] in "Aa", f"the file's name begins with {letter[0]}"
    else:
        uscs, reason = False, "the file declares none"
        for channel, largest, smallest, small, large in _EVIDENCE:
            median = _median(columns.get(channel))
            if 0.0 < median < largest or median >= smallest:
                uscs = median < largest
                evidence = f"{channel.upper()} is about {median:.3g}, {small if uscs else large}"
                reason += f", and {evidence}" if uscs or channel != "p" else ""
                break
    return _USCS if uscs else _SI, f"assumed {'USCS' if uscs else 'SI'}: {reason}"


def _median(column: Column | None) -> float:
    try:
        values = np.empty(0) if column is None else numbers(column.cells, "", "", str)[0]
    except DataError:  # only a column that is used has to be readable
        return np.nan
    return float(np.nanmedian(values)) if np.isfinite(values).any() else np.nan


def has_bench_names(names: Collection[str]) -> bool:
    """Return whether names are those of channels of a bench file, such as ET and SA in any case."""
    folded = {name.casefold() for name in names}
    return len(folded & {name.casefold() for name in MANDATORY}) >= 2


def missing_channel(content: Content, chosen: Collection[str], source: str) -> None:
    """Raise `DataError` if a mandatory channel or every output is missing, or a name resembles a missing channel."""
    fields = [name_and_unit(column.header)[0] for column in content.columns]
    for name in MANDATORY:
        if _BENCH_NAMES[name].name not in chosen:
            # A channel that was recognized is not a misspelling of the missing one.
            others = [field for field in fields if field.upper() not in _BENCH_NAMES]
            raise DataError(f"{source}: no channel {name} ({_BENCH_NAMES[name].name}){nearest(name, others)}")
    if not set(chosen) & set(OUTPUTS):
        raise DataError(f"{source}: no channel FX, FY, MZ, MX or MY: nothing was measured")
    for field in fields:
        intended = None if field.upper() in _BENCH_NAMES else intended_channel(field)
        if intended and intended not in chosen and CHANNELS[intended].bench_names:
            bench_names = ", ".join(sorted(_BENCH_NAMES))
            hint = f"did you mean {CHANNELS[intended].bench_names[0]}? Channels of one are {bench_names}"
            raise DataError(f"{source}: channel {field!r} is not one of a bench file: {hint}")


def completed(
    content: Content, chosen: Mapping[str, ColumnChoice], table: pd.DataFrame, source: str
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return the table with kappa = 0 for a file without SL, such as a warm-up run, and metadata: why, and the radii.

    Raises `DataError` if FX is that of a driven wheel.
    """
    about = _radii(content.columns, chosen, table)
    if "kappa" in table:
        return table, about
    load = table["Fz"].abs().to_numpy()
    if "Fx" in table and np.nanquantile(np.abs(table["Fx"]), 0.99) > FREE_ROLLING_FORCE * np.nanmedian(load):
        slip = any(column.header.upper() == "SR" for column in content.columns)
        hint = " (SR is another slip, not zero at zero FX)" if slip else ""
        raise DataError(f"{source}: no channel SL (kappa), and FX is that of a driven wheel{hint}")
    about["kappa"] = "no channel SL: FX stays near 0, the wheel rolls freely, kappa is 0"
    table = table.assign(kappa=np.zeros(len(table)))
    return table[[name for name in CHANNELS if name in table]], about


def _radii(columns: Sequence[Column], chosen: Mapping[str, ColumnChoice], table: pd.DataFrame) -> dict[str, str]:
    """Return the medians of the loaded radius and of speed over wheel speed, m; what is unusable is missing.

    With the radius at zero load and the vertical stiffness, where the loaded radius falls over a varying load.
    """
    by_name = {name_and_unit(column.header)[0].casefold(): column for column in columns}
    radii: dict[str, FloatArray] = {}
    try:
        if "rl" in by_name:
            length = "in" if unit_named(chosen["Fz"].unit).factor == POUND else "cm"
            radii["loaded radius"] = to_si(_numbers(by_name["rl"]), by_name["rl"].declared_unit or length, "length")
        if "V" in table and "n" in by_name and len(by_name["n"].cells) == len(table):
            rotation = to_si(_numbers(by_name["n"]), by_name["n"].declared_unit or "rpm", "rotation")
            with np.errstate(divide="ignore", invalid="ignore"):
                radii["wheel speed"] = np.abs(table["V"].to_numpy() / rotation)
    except TirefmuError:  # in a unit that is not known: no channel of the contract depends on it
        return {}
    shown = {name: text for name, values in radii.items() if (text := median_radius(values)) is not None}
    if "Fz" in table and len(radii.get("loaded radius", ())) == len(table):
        shown |= deflection(table["Fz"].to_numpy(), radii["loaded radius"])
    return shown


def _numbers(column: Column) -> FloatArray:
    return numbers(column.cells, "", "", str)[0]
