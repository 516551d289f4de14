"""Adequacy of the improved model: residual over noise floor, by channel, and where the residual is largest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from typing import Annotated, Any, ClassVar

import numpy as np

from ...drawing.labels import drawn_unit, range_text
from ...numerics.noise_floor import ErrorSplit
from ...numerics.ties import graded

#: Residual over noise floor above which a channel lacks something that was not identified. Convention: a missing part
#: as large as the floor gives 1.4.
INADEQUATE = 1.5
#: Parts of a residual above this share of its noise floor are named. Convention.
SHOWN = 0.5


@dataclass(frozen=True)
class Adequacy:
    """The residual of one channel compared with its noise floor.

    - `residual`, `floor`: root mean square on the fitted rows, N or N m (`Diagnosis.gap`: train, after and floor).
    - `location`: where the mean residual is largest.
    - `over`: the inputs of that location.
    - `of_inputs`, `of_past`: the parts of the residual, N or N m, that a smooth function of the recorded inputs
      explains, and the rest, which changes slowly: with time, the past, or detail finer than such a function. Squares
      of both and of the floor add up to that of the residual.
    - `lacks`: where the tire gives too much or too little, in words, or ''.
    - `memory`: whether the residual is far above the floor because of the rest, and not because of the recorded inputs
      alone.
    """

    JSON_KEYS: ClassVar = (
        "ratio", "residual", "floor", "adequate", "location as where", "memory", "of_inputs", "of_past", "lacks",
    )  # fmt: skip

    channel: str
    residual: float
    floor: float
    location: str
    over: tuple[str, ...]
    memory: bool
    of_inputs: Annotated[float, "part of the residual that follows the recorded inputs"] = 0.0
    of_past: Annotated[float, "part of the residual that changes slowly for another reason"] = 0.0
    lacks: Annotated[str, "where the tire gives too much or too little, in words, or empty"] = ""

    @property
    def ratio(self) -> float:
        """Residual over noise floor; NaN if the floor is not known."""
        return self.residual / max(self.floor, 1e-12) if isfinite(self.floor) else float("nan")

    @property
    def adequate(self) -> bool | None:
        """Whether the residual is near the noise floor; None if the floor is not known."""
        return bool(self.ratio <= INADEQUATE) if isfinite(self.ratio) else None

    @property
    def rating(self) -> str:
        """Rating by color: "green" near the floor, "amber" above or if not known, "red" if something is missing."""
        if self.ratio > INADEQUATE:
            return "red"
        return "green" if self.ratio <= 0.5 * (1.0 + INADEQUATE) else "amber"

    def __str__(self) -> str:
        """Return the sentence of the verdict: how far the residual is above the floor, what it follows, and where.

        >>> channel = Adequacy("Fy", 41.0, 18.6, "Fz 450 N", ("Fz",), False, 30.0, 5.0)
        >>> print(channel)
        Fy (residual 2.2 times the noise floor of 18.6 N: 30 N of it follow the recorded inputs; largest at Fz 450 N)
        """
        unit = drawn_unit(self.channel)
        causes = ((self.of_inputs, "the recorded inputs"), (self.of_past, "time, the past or finer detail"))
        parts = [(size, cause) for size, cause in causes if size > SHOWN * self.floor]
        follows = ", ".join(
            f"{size:.3g} {unit} {'of it follow ' if number == 0 else ''}{cause}"
            for number, (size, cause) in enumerate(parts)
        )
        texts = [self.lacks] * bool(self.lacks) + [f"largest at {self.location}"] * bool(self.location)
        above = f"residual {self.ratio:.1f} times the noise floor of {self.floor:.3g} {unit}"
        return f"{self.channel} ({above}{': ' * bool(follows)}{'; '.join([follows] * bool(follows) + texts)})"


def adequacies(
    residuals: Mapping[str, float],
    splits: Mapping[str, ErrorSplit],
    maps: Sequence[Mapping[str, Any]],
    lacks: Mapping[str, str],
) -> tuple[Adequacy, ...]:
    """Return the adequacy of each channel.

    `residuals`: root mean square residual of the delivered tire by channel, on the fitted rows. `splits`: its parts.
    `maps`: residual maps of the improved model (`residual_location.residual_maps`). `lacks`: where it gives too much or
    too little, in words.
    """
    rated = []
    for channel, residual in residuals.items():
        of_channel = [shown for shown in maps if shown["channel"] == channel and shown["worst"]["count"]]
        largest = max(of_channel, key=lambda shown: graded(abs(shown["worst"]["mean"])), default=None)
        location, over = "", tuple[str, ...]()
        if largest:
            over, worst = tuple(largest["over"]), largest["worst"]
            location = ", ".join(
                range_text(name, lower, upper)
                for name, lower, upper in zip(over, worst["from"], worst["to"], strict=True)
            )
        floor, of_past = splits[channel].floor, hypot(splits[channel].time, splits[channel].repeats)
        of_inputs = float(np.sqrt(np.maximum(residual**2 - floor**2 - of_past**2, 0.0)))
        memory = INADEQUATE * floor < residual <= INADEQUATE * hypot(floor, of_past)
        lacking = lacks.get(channel, "") if of_inputs > SHOWN * floor else ""
        rated.append(Adequacy(channel, residual, floor, location, over, memory, of_inputs, of_past, lacking))
    return tuple(rated)
