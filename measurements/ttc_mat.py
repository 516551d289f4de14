"""Bench files of the FSAE Tire Test Consortium (Calspan), MATLAB form."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from tirefmu.symbolic.errors import DataError, TirefmuError, nearest

from .channels import CHANNELS, OUTPUTS, Channel
from .columns import check_finite
from .recording import Recording
from .units import to_si

#: SL, the slip that is zero where FX is, gives kappa; SR never does. N is unusable in many runs, and ignored.
MANDATORY = ("ET", "SL", "SA", "IA", "FZ")
_SI = {
    "time": "sec", "ratio": "none", "angle": "deg", "force": "N", "pressure": "kPa", "speed": "kph",
    "temperature": "deg C", "moment": "N-m",
}  # fmt: skip
_USCS = _SI | {"force": "lb", "pressure": "psi", "speed": "mph", "temperature": "deg F", "moment": "lb-ft"}


def read_ttc_mat(path: Path, signs: str) -> Recording:
    """Read a ``.mat`` file of the FSAE TTC.

    Units are those of its ``channel`` table. Older files have none: SI is assumed then, or USCS where the
    file's name says so (``A1464run30``), and ``about`` tells. Fields that are known to be unreliable (RUN of
    the wrong length, an empty tireid) are not needed.

    Parameters
    ----------
    path : pathlib.Path
    signs : str
        The convention of the file; Calspan writes sae.

    Returns
    -------
    Recording
        Channels ``t kappa alpha gamma Fz p V T Fx Fy Mz Mx My`` as far as they are there.

    Raises
    ------
    DataError
        If the file is no MATLAB file, a mandatory channel or every output is missing, lengths differ, a unit
        is not known, or an input holds NaN.
    """
    source = str(path)
    fields = _load(path)
    vectors = {
        name.casefold(): np.ravel(value).astype(np.float64)
        for name, value in fields.items()
        if isinstance(value, np.ndarray) and value.dtype.kind in "fiu" and value.size == max(value.shape, default=1)
    }
    _check_present(vectors, list(fields), source)
    units, about = _units(path, fields)
    columns: dict[str, np.ndarray] = {}
    for card in CHANNELS.values():
        bench = next((name for name in card.bench if name.casefold() in vectors), None)
        if bench is not None:
            columns[card.name] = _channel(card, bench, vectors, units, source)
    for key in ("tireid", "testid", "source"):
        about["credit" if key == "source" else key] = _text(fields.get(key))
    return Recording(pd.DataFrame(columns), signs, path.name, about)


def _load(path: Path) -> Mapping[str, Any]:
    try:
        loaded: dict[str, Any] = loadmat(path, struct_as_record=False)
    except NotImplementedError:
        raise DataError(f"{path}: MATLAB 7.3 (HDF5) files are not read: save with -v7") from None
    except (ValueError, TypeError, EOFError, IndexError, KeyError, MatReadError) as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise DataError(f"{path}: cannot be read as a MATLAB file: {reason}") from None
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def _check_present(vectors: Mapping[str, np.ndarray], fields: list[str], source: str) -> None:
    by_bench_name = {name: card for card in CHANNELS.values() for name in card.bench}
    for name in MANDATORY:
        if name.casefold() not in vectors:
            hint = " (SR is another slip, not zero where FX is)" if name == "SL" and "SR" in fields else ""
            # A channel that was found as itself is no misspelling of the missing one.
            others = [field for field in fields if field not in by_bench_name and field != "SR"]
            raise DataError(f"{source}: no channel {name} ({by_bench_name[name].name}){hint or nearest(name, others)}")
    if not any(name.casefold() in vectors for output in OUTPUTS for name in CHANNELS[output].bench):
        raise DataError(f"{source}: no channel FX, FY, MZ, MX or MY: nothing was measured")


def _units(path: Path, fields: Mapping[str, Any]) -> tuple[dict[str, str], dict[str, str]]:
    """Units by folded bench name, and what to tell about them."""
    units: dict[str, str] = {}
    for cell in np.ravel(fields.get("channel", np.empty(0))):
        names, spelled = (np.ravel(getattr(cell, part, np.empty(0))) for part in ("name", "units"))
        units |= {_text(name).casefold(): _text(unit) for name, unit in zip(names, spelled, strict=False)}
    if units:
        declared = " ".join(card.name for card in CHANNELS.values() if {b.casefold() for b in card.bench} & set(units))
        return units, {"units": "declared in the file", "declared": declared}
    uscs = re.match(r"[Aa]\d", path.name) is not None
    assumed = _USCS if uscs else _SI
    units = {name.casefold(): assumed[card.quantity] for card in CHANNELS.values() for name in card.bench}
    reason = "the file's name begins with A" if uscs else "the file declares none"
    return units, {"units": f"assumed {'USCS' if uscs else 'SI'}: {reason}", "declared": ""}


def _channel(
    card: Channel, bench: str, vectors: Mapping[str, np.ndarray], units: Mapping[str, str], source: str
) -> np.ndarray:
    values, rows = vectors[bench.casefold()], len(vectors["et"])
    if len(values) != rows:
        raise DataError(f"{source}: channel {bench} has {len(values)} rows, ET has {rows}")
    if not rows:
        raise DataError(f"{source}: no rows")
    check_finite(values, card.name, source, lambda row: f"row {row + 1}: {bench}")
    try:
        return to_si(values, units.get(bench.casefold(), _SI[card.quantity]), card.quantity)
    except TirefmuError as error:
        raise DataError(f"{source}: channel {bench}: {error}") from None


def _text(value: Any) -> str:
    """Return the text in MATLAB's nested cells; empty where there is none."""
    while isinstance(value, np.ndarray):
        if not value.size:
            return ""
        value = value.flat[0]
    return "" if value is None else str(value)
