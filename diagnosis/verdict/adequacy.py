"""Adequacy of the improved model: residual over noise floor, by channel, and where the residual is largest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, ClassVar

from ...numerics.noise_floor import NoiseFloor
from ...numerics.ties import graded
from ..signals.range_text import range_text
from ..thresholds import INADEQUATE


@dataclass(frozen=True)
class Adequacy:
    """The residual of one channel compared with its noise floor.

    - `residual`, `floor`: root mean square on the fitted rows, N or N m (`Diagnosis.gap`: train, after and
      floor_with_history).
    - `location`: where the mean residual is largest.
    - `over`: the inputs of that location.
    - `memory`: whether the residual is above the floor and is explained by the direction in which slips change or by
      slow time, not by the recorded inputs alone.
    """

    JSON_KEYS: ClassVar = ("ratio", "residual", "floor", "adequate", "location as where", "memory")

    channel: str
    residual: float
    floor: float
    location: str
    over: tuple[str, ...]
    memory: bool

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
        """Return the sentence of the verdict."""
        cause = "; it depends on the history of the slips, on time, or on an input that was not recorded"
        return (
            f"{self.channel} (residual {self.ratio:.1f} times the noise floor, largest at {self.location}"
            f"{cause if self.memory else ''})"
        )


def adequacies(
    residuals: Mapping[str, float], floors: Mapping[str, NoiseFloor], maps: Sequence[Mapping[str, Any]]
) -> tuple[Adequacy, ...]:
    """Return the adequacy of each channel.

    `residuals`: root mean square residual of the delivered tire by channel, on the fitted rows. `maps`: residual maps
    of the improved model (`residual_location.residual_maps`).
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
        floor = floors[channel]
        memory = INADEQUATE * floor.with_history < residual <= INADEQUATE * floor.floor
        rated.append(Adequacy(channel, residual, floor.with_history, location, over, memory))
    return tuple(rated)
