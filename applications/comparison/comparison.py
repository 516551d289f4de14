"""What differs between two tires, such as an old and a new fit of the same recordings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.escaping import visible
from ...boundary.json_schema import json_value
from ...boundary.named_options import named
from ...measurements import Recording, TableLike, exclude_rows, recordings_from
from ...tires import Tire, TireLike, tire_from
from ...tires.input_check import load_limit
from ...tires.property_file.names import is_measured, unmeasured_coefficients
from ...tires.tire_argument import tire_label

#: Quantities over load, by role, and what they are.
ROLES = {
    "stiffness_x": "longitudinal slip stiffness", "stiffness_y": "cornering stiffness",
    "friction_x": "longitudinal friction", "friction_y": "lateral friction",
}  # fmt: skip
#: Root mean square errors that differ by a smaller share are equal.
EQUAL = 0.01


@dataclass(frozen=True)
class Difference:
    """A coefficient with different values in two tires; None where the model of a tire lacks it.

    - `first`, `second`: in ISO-W.
    - `unmeasured`: names of the tires whose data did not determine it.
    """

    name: str
    unit: str
    description: str
    first: float | None
    second: float | None
    unmeasured: tuple[str, ...] = ()

    @property
    def remark(self) -> str:
        """What is to be known of it: its meaning, and where it was not measured."""
        names = " and ".join(self.unmeasured)
        return f"{self.description}; not measured in {names}" if names else self.description


@dataclass(frozen=True)
class ComparedChannel:
    """The errors of both tires in a channel of a recording.

    - `rows`: those that a fit would use.
    - `rmse`, `r2`: of the first and the second tire; R2 is NaN if the measured values are constant.
    """

    recording: str
    channel: str
    unit: str
    rows: int
    rmse: tuple[float, float]
    r2: tuple[float, float]


@dataclass(frozen=True)
class ComparedCharacteristic:
    """A quantity over load of both tires at one load, without slip.

    - `load`: N. `unmeasured`: names of the tires whose data did not determine it.
    """

    title: str
    unit: str
    load: float
    first: float
    second: float
    unmeasured: tuple[str, ...] = ()

    @property
    def change(self) -> float:
        """Relative change from the first to the second tire; NaN if the first has none."""
        return self.second / self.first - 1.0 if self.first else float("nan")

    @property
    def differs(self) -> bool:
        """Whether the change would be shown in percent with one digit."""
        return bool(abs(self.change) >= 5e-4)

    @property
    def remark(self) -> str:
        """The title, and where it was not measured."""
        names = " and ".join(self.unmeasured)
        return f"{self.title} (not measured in {names})" if names else self.title


@dataclass(frozen=True)
class Comparison:
    """Two tires and what differs.

    - `tires`: in ISO-W.
    - `names`: different ones.
    - `effects`: effects of the first tire that the second lacks, and the reverse.
    - `differences`: those of effects that a tire lacks are among them; those that no data determined are last.
    - `characteristics`: at the nominal load of the first tire, or the nearest one within the range of the second.
    """

    tires: tuple[Tire, Tire]
    names: tuple[str, str]
    effects: tuple[tuple[str, ...], tuple[str, ...]]
    differences: tuple[Difference, ...]
    characteristics: tuple[ComparedCharacteristic, ...]
    errors: tuple[ComparedChannel, ...]

    def __repr__(self) -> str:
        """Return the verdict and the characteristics at one load."""
        shown = (
            f"  {c.remark} at {c.load:g} N: {c.first:.4g} and {c.second:.4g} {'' if c.unit == '1' else c.unit}".rstrip()
            for c in self.characteristics
        )
        return "\n".join(map(visible, [f"{self.names[0]} and {self.names[1]}: {self.verdict}", *shown]))

    @property
    def verdict(self) -> str:
        """Which tire is closer to the recordings, by channel; without recordings how friction and stiffness differ."""
        if not self.errors:
            changes = [f"{c.title} {c.change:+.1%}" for c in self.characteristics if not c.unmeasured and c.differs]
            if not changes:
                return self.counted
            load = self.characteristics[0].load
            outside = [
                f", outside the range of {name}"
                for name, tire in zip(self.names, self.tires, strict=True)
                if "Fz" in tire.ranges and not tire.ranges["Fz"][0] <= load <= tire.ranges["Fz"][1]
            ]
            return f"at {load:g} N{''.join(outside)}, {self.names[1]} against {self.names[0]}: {', '.join(changes)}"
        closer: dict[str, list[str]] = {}
        for channel in dict.fromkeys(error.channel for error in self.errors):
            closer.setdefault(self._closer(channel), []).append(channel)
        return "closer to the data: " + "; ".join(f"{who} in {', '.join(which)}" for who, which in closer.items())

    @property
    def counted(self) -> str:
        """How many coefficients differ."""
        count, unmeasured = len(self.differences), sum(bool(d.unmeasured) for d in self.differences)
        text = f"{count or 'no'} coefficient{'s'[: count != 1]} differ{'s'[: count == 1]}"
        return f"{text}, {unmeasured} of them not measured" if unmeasured else text

    def _closer(self, channel: str) -> str:
        squares = [
            sum(error.rows * error.rmse[i] ** 2 for error in self.errors if error.channel == channel) for i in (0, 1)
        ]
        if abs(squares[0] - squares[1]) <= 2.0 * EQUAL * max(squares):
            return "both equally"
        return self.names[int(squares[1] < squares[0])]

    def to_json(self) -> dict[str, Any]:
        """Return the comparison as JSON values."""
        content = {
            "ok": True,
            "verdict": self.verdict,
            "tires": [{"name": n, "model": t.model} for n, t in zip(self.names, self.tires, strict=True)],
            "effects_of_one": self.effects,
            "coefficients": self.differences,
            "characteristics": self.characteristics,
            "channels": self.errors,
        }
        return dict(json_value(content))


@named()
def compare(
    first: TireLike,
    second: TireLike,
    tables: TableLike | Iterable[TableLike] = (),
    *,
    signs: str | None = None,
    names: tuple[str, str] | None = None,
) -> Comparison:
    """Compare two tires of any models.

    Parameters
    ----------
    first, second : Tire, path of a .tir file, or name of a published tire
        In any signs.
    tables : path, DataFrame or Recording, or a sequence of them
        Both tires are evaluated over their rows.
    signs : str, optional
        Sign convention of the tables, as for `tirefmu.fit`.
    names : (str, str), optional
        Shown for the tires; numbered if they are the same. By default the names of their files or models.

    Returns
    -------
    Comparison
        Coefficients and effects that differ, friction and slip stiffness of both, errors over the tables.

    Raises
    ------
    DataError
        If a table has no measured output, or an input is not finite.
    UnknownName, TirError, WrongType
        If a tire does not exist or cannot be read.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> old = published("trento_hoosier")
    >>> [difference.name for difference in compare(old, old.with_values(PDY1=2.5), names=("old", "new")).differences]
    ['PDY1']
    """
    tires = (tire_from(first, "first").in_signs("iso"), tire_from(second, "second").in_signs("iso"))
    recordings = recordings_from(tables, signs=signs)
    names = names or (tire_label(first), tire_label(second))
    if names[0] == names[1]:
        names = (f"{names[0]} (1)", f"{names[1]} (2)")
    errors = tuple(error for recording in recordings for error in _errors(tires, recording))
    effects = (tuple(sorted(tires[0].has - tires[1].has)), tuple(sorted(tires[1].has - tires[0].has)))
    differences, characteristics = tuple(_differences(tires, names)), tuple(_characteristics(tires, names))
    return Comparison(tires, names, effects, differences, characteristics, errors)


def _characteristics(tires: tuple[Tire, Tire], given: tuple[str, str]) -> Iterator[ComparedCharacteristic]:
    first, second = tires
    load = _common_load(first, second)
    tables = [tire.evaluate(pd.DataFrame({"Fz": [load]}), signs="iso", steady=True) for tire in tires]
    for role, title in ROLES.items():
        names = [tire.symbolic_model.quantity(role) for tire in (first, second)]
        if all(names):
            values = [float(table[name].iloc[0]) for table, name in zip(tables, names, strict=True)]
            yield ComparedCharacteristic(
                title,
                first.symbolic_model.structure.quantities[names[0]][0],
                load,
                values[0],
                values[1],
                tuple(name for name, tire in zip(given, tires, strict=True) if not is_measured(tire, role)),
            )


def _common_load(first: Tire, second: Tire) -> float:
    """Return the nominal load of the first tire, or the nearest one of the second's range, if the first reaches it."""
    nominal = first.values["FNOMIN"]
    low, high = second.ranges.get("Fz", (0.0, load_limit(second)))
    nearest = max(low, min(nominal, high))
    return nearest if 0.0 < nearest <= load_limit(first) else nominal


def _differences(tires: tuple[Tire, Tire], names: tuple[str, str]) -> list[Difference]:
    first, second = tires
    unmeasured = [unmeasured_coefficients(tire) for tire in tires]
    declared = {**second.symbolic_model.coefficients, **first.symbolic_model.coefficients}
    errors = []
    for name, coefficient in declared.items():
        values = (first.values.get(name), second.values.get(name))
        if values[0] != values[1]:
            where = tuple(tire for tire, those in zip(names, unmeasured, strict=True) if name in those)
            errors.append(Difference(name, coefficient.unit, coefficient.description, *values, where))
    return sorted(errors, key=lambda difference: bool(difference.unmeasured))


def _errors(tires: tuple[Tire, Tire], recording: Recording) -> list[ComparedChannel]:
    included = exclude_rows(recording).included
    predicted = [tire.evaluate(recording) for tire in tires]
    errors = []
    for channel in recording.measured():
        if not all(channel in table for table in predicted):
            continue
        measured = recording.table[channel].to_numpy(dtype=np.float64)
        rows = included & np.isfinite(measured)
        if not rows.any():
            continue
        squares = [float(np.mean((table[channel].to_numpy()[rows] - measured[rows]) ** 2)) for table in predicted]
        variance = float(np.var(measured[rows]))
        r2 = [1.0 - square / variance if variance > 0.0 else np.nan for square in squares]
        unit = next(quantity.unit for quantity in tires[0].symbolic_model.outputs if quantity.name == channel)
        rmse = (squares[0] ** 0.5, squares[1] ** 0.5)
        errors.append(ComparedChannel(recording.source, channel, unit, int(rows.sum()), rmse, (r2[0], r2[1])))
    return errors
