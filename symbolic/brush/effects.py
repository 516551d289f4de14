"""The effects that the brush model alone has."""

from __future__ import annotations

from ..declarations import Effect
from ..detection import Detection

#: The library's effect of this name rescales a coefficient of the Magic Formula.
load_stiffness = Effect(
    "load_stiffness", "slip stiffness is not proportional to load",
    detection=Detection(requires=("Fz", "alpha"), separate_by="repeat one sweep at three loads"),
)  # fmt: skip
load_patch = Effect(
    "load_patch", "the contact length does not grow with the square root of load",
    detection=Detection(separate_by="repeat one sweep at three loads"),
)  # fmt: skip
