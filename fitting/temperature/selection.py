"""The part of a fit that concerns temperatures: the recorded column, its recordings, the fit of the forces alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError, nearest, no_single_text
from ...measurements import Recording
from ...numerics.arrays import FloatArray
from ...symbolic.channels import channel
from ..options import FitOptions
from .heat_balance import EFFECT, ZERO_CELSIUS

#: The recorded temperature of the tread by default.
RECORDED = "T"
#: Temperatures of the surroundings, K; how much warmer the coldest tread can be, K, and how much colder.
AROUND, TOO_WARM, COLDER = ("T_ambient", "T_road"), 60.0, 5.0


def temperature_column(options: FitOptions) -> str:
    """Return the recorded temperature to which a fit is requested, or ''."""
    return options.temperature or (RECORDED if EFFECT in (options.effects or ()) else "")


def forces_alone(options: FitOptions) -> FitOptions:
    """Return the options of the fit of the forces, in which effects of temperature have the recorded one."""
    return replace(options, **settings_of_forces(vars(options)))


def settings_of_forces(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same for options by name.

    >>> settings_of_forces({"effects": ["load_friction", "temperature"], "loss": "huber"})
    {'effects': ['load_friction'], 'loss': 'huber', 'temperature': None}
    """
    effects = settings.get("effects")
    no_single_text("effects", effects)
    chosen = {} if effects is None else {"effects": [name for name in effects if name != EFFECT]}
    return {**settings, **chosen, "temperature": None}


def with_temperature(recordings: Sequence[Recording], column: str) -> list[Recording]:
    """Return the recordings with time and a recorded temperature; raise `DataError` if there are none."""
    chosen = [recording for recording in recordings if {"t", column} <= {*recording.table}]
    for recording in chosen or recordings:
        check_temperature(recording, column)
    return chosen


def check_temperature(recording: Recording, column: str) -> None:
    """Raise `DataError` if a recording lacks time or temperature, or has temperatures that no tread has."""
    table = recording.table
    for name in ("t", column):
        if name not in table:
            near = nearest(name, list(map(str, table)))
            raise DataError(f"{recording.source}: a fit of the temperature needs the column {name!r}{near}")
    values = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=np.float64)
    if not np.isfinite(values).any():
        raise DataError(f"{recording.source}: column {column!r} has no number")
    low, high = channel(RECORDED).limits
    bad = np.flatnonzero((values < low) | (values > high))
    if bad.size:
        what = f"row {bad[0] + 1}: {column} is {values[bad[0]]:g}, but a tread has {low:g} to {high:g} deg C"
        raise DataError(f"{recording.source}: {what}: declare another unit")
    check_unit(recording, column, values)


def check_unit(recording: Recording, column: str, values: FloatArray) -> None:
    """Raise `DataError` if temperatures are probably in deg F: the coldest tread is much warmer than its surroundings.

    A tread that has cooled has the temperature of the air or of the road; 20 deg C are 68 deg F.
    """
    surroundings = [recording.table[name].to_numpy(dtype=np.float64) for name in AROUND if name in recording.table]
    if not surroundings:
        return
    around = float(np.nanmedian(surroundings[0])) - ZERO_CELSIUS
    coldest, in_celsius = float(np.nanmin(values)), (float(np.nanmin(values)) - 32.0) / 1.8
    if coldest - around > TOO_WARM and in_celsius >= around - COLDER:
        raise DataError(
            f"{recording.source}: {column} is never below {coldest:.0f} deg C in surroundings of {around:.0f} deg C: "
            f"in deg F? declare it: '{column} [deg F]'"
        )
