"""The inputs of an FMU that follow a table of slips: the slips themselves, the motion of a wheel or of its carrier."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import FmuError
from ...measurements.recording import Recording
from ...tires import Tire
from ...tires.signs import convert_signs
from ...tires.states.transient import lateral_slip

#: Upper limit of rows in a proof; of longer tables, every n-th row of each segment is used.
MAX_ROWS = 2000


def proof_rows(recording: Recording) -> tuple[np.ndarray[Any, np.dtype[np.int64]], list[int]]:
    """Return the rows of a recording that a proof contains, and the index of the first of each segment among them.

    >>> proof_rows(Recording(pd.DataFrame({"alpha": np.zeros(5000), "Fz": 1.0}), "iso", "run"))[0][:3].tolist()
    [0, 3, 6]
    """
    step = -(-len(recording.table) // MAX_ROWS)
    parts = [np.arange(segment.start, segment.stop, step) for segment in recording.segments()]
    return np.concatenate(parts), [0, *np.cumsum([len(part) for part in parts[:-1]]).tolist()]


def stimuli(table: pd.DataFrame, starts: Mapping[str, float], tire: Tire, inputs: str, axes: str) -> pd.DataFrame:
    """Return the inputs of an FMU for each row of a table in ISO signs.

    The wheel rolls on a level road. Its angular speed is (1 + kappa) V over the free radius. The centre of a wheel with
    hub inputs is lower in proportion to the load; its carrier is inclined by gamma. The spin of a wheel with torques is
    free. These inputs only have to cover the operating range: the slips in the FMU differ a little from the table's.

    `starts`: start values of the FMU's inputs. `inputs`, `axes`: as in `export`. Raises `FmuError` if the FMU has no
    input of these names.
    """
    converted = convert_signs(table, "iso", axes)
    given = {str(name): converted[name].to_numpy(dtype=np.float64) for name in converted if name in starts}
    if inputs != "slip":
        given |= _rolling(converted, starts, tire)
    if inputs.startswith("hub"):
        given |= _carrier(converted, starts, tire)
    chosen = {name: given[name] for name in starts if name in given}
    if not chosen:
        raise FmuError(f"the table has no input of the FMU ({', '.join(starts)})")
    return pd.DataFrame(chosen, index=table.index)


def _column(table: pd.DataFrame, name: str, default: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return table[name].to_numpy(dtype=np.float64) if name in table else np.full(len(table), default)


def _rolling(table: pd.DataFrame, starts: Mapping[str, float], tire: Tire) -> dict[str, Any]:
    """Return the velocities of a wheel, as inputs of a wheel and of a hub."""
    V = _column(table, "V", starts.get("V_x", starts.get("v_x", 0.0)))
    across = V * lateral_slip(_column(table, "alpha", 0.0))
    spin = (1.0 + _column(table, "kappa", 0.0)) * V / tire.values["UNLOADED_RADIUS"]
    return {"V_x": V, "V_y": across, "v_x": V, "v_y": across, "omega": spin}


def _carrier(table: pd.DataFrame, starts: Mapping[str, float], tire: Tire) -> dict[str, Any]:
    """Return height and orientation of a wheel carrier."""
    radius, gamma = tire.values["UNLOADED_RADIUS"], _column(table, "gamma", 0.0)
    load = np.abs(_column(table, "Fz", tire.values["FNOMIN"])) / tire.values["FNOMIN"]
    cosine, sine = np.cos(gamma), np.sin(gamma)
    height = (radius - (radius - starts["r_z"]) * load) * cosine
    return {"r_z": height, "R_22": cosine, "R_33": cosine, "R_32": sine, "R_23": -sine}
