"""Whether recordings are of one tire: differing tire names, loads of different size, joined files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..recording import Recording
from ..thresholds import LARGEST_LOAD_QUANTILE, LARGEST_LOAD_RATIO, MOST_JOINED_PARTS


def identity_notes(recordings: Sequence[Recording]) -> list[str]:
    """Return notes on recordings that seem to be of several tires.

    Parameters
    ----------
    recordings : sequence of Recording

    Returns
    -------
    list of str
        One sentence if the tire names differ, one if the loads differ too much for one tire, and one for each recording
        whose clock restarts while the loads change: two files joined into one.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [900.0], "Fy": [1.0]})
    >>> both = [Recording(rows, "iso", f"{name}.mat", {"tireid": name}) for name in ("Hoosier", "Avon")]
    >>> identity_notes(both)
    ["two tires? the tire is 'Hoosier' in Hoosier.mat, 'Avon' in Avon.mat"]
    """
    notes = []
    named = {each.about["tireid"]: each.source for each in reversed(recordings) if each.about.get("tireid")}
    if len(named) > 1:
        names = ", ".join(f"{tire!r} in {source}" for tire, source in reversed(named.items()))
        notes.append(f"{'two' if len(named) == 2 else len(named)} tires? the tire is {names}")
    loads = {}
    for each in recordings:
        if "Fz" in each.table and len(each):
            loads[each.source] = float(each.table["Fz"].abs().quantile(LARGEST_LOAD_QUANTILE))
    if loads:
        (light, least), (heavy, most) = (pick(loads.items(), key=lambda item: item[1]) for pick in (min, max))
        if most > LARGEST_LOAD_RATIO * least > 0.0:
            notes.append(f"two tires? the load reaches {least:.4g} N in {light}, {most:.4g} N in {heavy}")
    return notes + [note for each in recordings for note in _joined_notes(each)]


def _joined_notes(recording: Recording) -> list[str]:
    """Return a note on files that were joined although their loads differ too much for one tire."""
    if "t" not in recording.table or "Fz" not in recording.table:
        return []
    clock = recording.table["t"].to_numpy(dtype=np.float64)
    starts = [0, *(np.flatnonzero(np.diff(clock) < 0.0) + 1).tolist()]
    if not 2 <= len(starts) <= MOST_JOINED_PARTS:
        return []
    load = recording.table["Fz"].abs().to_numpy(dtype=np.float64)
    largest = [float(np.quantile(part, LARGEST_LOAD_QUANTILE)) for part in np.split(load, starts[1:])]
    if not max(largest) > LARGEST_LOAD_RATIO * min(largest) > 0.0:
        return []
    return [
        f"two tires? {recording.source}: the clock restarts at row {starts[1] + 1}, "
        f"and the loads reach {min(largest):.4g} N in one part and {max(largest):.4g} N in another"
    ]
