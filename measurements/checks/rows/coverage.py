"""Coverage of a recording: swept and held inputs, and information that the recording lacks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....symbolic.channels import CHANNELS, CONTROLLED_INPUTS, OUTPUTS
from ...operating_conditions.levels import level_tolerance, levels
from ...recording import Recording, once
from ...thresholds import MAX_BACKWARD_STEPS

#: The slips that cause each output.
_CAUSES = {"Fx": ("kappa",), "Fy": ("alpha", "gamma"), "Mz": ("alpha", "gamma")}


@dataclass(frozen=True)
class Coverage:
    """The range and the levels of one input in a recording.

    Parameters
    ----------
    channel : str
        The input.
    lowest, highest : float
        In SI units.
    levels : tuple of float
        Levels at which it was held, in SI units; none if it was swept.

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
        """Whether the input was swept rather than held."""
        return not self.levels

    def __str__(self) -> str:
        """Return the coverage in one line."""
        unit = CHANNELS[self.channel].after
        if self.swept:
            return f"{self.channel}: swept from {self.lowest:.4g} to {self.highest:.4g}{unit}"
        held = ", ".join(f"{level:.4g}" for level in self.levels)
        prefix = "held at" if len(self.levels) == 1 else f"held at {len(self.levels)} levels,"
        return f"{self.channel}: {prefix} {held}{unit}"


def coverage(recording: Recording) -> list[Coverage]:
    """Return the coverage of each input of a recording.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    list of Coverage
        In the contract's order. Empty for a recording without rows.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500), "Fz": 900.0})
    >>> [str(channel) for channel in coverage(Recording(rows, "iso", "a.csv"))]
    ['alpha: swept from -0.2 to 0.2 rad', 'Fz: held at 900 N']
    """
    columns = [recording.table[name] for name in CONTROLLED_INPUTS if name in recording.table and len(recording)]
    return [Coverage(str(c.name), float(c.min()), float(c.max()), tuple(levels(c))) for c in columns]


@once
def coverage_notes(recording: Recording) -> list[str]:
    """Return notes on information that a recording lacks.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    list of str
        One sentence each: a slip that does not vary, no load or a single one, a constant output, a clock that
        runs backwards.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500), "Fz": 900.0, "Fy": np.linspace(800, -800, 500)})
    >>> coverage_notes(Recording(rows, "iso", "a.csv"))
    ['a.csv: only one load (900 N): the influence of load cannot be determined']
    """
    source, table = recording.source, recording.table
    notes = []
    by_name = {channel.channel: channel for channel in coverage(recording)}
    for output in outputs_without_curve(recording):
        slip = _CAUSES[output][0]
        notes.append(f"{source}: {slip} {_constancy(by_name, slip)}: {output} shows no slip curve")
    load = by_name.get("Fz")
    if load is not None and not _varies(load):
        median = float(np.abs(table["Fz"]).median())
        notes.append(f"{source}: only one load ({median:.4g} N): the influence of load cannot be determined")
    for output in OUTPUTS:
        measured = table[output].dropna().to_numpy(dtype=np.float64) if output in table else np.empty(0)
        if len(measured) > 1 and np.ptp(measured) == 0.0:
            notes.append(f"{source}: {output} is {measured[0]:.4g} in every row: was it measured?")
    return notes + _clock_notes(recording)


def outputs_without_curve(recording: Recording) -> tuple[str, ...]:
    """Return the measured outputs none of whose slips varies.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    tuple of str
        In the contract's order.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": 0.1, "Fz": 900.0, "Fy": np.linspace(-800, -700, 500)})
    >>> outputs_without_curve(Recording(rows, "iso", "a.csv"))
    ('Fy',)
    """
    by_name, table = {channel.channel: channel for channel in coverage(recording)}, recording.table
    return tuple(
        output
        for output, slips in _CAUSES.items()
        if output in table and table[output].notna().any() and not any(_varies(by_name.get(slip)) for slip in slips)
    )


def outputs_without_slip(recording: Recording) -> tuple[str, ...]:
    """Return the measured outputs whose slips stay at zero or are missing: they are offsets and resistance only.

    Parameters
    ----------
    recording : Recording
        In any signs.

    Returns
    -------
    tuple of str
        In the contract's order.

    Examples
    --------
    >>> import pandas as pd
    >>> rows = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 500), "Fz": 900.0, "Fx": -20.0, "Fy": 0.0})
    >>> outputs_without_slip(Recording(rows, "iso", "a.csv"))
    ('Fx',)
    """
    table = recording.table
    moved = {
        name
        for name in {slip for slips in _CAUSES.values() for slip in slips} & set(table)
        if np.nanmax(np.abs(table[name]), initial=0.0) > level_tolerance(table[name], name)
    }
    return tuple(name for name in recording.measured() if name in _CAUSES and moved.isdisjoint(_CAUSES[name]))


def _varies(channel: Coverage | None) -> bool:
    if channel is None:
        return False
    tolerance = level_tolerance([channel.lowest, channel.highest], channel.channel)
    return channel.highest - channel.lowest > 2.0 * tolerance and len(channel.levels) != 1


def _constancy(by_name: dict[str, Coverage], slip: str) -> str:
    channel = by_name.get(slip)
    if channel is None:
        return "is missing"
    return f"stays at {0.5 * (channel.lowest + channel.highest) + 0.0:.3g}{CHANNELS[slip].after}"


def steps_backwards(recording: Recording) -> int:
    """Return in how many steps the clock runs backwards if the rows are not in the order of time, otherwise 0."""
    steps = np.diff(recording.table["t"].to_numpy(dtype=np.float64)) if "t" in recording.table else np.empty(0)
    backwards = int(np.count_nonzero(steps < 0.0))
    return backwards if backwards > MAX_BACKWARD_STEPS * len(steps) else 0


def _clock_notes(recording: Recording) -> list[str]:
    backwards = steps_backwards(recording)
    if not backwards:
        return []
    return [
        f"{recording.source}: t runs backwards in {backwards} of {len(recording) - 1} steps: the rows are not in the "
        f"order of time and are not treated as a time series"
    ]
