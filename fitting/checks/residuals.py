"""Residuals of a fit by row, with the operating condition of each row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees

import numpy as np
import pandas as pd

from ...measurements import CHANNELS
from ...measurements.operating_conditions.levels import held_levels
from ...numerics.arrays import FloatArray, IntArray
from ...tires.code import fastest_code
from ...tires.signs import reversed_columns
from ...tires.tire import Tire
from ..problem.rows import BLOCK, inputs_of
from ..problem.weights import OWN_SLIP

#: The held inputs that define an operating condition.
NOMINAL_INPUTS = ("Fz", "gamma", "p", "V")
#: Share of the largest slip from which a row is at a large slip.
LARGE_SLIP = 0.25
#: Number of parts of a slip range, to compare rows at equal slip.
SLIP_PARTS = 40


@dataclass(frozen=True, eq=False)
class Residuals:
    """Measured rows and a tire.

    - `table`: in adapted SAE, with the columns ``recording`` and ``segment``; NaN if a channel is not fitted.
    - `sources`: name of each recording.
    - `tire`: in adapted SAE.
    - `signs`: the sign convention of reported differences.
    """

    table: pd.DataFrame
    sources: tuple[str, ...]
    tire: Tire
    signs: str

    @classmethod
    def of(cls, table: pd.DataFrame, sources: Sequence[str], tire: Tire) -> Residuals:
        """Return the residuals of rows in which inputs may be absent: those have their nominal values, as in a fit."""
        nominal = {name: tire.nominal(name) for name in tire.inputs if name not in table}
        return cls(table.assign(**nominal), tuple(sources), tire, tire.signs)

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The outputs that were fitted."""
        return tuple(name for name in self.tire.outputs if name in self.table and self.table[name].notna().any())

    @property
    def units(self) -> dict[str, str]:
        """The unit of each output."""
        return {output.name: output.unit for output in self.tire.symbolic_model.outputs}

    @cached_property
    def computed(self) -> Mapping[str, FloatArray]:
        """The tire's channels at every row, each of shape (n,)."""
        outputs = {name: np.empty(len(self.table)) for name in self.channels}
        code, parameters = fastest_code(self.tire.symbolic_model), self.tire.parameters()
        for start in range(0, len(self.table), BLOCK):  # few rows at a time: all inputs and outputs are much memory
            rows = slice(start, start + BLOCK)
            inputs = inputs_of(self.table.iloc[rows], self.tire)
            forces = code.forces(self.tire.effective_inputs(inputs), parameters)
            for name, values in outputs.items():
                values[rows] = forces[self.tire.outputs.index(name)]
        return outputs

    @cached_property
    def measured_minus_computed(self) -> Mapping[str, FloatArray]:
        """Measured minus computed, each of shape (n,); NaN if not measured."""
        return {name: self.table[name].to_numpy(dtype=float) - self.computed[name] for name in self.channels}

    @cached_property
    def recording(self) -> IntArray:
        """The number of each row's recording."""
        return self.table["recording"].to_numpy(dtype=np.int64)

    @cached_property
    def segment(self) -> IntArray:
        """The number of each row's segment, over all recordings."""
        return self.table["segment"].to_numpy(dtype=np.int64)

    @cached_property
    def levels(self) -> Mapping[str, Sequence[float]]:
        """The levels of each input with several levels, over all recordings."""
        varied = [name for name in NOMINAL_INPUTS if name in self.table and np.ptp(self.table[name].to_numpy()) > 0]
        by_input = {name: held_levels(self.table[name]) for name in varied}
        return {name: held for name, held in by_input.items() if len(held) > 1}

    @cached_property
    def condition(self) -> IntArray:
        """The number of the operating condition of each row: the nearest level of each held input."""
        number = np.zeros(len(self.table), dtype=np.int64)
        for name, held in self.levels.items():
            away = np.abs(self.table[name].to_numpy(dtype=float)[:, None] - np.array(held))
            number = number * len(held) + away.argmin(axis=1)
        return number

    def at(self, condition: int) -> dict[str, float]:
        """Return the levels of an operating condition by its number."""
        levels: dict[str, float] = {}
        for name, held in reversed(list(self.levels.items())):
            condition, index = divmod(condition, len(held))
            levels[name] = float(held[index])
        return dict(reversed(list(levels.items())))

    @cached_property
    def cell(self) -> IntArray:
        """The number of the cell of each row: rows of one operating condition with equal slips."""
        number = self.condition.copy()
        for name in ("kappa", "alpha"):
            if name in self.table and np.ptp(self.table[name].to_numpy()) > 0:
                values = self.table[name].to_numpy(dtype=float)
                part = ((values - values.min()) / np.ptp(values) * SLIP_PARTS).astype(np.int64)
                number = number * SLIP_PARTS + np.minimum(part, SLIP_PARTS - 1)
        return number

    def range_of(self, name: str, channel: str) -> tuple[float, float]:
        """Return the range of an input at the rows in which a channel was fitted at a large slip of its own."""
        slip = OWN_SLIP.get(channel, "alpha")
        fitted = self.table[channel].notna().to_numpy()
        if slip in self.table and fitted.any():
            size = np.where(fitted, np.abs(self.table[slip].to_numpy(dtype=float)), 0.0)
            fitted = fitted & (size >= LARGE_SLIP * size.max())
        values = self.table[name].to_numpy(dtype=float)[fitted]
        return float(values.min()), float(values.max())

    def sign(self, channel: str) -> float:
        """Return -1 for a channel whose sign differs between adapted SAE and the reported convention."""
        return -1.0 if channel in reversed_columns("adapted-sae", self.signs) else 1.0


def condition_text(at: Mapping[str, float]) -> str:
    """Return an operating condition as a text, in the units of a test bench.

    >>> condition_text({"Fz": 1100.0, "gamma": 0.0349, "p": 83e3})
    'Fz 1100 N, gamma 2 deg, p 83 kPa'
    """
    scales = {"gamma": (degrees(1.0), " deg", 1), "alpha": (degrees(1.0), " deg", 1), "p": (1e-3, " kPa", 0)}
    parts = []
    for name, value in at.items():
        scale, unit, digits = scales.get(name, (1.0, CHANNELS[name].after, 3 if name == "kappa" else 0))
        parts.append(f"{name} {round(value * scale, digits) + 0.0:.12g}{unit}")  # + 0.0: no -0
    return ", ".join(parts)
