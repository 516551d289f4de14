"""What bench files of the FSAE Tire Test Consortium (Calspan) have in common, whatever their form."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tirefmu.symbolic.errors import DataError, TirefmuError, nearest

from ..channels import CHANNELS, OUTPUTS, Channel
from ..recording import Recording
from ..units import to_si
from .columns import check_finite

#: SL, the slip that is zero where FX is, gives kappa; SR never does. N is unusable in many runs, and ignored.
MANDATORY = ("ET", "SA", "IA", "FZ")
_SI = {
    "time": "sec", "ratio": "none", "angle": "deg", "force": "N", "pressure": "kPa", "speed": "kph",
    "temperature": "deg C", "moment": "N-m",
}  # fmt: skip
_USCS = _SI | {"force": "lb", "pressure": "psi", "speed": "mph", "temperature": "deg F", "moment": "lb-ft"}
_LOWEST_KPA = 30.0  # no tire of the consortium runs below, and none above 30 psi
_FREE_ROLLING = 0.15  # of the load: rolling resistance and the side force's share stay below, a driven wheel's FX not
_BENCH_NAMES = {name: card for card in CHANNELS.values() for name in card.bench}


def bench_recording(
    path: Path,
    vectors: Mapping[str, NDArray[np.float64]],
    units: Mapping[str, str],
    signs: str,
    about: Mapping[str, str],
    place: Callable[[int], str],
) -> Recording:
    """Return the recording that named channels of a bench file make.

    Parameters
    ----------
    path : pathlib.Path
    vectors : mapping of str to ndarray, shape (n,)
        By the name in the file; case does not matter.
    units : mapping of str to str
        As far as the file declares them, by name; where it declares none, `assumed_units` are taken.
    signs : str
        The convention of the file.
    about : mapping of str to str
    place : callable
        From a row's number, counted from 0, to "line 12" or "row 12".

    Returns
    -------
    Recording
        Channels ``t kappa alpha gamma Fz p V T Fx Fy Mz Mx My`` as far as they are there.

    Raises
    ------
    DataError
        If a mandatory channel or every output is missing, lengths differ, a unit is not known, or an input
        holds NaN.
    """
    source = str(path)
    folded = {name.casefold(): values for name, values in vectors.items()}
    _check_present(folded, list(vectors), source)
    spelled = {name.casefold(): unit for name, unit in units.items()}
    known = dict(about)
    if spelled:
        declared = [card.name for card in CHANNELS.values() if {b.casefold() for b in card.bench} & set(spelled)]
        known |= {"units": "declared in the file", "declared": " ".join(declared)}
    else:
        spelled, reason = assumed_units(path, folded)
        known |= {"units": reason, "declared": ""}
    columns: dict[str, NDArray[np.float64]] = {}
    for card in CHANNELS.values():
        bench = next((name for name in card.bench if name.casefold() in folded), None)
        if bench is not None:
            columns[card.name] = _channel(card, bench, folded, spelled, source, place)
    if "kappa" not in columns:
        columns["kappa"] = _free_rolling(columns, vectors, source)
        known["kappa"] = "no channel SL: FX stays near 0, the wheel rolls freely, kappa is 0"
    ordered = {name: columns[name] for name in CHANNELS if name in columns}
    return Recording(pd.DataFrame(ordered), signs, path.name, known)


def assumed_units(path: Path, vectors: Mapping[str, NDArray[np.float64]]) -> tuple[dict[str, str], str]:
    """Return the units of a file that declares none, and why these.

    Parameters
    ----------
    path : pathlib.Path
        Names like ``A1464run30`` mean US customary units, ``B1464run30`` SI.
    vectors : mapping of str to ndarray
        By folded name: a pressure that cannot be kPa is psi.

    Returns
    -------
    units : dict of str to str
        By folded name.
    reason : str

    Examples
    --------
    >>> assumed_units(Path("A1464run30.mat"), {})[1]
    "assumed USCS: the file's name begins with A"
    >>> assumed_units(Path("run.mat"), {"p": np.full(9, 12.0)})[1]
    'assumed USCS: the file declares none, and P is about 12, which is no kPa'
    """
    pressure = vectors.get("p", np.empty(0))
    middle = float(np.nanmedian(pressure)) if np.isfinite(pressure).any() else np.inf
    letter = re.match(r"[AaBb](?=\d)", path.name)
    if letter is not None:
        uscs, reason = letter[0] in "Aa", f"the file's name begins with {letter[0]}"
    elif 0.0 < middle < _LOWEST_KPA:
        uscs, reason = True, f"the file declares none, and P is about {middle:.3g}, which is no kPa"
    else:
        uscs, reason = False, "the file declares none"
    assumed = _USCS if uscs else _SI
    units = {name.casefold(): assumed[card.quantity] for name, card in _BENCH_NAMES.items()}
    return units, f"assumed {'USCS' if uscs else 'SI'}: {reason}"


def has_bench_names(names: Collection[str]) -> bool:
    """Return whether names look like the channels of a bench file.

    Parameters
    ----------
    names : collection of str

    Returns
    -------
    bool

    Examples
    --------
    >>> has_bench_names(["et", "sa", "fz", "fy", "lap"]), has_bench_names(["t", "alpha"])
    (True, False)
    """
    folded = {name.casefold() for name in names}
    return len(folded & {name.casefold() for name in MANDATORY}) >= 2


def _check_present(folded: Collection[str], fields: list[str], source: str) -> None:
    for name in MANDATORY:
        if name.casefold() not in folded:
            # A channel that was found as itself is no misspelling of the missing one.
            others = [field for field in fields if field.upper() not in _BENCH_NAMES]
            raise DataError(f"{source}: no channel {name} ({_BENCH_NAMES[name].name}){nearest(name, others)}")
    if not any(name.casefold() in folded for output in OUTPUTS for name in CHANNELS[output].bench):
        raise DataError(f"{source}: no channel FX, FY, MZ, MX or MY: nothing was measured")


def _channel(
    card: Channel,
    bench: str,
    folded: Mapping[str, NDArray[np.float64]],
    units: Mapping[str, str],
    source: str,
    place: Callable[[int], str],
) -> NDArray[np.float64]:
    values, rows = folded[bench.casefold()], len(folded["et"])
    if len(values) != rows:
        raise DataError(f"{source}: channel {bench} has {len(values)} rows, ET has {rows}")
    if not rows:
        raise DataError(f"{source}: no rows")
    check_finite(values, card.name, source, lambda row: f"{place(row)}: {bench}")
    try:
        return to_si(values, units.get(bench.casefold(), _SI[card.quantity]), card.quantity)
    except TirefmuError as error:
        raise DataError(f"{source}: channel {bench}: {error}") from None


def _free_rolling(
    columns: Mapping[str, NDArray[np.float64]], vectors: Collection[str], source: str
) -> NDArray[np.float64]:
    """Return kappa of a file without SL, as warm-up runs are: 0, if no FX says that the wheel was driven."""
    load = np.abs(columns["Fz"])
    driven = "Fx" in columns and np.nanquantile(np.abs(columns["Fx"]), 0.99) > _FREE_ROLLING * np.median(load)
    if driven:
        hint = " (SR is another slip, not zero where FX is)" if "SR" in {name.upper() for name in vectors} else ""
        raise DataError(f"{source}: no channel SL (kappa), and FX says that the wheel is driven{hint}")
    return np.zeros(len(load))
