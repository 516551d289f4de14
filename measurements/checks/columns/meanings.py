"""What each column of a recording was taken for, with the evidence, and what a table cannot show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ....symbolic.channels import CHANNELS
from ...recording import Recording
from .explanation import explanation
from .traits import SIZES, Traits

#: Assumptions that no table can test, whatever its columns are.
ASSUMPTIONS = (
    "forces and moments are in the declared units together: all of them in another unit give the same ratios",
    "no constant was added to Fz, and the bench subtracted the weight of the wheel",
)
#: The sizes that test each channel, in the order of a text.
_SIZES = {
    "kappa": ("kappa",),
    "alpha": ("alpha",),
    "gamma": ("gamma", "thrust"),
    "Fz": ("mu_xy", "mu_y", "mu_x"),
    "p": ("p", "Fz/p", "trail/patch"),
    "Fx": ("C_x", "C_xy", "mu_x/mu_y", "C_x/C_y"),
    "Fy": ("C_y", "C_xy"),
    "Mz": ("trail", "Mz/Fz"),
    "Mx": ("arm", "Mx/Fz"),
}
#: What the sign of a channel follows from.
_SIGNS = {
    "Fz": "the wheel is loaded", "Fy": "opposes alpha", "Fx": "opposes slip", "Mz": "turns alpha to zero",
    "gamma": "the thrust points to the lean",
}  # fmt: skip
#: Inputs that have a nominal value where their column is absent.
_NOMINAL = ("kappa", "alpha", "gamma", "Fz", "p", "V")


@dataclass(frozen=True)
class ColumnMeaning:
    """One column: the channel, what it was taken for, and the evidence; empty if nothing in the table tests it."""

    channel: str
    taken_for: str
    evidence: str


def column_meanings(recording: Recording) -> list[ColumnMeaning]:
    """Return what each column was taken for, and the inputs that have no column.

    `recording`: with the signs and units that its file or caller states. Returns: in the order of the contract.

    >>> import pandas as pd
    >>> alpha = np.linspace(-0.2, 0.2, 99)
    >>> sweep = pd.DataFrame({"alpha": alpha, "Fz": 900.0, "Fy": -1300.0 * np.tanh(14.0 * alpha)})
    >>> found = {each.channel: each for each in column_meanings(Recording(sweep, "iso", "a.csv"))}
    >>> found["Fy"].taken_for, found["gamma"].taken_for
    ('lateral force, N', 'no column: 0 rad in every row')
    """
    traits = explanation(recording).claimed.traits
    meanings = []
    for name, channel in CHANNELS.items():
        if name in recording.table:
            read_as = recording.about.get(f"unit of {name}") or channel.unit
            read_as = "fraction" if read_as == "1" else read_as
            meaning = channel.meaning.split(" (omega")[0]
            meanings.append(ColumnMeaning(name, f"{meaning}, {read_as}", "; ".join(_evidence(name, traits))))
        elif name in _NOMINAL:
            value = "nominal" if name in ("Fz", "p", "V") else f"0{channel.after}"
            meanings.append(ColumnMeaning(name, f"no column: {value} in every row", ""))
    return meanings


def _evidence(name: str, traits: Traits) -> Iterator[str]:
    """Yield what in the table agrees with the reading of a channel, or contradicts it."""
    if name in _SIGNS and _sign_is_tested(name, traits) and name not in traits.contradictions:
        yield _SIGNS[name]
    for size in _SIZES.get(name, ()):
        if size in traits.sizes:
            declared = SIZES[size]
            unit = f" {declared.unit}".rstrip()
            yield f"{declared.text} {traits.sizes[size]:.3g}{unit} (tires: {declared.typical})"


def _sign_is_tested(name: str, traits: Traits) -> bool:
    sizes = {"Fy": ("C_y", "C_xy"), "Fx": ("C_x", "C_xy"), "Mz": ("trail",)}
    if name == "gamma":
        return bool(np.isfinite(traits.thrust))
    return name == "Fz" or any(size in traits.sizes for size in sizes[name])
