"""What a recording covers: which inputs it sweeps, which it holds at which levels, and what it can tell nothing of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..channels import CHANNELS, OUTPUTS
from ..operating_conditions.levels import level_tolerance, levels
from ..operating_conditions.phases import MOVED
from ..recording import Recording

_FEW_ROWS = 50  # a pure side force alone has a dozen coefficients
#: The slips that a channel answers to.
_ANSWERS_TO = {"Fx": ("kappa",), "Fy": ("alpha", "gamma"), "Mz": ("alpha", "gamma")}
_OTHER_SIZE = 4.0  # one tire's bench program holds loads within this factor from file to file


@dataclass(frozen=True)
class Coverage:
    """What a recording covers of one input.

    Parameters
    ----------
    channel : str
    lowest, highest : float
        In SI.
    levels : tuple of float
        Where it was held, in SI; none where it was swept.

    Examples
    --------
    >>> print(Coverage("gamma", 0.0, 0.06, (0.0, 0.06)))
    gamma: held at 2 levels, 0, 0.06 rad
    >>> print(Coverage("kappa", -0.2, 0.15, ()))
    kappa: swept from -0.2 to 0.15
    """

    channel: str
    lowest: float
    highest: float
    levels: tuple[float, ...]

    @property
    def swept(self) -> bool:
        """Whether the input went through a range rather than being held."""
        return not self.levels

    def __str__(self) -> str:
        """Say it in a line."""
        unit = CHANNELS[self.channel].unit.replace("-", "")
        if self.swept:
            return f"{self.channel}: swept from {self.lowest:.4g} to {self.highest:.4g} {unit}".rstrip()
        held = ", ".join(f"{level:.4g}" for level in self.levels)
        many = "held at" if len(self.levels) == 1 else f"held at {len(self.levels)} levels,"
        return f"{self.channel}: {many} {held} {unit}".rstrip()


def coverage(recording: Recording) -> list[Coverage]:
    """Return what a recording covers of each input that it has.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    list of Coverage
        In the contract's order; none for a recording without rows.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500), "Fz": 900.0})
    >>> [str(each) for each in coverage(Recording(rows, "iso", "a.csv"))]
    ['alpha: swept from -0.2 to 0.2 rad', 'Fz: held at 900 N']
    """
    found = []
    for name in MOVED:
        if name in recording.table and len(recording):
            column = recording.table[name]
            found.append(Coverage(name, float(column.min()), float(column.max()), tuple(levels(column))))
    return found


def coverage_notes(recording: Recording) -> list[str]:
    """Say what a recording can tell nothing of.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    list of str
        One sentence each: few rows, a slip that does not vary, no load or one only, a channel that stays the same,
        a clock that runs backwards.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500), "Fz": 900.0, "Fy": np.linspace(800, -800, 500)})
    >>> coverage_notes(Recording(rows, "iso", "a.csv"))
    ['a.csv: one load only (900 N): nothing tells how the tire changes with load']
    """
    source, table = recording.source, recording.table
    notes = []
    if 0 < len(recording) < _FEW_ROWS:
        notes.append(f"{source}: {len(recording)} rows are fewer than a fit of one force needs")
    by_name = {each.channel: each for each in coverage(recording)}
    for output, slips in _ANSWERS_TO.items():
        if output in table and table[output].notna().any() and not any(_varies(by_name.get(slip)) for slip in slips):
            notes.append(f"{source}: {slips[0]} {_constancy(by_name, slips[0])}: {output} shows no slip curve")
    load = by_name.get("Fz")
    if load is None and len(recording):
        notes.append(f"{source}: Fz is not there: every row counts as at the nominal load")
    if load is not None and not _varies(load):
        middle = float(np.abs(table["Fz"]).median())
        notes.append(f"{source}: one load only ({middle:.4g} N): nothing tells how the tire changes with load")
    for output in OUTPUTS:
        measured = table[output].dropna().to_numpy(dtype=np.float64) if output in table else np.empty(0)
        if len(measured) > 1 and np.ptp(measured) == 0.0:
            notes.append(f"{source}: {output} is {measured[0]:.4g} in every row: was it measured?")
    return notes + _clock_notes(recording)


def identity_notes(recordings: Sequence[Recording]) -> list[str]:
    """Say where recordings look as if they were not all of one tire.

    Parameters
    ----------
    recordings : sequence of Recording

    Returns
    -------
    list of str
        A sentence for names of tires that differ, one for loads that no one tire runs at, and one for each
        recording whose clock starts again within while its load changes: two files in one.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"Fz": [900.0], "Fy": [1.0]})
    >>> both = [Recording(rows, "iso", f"{name}.mat", {"tireid": name}) for name in ("Hoosier", "Avon")]
    >>> identity_notes(both)
    ["two tires? Hoosier.mat says 'Hoosier', Avon.mat says 'Avon'"]
    """
    notes = []
    named = {each.about["tireid"]: each.source for each in reversed(recordings) if each.about.get("tireid")}
    if len(named) > 1:
        said = ", ".join(f"{source} says {tire!r}" for tire, source in reversed(named.items()))
        notes.append(f"{'two' if len(named) == 2 else len(named)} tires? {said}")
    loads = {}
    for each in recordings:
        if "Fz" in each.table and len(each):
            loads[each.source] = float(each.table["Fz"].abs().quantile(0.95))
    if loads:
        (light, least), (heavy, most) = (pick(loads.items(), key=lambda item: item[1]) for pick in (min, max))
        if most > _OTHER_SIZE * least > 0.0:
            notes.append(f"two tires? {light} runs up to {least:.4g} N, {heavy} up to {most:.4g} N")
    return notes + [note for each in recordings for note in _joined_notes(each)]


def _varies(each: Coverage | None) -> bool:
    if each is None:
        return False
    width = level_tolerance([each.lowest, each.highest], each.channel)
    return each.highest - each.lowest > 2.0 * width and len(each.levels) != 1


def _constancy(by_name: dict[str, Coverage], slip: str) -> str:
    each = by_name.get(slip)
    if each is None:
        return "is not there"
    unit = CHANNELS[slip].unit.replace("-", "")
    return f"stays at {0.5 * (each.lowest + each.highest) + 0.0:.3g} {unit}".rstrip()


def _clock_notes(recording: Recording) -> list[str]:
    if "t" not in recording.table or len(recording) < 2:
        return []
    steps = np.diff(recording.table["t"].to_numpy(dtype=np.float64))
    backwards = int(np.count_nonzero(steps < 0.0))
    if backwards <= 0.1 * len(steps):
        return []
    return [
        f"{recording.source}: t runs backwards in {backwards} of {len(steps)} steps: the rows are in another order, "
        f"and no course in time can be read from them"
    ]


def _joined_notes(recording: Recording) -> list[str]:
    """Note files joined into one whose loads have nothing in common."""
    if "t" not in recording.table or "Fz" not in recording.table:
        return []
    clock = recording.table["t"].to_numpy(dtype=np.float64)
    starts = [0, *(np.flatnonzero(np.diff(clock) < 0.0) + 1).tolist()]
    if not 2 <= len(starts) <= 10:
        return []
    load = recording.table["Fz"].abs().to_numpy(dtype=np.float64)
    parts = [float(np.quantile(part, 0.95)) for part in np.split(load, starts[1:])]
    if not max(parts) > _OTHER_SIZE * min(parts) > 0.0:
        return []
    at = starts[1] + 1
    return [
        f"two tires? {recording.source}: the clock starts again at row {at}, "
        f"and loads reach {min(parts):.4g} N in one part and {max(parts):.4g} N in another"
    ]
