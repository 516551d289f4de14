"""Residuals of a tire that a diagnosis delivers, recomputed from the errors of the recording that its JSON lists."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.interpolate import PchipInterpolator

from tirefmu.diagnosis import Diagnosis
from tirefmu.measurements import Recording, with_turn_slip
from tirefmu.numerics import smoothed
from tirefmu.tires import Tire
from tirefmu.tires.states.transient import rolled_distance

FloatArray = npt.NDArray[np.float64]


def with_derived(diagnosis: Diagnosis, table: pd.DataFrame, signs: str) -> pd.DataFrame:
    """Return a table with the turn slip, if the diagnosis computed it from other columns and the table lacks it."""
    if "phit" not in diagnosis.recording["derived_columns"]:
        return table
    return with_turn_slip(Recording(table, signs, "recording")).table


def recomputed(
    diagnosis: Diagnosis, tire: Tire, table: pd.DataFrame, signs: str, end: str = ""
) -> dict[str, FloatArray]:
    """Return the residual of each channel, as docs/diagnosis.md says.

    Parameters
    ----------
    diagnosis : Diagnosis
    tire : Tire
    table : DataFrame
        The recording.
    signs : str
        Of the table.
    end : str
        "_base" for the baseline tire.

    Returns
    -------
    dict of str to ndarray, shape (n_rows,)
        N and N m.
    """
    listed = diagnosis.in_signs("iso" if signs == "iso" else "adapted-sae").recording
    table = with_derived(diagnosis, table, signs)
    t = table["t"].to_numpy()
    late = np.clip(t - listed["skew"], t[0], t[-1])
    inputs = {
        name: PchipInterpolator(t, table[name])(late) if listed["skew"] else table[name]
        for name in tire.inputs
        if name in table
    }
    computed = tire.evaluate(table[["t"]].assign(**inputs), signs=signs)
    first, last = listed["removed_over"]
    found = {}
    for channel, one in listed[f"removed{end}"].items():
        rest = (table[channel] - computed[channel]).to_numpy() - one["offset"]
        for k, size in enumerate(one["drift"], start=1):
            rest = rest - size * np.cos(k * np.pi * (t - first) / (last - first))
        for name, share in listed[f"cross_talk{end}"].items():
            source, target = name.split("_in_")
            if target == channel:
                length = tire.values["UNLOADED_RADIUS"] if target == "Mz" else 1.0
                rest = rest - length * share * table[source].to_numpy()
        for wave in listed[f"periodic{end}"]:
            at = t if wave["over"] == "t" else rolled_distance(t, smoothed(table["V"].to_numpy())[0])
            phase = 2.0 * np.pi * wave["frequency"] * at
            rest = rest - wave["cosine"][channel] * np.cos(phase) - wave["sine"][channel] * np.sin(phase)
        found[channel] = rest
    return found
