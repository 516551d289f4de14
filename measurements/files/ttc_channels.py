"""Channels and units of FSAE Tire Test Consortium (Calspan) files, common to all their formats."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, TirefmuError, nearest
from ...numerics.arrays import FloatArray
from ..channels import CHANNELS, OUTPUTS, Channel
from ..checks.columns.radii import deflection, median_radius
from ..column_names import intended_channel
from ..interpretation import Interpretation
from ..recording import Recording
from ..thresholds import FREE_ROLLING_FORCE, LOWEST_KPA
from ..units import POUND, to_si, unit_named
from .columns import check_finite, in_si

#: kappa is read from SL, the slip that is zero at zero FX, and never from SR. N is unusable in many runs and ignored.
MANDATORY = ("ET", "SA", "IA", "FZ")
_SI = {
    "time": "sec", "ratio": "none", "angle": "deg", "force": "N", "pressure": "kPa", "speed": "kph",
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


def bench_recording(
    path: Path,
    vectors: Mapping[str, FloatArray],
    units: Mapping[str, str],
    signs: str,
    about: Mapping[str, str],
    location: Callable[[int], str],
    interpretation: Interpretation,
) -> Recording:
    """Return the recording of the channels of a bench file.

    `vectors`, shape (n,): by the name in the file; the case is ignored. `units`: the units that the file declares, by
    name. If there are none, `assumed_units` are used. `location`: as for `channels_in_si`. `interpretation`: names of
    columns that replace those of the format. Raises `DataError` if a
    mandatory channel or every output is missing, a name resembles a missing channel, lengths differ, a unit is unknown,
    or too many values of an input are NaN.
    """
    source = str(path)
    folded = {name.casefold(): values for name, values in vectors.items()}
    replaced = {channel: name for name, channel in interpretation.renamed.items()}
    for channel_name, name in replaced.items():
        if name.casefold() not in folded:
            raise DataError(f"{source}: no channel {name} ({channel_name}){nearest(name, vectors)}")
    _check_present(folded, list(vectors), source, replaced)
    by_name = {name.casefold(): unit for name, unit in units.items()}
    metadata = dict(about)
    if by_name:
        declared = [_BENCH_NAMES[name].name for name in _BENCH_NAMES if name.casefold() in by_name]
        metadata |= {"units": "declared in the file", "declared": " ".join(declared)}
    else:
        by_name, reason = assumed_units(path, folded)
        metadata |= {"units": reason, "declared": ""}
    columns: dict[str, FloatArray] = {}
    for channel in CHANNELS.values():
        names = (replaced[channel.name],) if channel.name in replaced else channel.bench_names
        bench_name = next((name for name in names if name.casefold() in folded), None)
        if bench_name is not None:
            unit = by_name.get(bench_name.casefold(), _SI[channel.quantity])
            columns[channel.name] = _channel(channel, bench_name, folded, unit, source, location)
            metadata[f"unit of {channel.name}"] = unit
    if "kappa" not in columns:
        columns["kappa"] = _free_rolling(columns, vectors, source)
        metadata["kappa"] = "no channel SL: FX stays near 0, the wheel rolls freely, kappa is 0"
    metadata |= _radii(folded, by_name, columns.get("V"), columns.get("Fz"))
    ordered = {name: columns[name] for name in CHANNELS if name in columns}
    return Recording(pd.DataFrame(ordered), signs, path.name, metadata)


def _radii(
    folded: Mapping[str, FloatArray], units: Mapping[str, str], speed: FloatArray | None, load: FloatArray | None
) -> dict[str, str]:
    """Return the medians of the loaded radius and of speed over wheel speed, m; what is unusable is missing.

    With the radius at zero load and the vertical stiffness, where the loaded radius falls over a varying load.
    """
    radii: dict[str, FloatArray] = {}
    try:
        if "rl" in folded:
            length = "in" if unit_named(units.get("fz", "N")).factor == POUND else "cm"
            radii["loaded radius"] = to_si(folded["rl"], units.get("rl", length), "length")
        if speed is not None and len(folded.get("n", ())) == len(speed):
            rotation = to_si(folded["n"], units.get("n", "rpm"), "rotation")
            with np.errstate(divide="ignore", invalid="ignore"):
                radii["wheel speed"] = np.abs(speed / rotation)
    except TirefmuError:  # in a unit that is not known: no channel of the contract depends on it
        return {}
    shown = {name: text for name, values in radii.items() if (text := median_radius(values)) is not None}
    if load is not None and len(radii.get("loaded radius", ())) == len(load):
        shown |= deflection(load, radii["loaded radius"])
    return shown


def assumed_units(path: Path, vectors: Mapping[str, FloatArray]) -> tuple[dict[str, str], str]:
    """Return the units of a file that declares none, and the reason for them.

    `path`: names like ``A1464run30`` mean US customary units, ``B1464run30`` SI. `vectors`: by name in lower case. A
    pressure that is too small for kPa is in psi. Returns `units`: by name in lower case.

    >>> assumed_units(Path("A1464run30.mat"), {})[1]
    "assumed USCS: the file's name begins with A"
    >>> assumed_units(Path("run.mat"), {"p": np.full(9, 12.0)})[1]
    'assumed USCS: the file declares none, and P is about 12, too small for kPa'
    """
    pressure = vectors.get("p", np.empty(0))
    median = float(np.nanmedian(pressure)) if np.isfinite(pressure).any() else np.inf
    letter = re.match(r"[AaBb](?=\d)", path.name)
    if letter is not None:
        uscs, reason = letter[0] in "Aa", f"the file's name begins with {letter[0]}"
    elif 0.0 < median < LOWEST_KPA:
        uscs, reason = True, f"the file declares none, and P is about {median:.3g}, too small for kPa"
    else:
        uscs, reason = False, "the file declares none"
    assumed = _USCS if uscs else _SI
    units = {name.casefold(): assumed[channel.quantity] for name, channel in _BENCH_NAMES.items()}
    return units, f"assumed {'USCS' if uscs else 'SI'}: {reason}"


def has_bench_names(names: Collection[str]) -> bool:
    """Return whether names are those of channels of a bench file, such as ET and SA in any case."""
    folded = {name.casefold() for name in names}
    return len(folded & {name.casefold() for name in MANDATORY}) >= 2


def _check_present(folded: Collection[str], fields: list[str], source: str, replaced: Collection[str]) -> None:
    for name in MANDATORY:
        if name.casefold() not in folded and _BENCH_NAMES[name].name not in replaced:
            # A channel that was recognized is not a misspelling of the missing one.
            others = [field for field in fields if field.upper() not in _BENCH_NAMES]
            raise DataError(f"{source}: no channel {name} ({_BENCH_NAMES[name].name}){nearest(name, others)}")
    outputs = (name for output in OUTPUTS for name in CHANNELS[output].bench_names)
    if not (set(replaced) & set(OUTPUTS) or any(name.casefold() in folded for name in outputs)):
        raise DataError(f"{source}: no channel FX, FY, MZ, MX or MY: nothing was measured")
    for field in fields:
        intended = None if field.upper() in _BENCH_NAMES else intended_channel(field)
        names = CHANNELS[intended].bench_names if intended else ()
        if names and intended not in replaced and not any(name.casefold() in folded for name in names):
            hint = f"did you mean {names[0]}? Channels of one are {', '.join(sorted(_BENCH_NAMES))}"
            raise DataError(f"{source}: channel {field!r} is not one of a bench file: {hint}")


def _channel(
    channel: Channel,
    bench_name: str,
    folded: Mapping[str, FloatArray],
    unit: str,
    source: str,
    location: Callable[[int], str],
) -> FloatArray:
    clock = "et" if "et" in folded else bench_name.casefold()
    values, rows = folded[bench_name.casefold()], len(folded[clock])
    if len(values) != rows:
        raise DataError(f"{source}: channel {bench_name} has {len(values)} rows, ET has {rows}")
    if not rows:
        raise DataError(f"{source}: no rows")
    check_finite(values, channel.name, source, lambda row: f"{location(row)}: {bench_name}")
    return in_si(values, unit, channel.quantity, f"{source}: channel {bench_name}")


def _free_rolling(columns: Mapping[str, FloatArray], vectors: Collection[str], source: str) -> FloatArray:
    """Return kappa = 0 for a file without SL, such as a warm-up run, unless FX is that of a driven wheel."""
    load = np.abs(columns["Fz"])
    driven = "Fx" in columns and np.nanquantile(np.abs(columns["Fx"]), 0.99) > FREE_ROLLING_FORCE * np.median(load)
    if driven:
        hint = " (SR is another slip, not zero at zero FX)" if "SR" in {name.upper() for name in vectors} else ""
        raise DataError(f"{source}: no channel SL (kappa), and FX is that of a driven wheel{hint}")
    return np.zeros(len(load))
