"""Comparison of data and tire: rows grouped by the levels of held inputs, and the tire's curve for each group."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...boundary.errors import FitError
from ...measurements import OUTPUTS, Recording, TableLike, level_tolerance, levels, recordings_from
from ...measurements.operating_conditions.levels import held_levels
from ...measurements.recording import distinct
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.slip_slope import SLOPE_WINDOW, read_slope
from ...numerics.ties import graded
from ...tires import TireLike, tire_from
from ...tires.evaluation import Conventions, evaluate
from ...tires.property_file.names import unmeasured_outputs
from ...tires.signs import convert_signs
from ...tires.tire import Tire

_POINTS = 201  # of a curve
#: Inputs that a program may set to several levels in addition to load and inclination: one panel has one level of each.
FURTHER = ("p", "V")
_UPRIGHT = 0.2  # of a tolerance: a smaller held inclination is taken as zero


@dataclass(frozen=True)
class Group:
    """Rows at one level of a held channel (its median in them), with measured and computed columns."""

    level: float
    rows: pd.DataFrame


@dataclass(frozen=True)
class CurveFamily:
    """Groups whose curves are drawn in one panel.

    - `channel`, `slip`, `by`: the output, the slip on the horizontal axis, and the channel with one curve for each
      level.
    - `groups`: in increasing magnitude of the level.
    - `held`: common levels of all groups.
    """

    channel: str
    slip: str
    by: str
    groups: tuple[Group, ...]
    held: dict[str, float]


@dataclass(frozen=True)
class MeasuredCurves:
    """Measured and computed values by row, in one sign convention.

    - `signs`: that of the recordings, or iso if they differ.
    - `table`: inputs (nominal if not recorded), measured outputs, computed outputs as ``Fx_fit`` etc., ``recording``
      (number), ``lateral`` (row of a sweep of alpha at kappa 0) and ``longitudinal`` (row of a sweep of kappa).
    """

    tire: Tire
    signs: str
    sources: tuple[str, ...]
    table: pd.DataFrame

    @property
    def channels(self) -> tuple[str, ...]:
        """The measured outputs that the tire computes."""
        return tuple(name for name in OUTPUTS if f"{name}_fit" in self.table)

    def residuals(self) -> dict[str, FloatArray]:
        """Return measured minus computed for each channel that the tire was fitted to; NaN if not measured."""
        fitted = [name for name in self.channels if name not in unmeasured_outputs(self.tire)]
        return {name: (self.table[name] - self.table[f"{name}_fit"]).to_numpy(dtype=float) for name in fitted}

    def tolerance(self, channel: str) -> float:
        """Return the tolerance of the levels of a channel."""
        return level_tolerance(self.table[channel], channel)

    def pure(self, channel: str, slip: str) -> list[CurveFamily]:
        """Return the families of pure slip: by load at the smallest inclination, by inclination at the nominal load.

        Both are at the reference pressure and speed of the tire; with several of these, families by them follow.
        """
        rows = self._measured(channel, "lateral" if slip == "alpha" else "longitudinal")
        if slip == "kappa":
            rows = self._near(rows, "alpha", 0.0)
        if rows.empty:
            return []
        held = self._main_levels(rows)
        main = self._at(rows, held)
        levels = held | {"gamma": self._smallest(main, "gamma"), "Fz": self._reference_load(main)}
        families = []
        for by in ("Fz", "gamma", *held):
            others = {name: level for name, level in levels.items() if name != by}
            families.append(CurveFamily(channel, slip, by, self.groups(self._at(rows, others), by), others))
        return [families[0], *(family for family in families[1:] if len(family.groups) > 1)]

    def combined(self) -> list[CurveFamily]:
        """Return the families of combined slip over kappa; empty without a held nonzero slip angle.

        Fx and Fy by slip angle at one load and the smallest inclination; Fy by load at the largest slip angle, and by
        inclination at the smallest nonzero one with several inclinations.
        """
        families = []
        for channel in [name for name in ("Fx", "Fy") if name in self.channels]:
            rows = self._measured(channel, "longitudinal")
            if rows.empty:
                continue
            held = self._main_levels(rows)
            rows = self._at(rows, held)
            camber, load = self._smallest(rows, "gamma"), self._reference_load(rows)
            held_angles = [
                slip_angle for slip_angle in self._levels(rows, "alpha") if abs(slip_angle) > self.tolerance("alpha")
            ]
            if not held_angles:
                continue
            angle = max(held_angles, key=_size)
            upright, loaded = self._near(rows, "gamma", camber), self._near(rows, "Fz", load)
            angles = self.groups(self._near(upright, "Fz", load), "alpha")
            families.append(CurveFamily(channel, "kappa", "alpha", angles, {"Fz": load, "gamma": camber} | held))
            if channel == "Fy":
                loads = self.groups(self._near(upright, "alpha", angle), "Fz")
                families.append(CurveFamily(channel, "kappa", "Fz", loads, {"alpha": angle, "gamma": camber} | held))
                for moderate in sorted(held_angles, key=_size):
                    cambers = self.groups(self._near(loaded, "alpha", moderate), "gamma")
                    if len(cambers) > 1:
                        levels = {"alpha": moderate, "Fz": load} | held
                        families.append(CurveFamily(channel, "kappa", "gamma", cambers, levels))
                        break
        return [family for family in families if family.groups]

    def groups(self, rows: pd.DataFrame, channel: str) -> tuple[Group, ...]:
        """Return the rows near each level of a channel, in increasing magnitude."""
        centers = np.array(sorted(self._levels(rows, channel), key=_size))
        if not len(centers):
            return ()
        distance = np.abs(rows[channel].to_numpy()[:, None] - centers)
        nearest, near = distance.argmin(axis=1), distance.min(axis=1) <= self.tolerance(channel)
        parts = [(level, rows[near & (nearest == number)]) for number, level in enumerate(centers.tolist())]
        return tuple(Group(level, part) for level, part in parts if len(part))

    def curve(self, group: Group, slip: str, tire: Tire | None = None) -> pd.DataFrame:
        """Return the tire evaluated over a slip, the other inputs at their medians in the group.

        `slip`, one of "kappa", "alpha": varies over the range of the group; the grid contains zero if the range does.
        `tire`: by default the compared tire. The result is as from `Tire.evaluate`, in the signs of the comparison.
        """
        low, high = float(group.rows[slip].min()), float(group.rows[slip].max())
        grid = np.linspace(low, high, _POINTS)
        if low < 0.0 < high:
            grid = np.unique(np.append(grid, 0.0))
        return self.along(group.rows, slip, grid, tire)

    def along(self, rows: pd.DataFrame, channel: str, values: FloatArray, tire: Tire | None = None) -> pd.DataFrame:
        """Return the tire evaluated at values of one input, the others at their medians in the rows.

        An inclination within the offset of a sensor is replaced by zero, because formulas with sign(gamma) are
        discontinuous there.
        """
        return self.over(rows, {channel: values}, tire)

    def over(self, rows: pd.DataFrame, columns: Mapping[str, FloatArray], tire: Tire | None = None) -> pd.DataFrame:
        """Return the same for columns of several inputs."""
        names = [name for name in ("kappa", "alpha", "gamma", "Fz", *self.tire.inputs) if name not in columns]
        held = {name: float(rows[name].median()) for name in dict.fromkeys(names)}
        if "gamma" in held and abs(held["gamma"]) <= _UPRIGHT * self.tolerance("gamma"):
            held["gamma"] = 0.0
        table = pd.DataFrame(columns).assign(**held)
        return evaluate(tire or self.tire, table, Conventions(self.signs))

    def slopes_at_zero(self, family: CurveFamily) -> list[tuple[float, float]]:
        """Return the magnitudes of load and measured slope at zero slip of each group."""
        read = []
        for group in family.groups:
            slip, force = (group.rows[name].to_numpy(dtype=float) for name in (family.slip, family.channel))
            slope = read_slope(slip, force, SLOPE_WINDOW[family.slip]).value
            if np.isfinite(slope):
                read.append((abs(group.level), abs(slope)))
        return read

    def _measured(self, channel: str, sweep: str) -> pd.DataFrame:
        """Rows of a sweep type in which a channel was measured."""
        if channel not in self.channels:
            return self.table[:0]
        return self.table[self.table[sweep] & self.table[channel].notna()]

    def _main_levels(self, rows: pd.DataFrame) -> dict[str, float]:
        """Return one level of each further input that has several: nearest to the reference of the tire.

        For an input that the tire lacks it is the one with the most rows.
        """
        main = {}
        for name in FURTHER:
            held = self._common(name, held_levels(rows[name])) if name in rows else []
            if len(held) > 1:
                is_input = name in self.tire.inputs
                reference = (
                    self.tire.nominal(name) if is_input else max(held, key=lambda at: len(self._near(rows, name, at)))
                )
                main[name] = min(held, key=lambda level: _size(level - reference))
        return main

    def _at(self, rows: pd.DataFrame, levels: Mapping[str, float]) -> pd.DataFrame:
        for name, level in levels.items():
            rows = self._near(rows, name, level)
        return rows

    def _near(self, rows: pd.DataFrame, channel: str, value: float) -> pd.DataFrame:
        return rows[(rows[channel] - value).abs() <= self.tolerance(channel)]

    def _levels(self, rows: pd.DataFrame, channel: str) -> list[float]:
        """Levels of a channel; five quantiles if it was swept."""
        # Sweeps of alpha at zero kappa contain all slip angles and are excluded, so that held slip angles are found.
        moving = rows[rows["kappa"].abs() > self.tolerance("kappa")] if channel == "alpha" else rows
        values = (moving if len(moving) else rows)[channel]
        held = levels(values, tolerance=self.tolerance(channel) or None)
        return self._common(channel, held) or np.quantile(values, (0.1, 0.3, 0.5, 0.7, 0.9)).tolist()

    def _common(self, channel: str, held: Sequence[float]) -> list[float]:
        """Return levels with the values that they have over all rows: a load has one name in all panels and tables."""
        if channel not in ("Fz", *FURTHER):
            return list(held)
        everywhere = np.array(held_levels(self.table[channel]) or held)
        near = [float(everywhere[np.abs(everywhere - level).argmin()]) for level in held]
        tolerance = self.tolerance(channel)
        return [other if abs(other - level) <= tolerance else level for level, other in zip(held, near, strict=True)]

    def _smallest(self, rows: pd.DataFrame, channel: str) -> float:
        return min(self._levels(rows, channel), key=_size)

    def _reference_load(self, rows: pd.DataFrame) -> float:
        return min(self._levels(rows, "Fz"), key=lambda load: _size(abs(load) - self.tire.values["FNOMIN"]))


def _size(value: float) -> float:
    return graded(abs(value))


def compare(tire: TireLike, recordings: TableLike | Iterable[TableLike], signs: str | None = None) -> MeasuredCurves:
    """Combine recordings in one table with measured outputs and outputs of the tire.

    `recordings`: of any signs. `signs`: convention of the comparison; by default that of the recordings, or iso if they
    differ. Raises `FitError` if there is no recording. Raises `DataError` if one has no measured output.

    >>> from tirefmu.measurements import VirtualBench, alpha_sweeps
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> comparison = compare(tire, [VirtualBench(tire).run(alpha_sweeps([220.0, 700.0]))])
    >>> [(family.by, len(family.groups)) for family in comparison.pure("Fy", "alpha")]
    [('Fz', 2)]
    """
    tire, given = tire_from(tire), recordings_from(recordings)
    if not given:
        raise FitError("no recording to compare the tire with")
    conventions = {recording.signs for recording in given}
    if signs is None:
        signs = conventions.pop() if len(conventions) == 1 else "iso"
    tables = []
    for number, recording in enumerate(given):
        recording.measured()  # raises for a recording without outputs
        table = recording.with_signs("iso").table
        absent = {name: tire.nominal(name) for name in tire.inputs if name not in table}
        table = convert_signs(table.assign(**absent), "iso", signs)
        tables.append(table.assign(recording=number, **_sweeps(recording, table)))
    data = pd.concat(tables, ignore_index=True)
    computed = evaluate(tire, data, Conventions(signs))
    fits = {
        f"{name}_fit": computed[name]
        for name in OUTPUTS
        if name in tire.outputs and name in data and data[name].notna().any()
    }
    return MeasuredCurves(tire, signs, tuple(distinct([recording.source for recording in given])), data.assign(**fits))


def _sweeps(recording: Recording, table: pd.DataFrame) -> dict[str, BoolArray]:
    """Return for each row whether alpha is swept and whether kappa is swept."""
    swept = {name: np.zeros(len(table), dtype=np.bool_) for name in ("alpha", "kappa")}
    for rows in recording.segments():
        for name, marks in swept.items():
            values = table[name].to_numpy(dtype=float)[rows]
            marks[rows] = np.ptp(values) > 4.0 * level_tolerance(values, name)
    rolling = table["kappa"].abs().to_numpy() <= level_tolerance(table["kappa"], "kappa")
    return {"lateral": swept["alpha"] & rolling, "longitudinal": swept["kappa"]}
