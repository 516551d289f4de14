"""What defines a tire: a model, the effects that it has, the values of its coefficients, and where they hold."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np
import numpy.typing as npt

from ..boundary.errors import TireError, UnknownName, no_single_text
from ..symbolic.added import AddedEffect, library
from ..symbolic.declarations import Coefficient
from ..symbolic.model import INDISPENSABLE, Model
from ..symbolic.models import with_library
from ..symbolic.options import OPTIONS
from .code.printed import model_with
from .signs import TABLE_INPUTS

FloatArray = npt.NDArray[np.float64]

#: Keys of the ranges in which a tire is known, by input.
RANGES = {
    "kappa": ("KPUMIN", "KPUMAX"),
    "alpha": ("ALPMIN", "ALPMAX"),
    "gamma": ("CAMMIN", "CAMMAX"),
    "Fz": ("FZMIN", "FZMAX"),
    "p": ("PRESMIN", "PRESMAX"),
}


@dataclass(frozen=True, repr=False)
class TireDefinition:
    """A model, effects and values for every coefficient; `Tire` adds the methods.

    Evaluation, property files and figures need no more than this. `Tire` documents the attributes.
    """

    model: str
    values: Mapping[str, float]
    effects: Collection[str] | None = None
    signs: str = "iso"
    name: str = ""
    about: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    side: str = ""
    added: tuple[AddedEffect, ...] = ()
    other_entries: tuple[tuple[str, str, str], ...] = ()
    defaulted: tuple[str, ...] = field(init=False, default=(), compare=False)

    def __post_init__(self) -> None:
        if self.signs not in ("iso", "adapted-sae"):
            raise UnknownName("sign convention of a tire", self.signs, ("iso", "adapted-sae"))
        if self.side not in ("left", "right", "symmetric", ""):
            raise UnknownName("side of the vehicle", self.side, ("left", "right", "symmetric"))
        no_single_text("effects", self.effects)
        object.__setattr__(self, "added", with_library(self.model, self.effects or (), self.added))
        declarations = self.symbolic_model.coefficients
        present = self._present()
        given = {**self._range_values(), **self.values}
        for name in given:
            if name not in declarations:
                raise UnknownName(f"coefficient of {self.model}", name, declarations)
        for name in INDISPENSABLE:
            if name not in given:
                raise TireError(f"a tire needs {name} ({declarations[name].description}, {declarations[name].unit})")
            if not _number(name, given[name]) > 0.0:
                raise TireError(f"{name} = {given[name]:g}: a positive value expected")
        absent = self.symbolic_model.owned(*sorted(self.symbolic_model.effects.keys() - present))
        defaults = _defaults(self.symbolic_model)
        values = dict(defaults) if self.signs == "adapted-sae" else _mirrored(declarations, defaults)
        neutral = {name: declarations[name].neutral for name in absent}
        values |= {name: value for name, value in neutral.items() if value is not None}
        values |= {name: _number(name, value) for name, value in given.items() if name not in absent}
        values |= self._assumed_ends(values, given)
        object.__setattr__(self, "defaulted", tuple(name for name in declarations if name not in given))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "effects", present)
        object.__setattr__(self, "about", {_word(key): str(text) for key, text in self.about.items()})
        complete = {name: pair for name, pair in RANGES.items() if set(pair) <= given.keys()}
        ranges = {**self.ranges, **{name: (values[low], values[high]) for name, (low, high) in complete.items()}}
        object.__setattr__(self, "ranges", {name: _range(name, *r) for name, r in ranges.items()})

    def _present(self) -> frozenset[str]:
        if self.effects is None:
            return self.symbolic_model.default_effects | {
                effect.name for effect in self.added if effect.name not in library()
            }
        for name in self.effects:
            if name not in self.symbolic_model.effects:
                raise UnknownName(f"effect of {self.model}", name, [*self.symbolic_model.effects, *library()])
        return frozenset(self.effects)

    def _range_values(self) -> dict[str, float]:
        """Return the given ranges as coefficients of the model, if it has them."""
        declarations = self.symbolic_model.coefficients
        pairs = ((RANGES[name], ends) for name, ends in self.ranges.items() if name in RANGES)
        return {key: end for keys, ends in pairs for key, end in zip(keys, ends, strict=True) if key in declarations}

    def _assumed_ends(self, values: Mapping[str, float], given: Collection[str]) -> dict[str, float]:
        """Return the ends of ranges that are not given and would exclude the nominal input, in proportion to it.

        The assumed ones are those of a car: 10 kN is no limit of an aircraft tire with a nominal load of 100 kN.
        """
        ends: dict[str, float] = {}
        for quantity in self.symbolic_model.inputs:
            nominal, (low, high) = quantity.nominal, RANGES.get(quantity.name, ("", ""))
            if isinstance(nominal, str) and {nominal, low, high} <= values.keys():
                size = values[nominal]
                outside = {low: values[low] > size > 0.0, high: values[high] < size}
                factor = size / self.symbolic_model.coefficients[nominal].default
                ends |= {end: factor * values[end] for end in outside if outside[end] and end not in given}
        return ends

    @cached_property
    def symbolic_model(self) -> Model:
        """The symbolic model, the added effects in its lines."""
        return model_with(self.model, self.added)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs that the model reads."""
        return tuple(quantity.name for quantity in self.symbolic_model.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the forces and moments that the model gives."""
        return tuple(quantity.name for quantity in self.symbolic_model.outputs)

    @property
    def has(self) -> frozenset[str]:
        """The effects that the tire has."""
        return frozenset(self.effects or ())

    @property
    def rescaled(self) -> dict[str, float]:
        """Coefficients whose meaning an absent effect changes, and their factor in `parameters`.

        >>> core = TireDefinition("mf96", {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3}, effects=())
        >>> core.rescaled
        {'PKY1': 500000.0}
        """
        absent = (effect for name, effect in self.symbolic_model.effects.items() if name not in self.has)
        return {name: factor for effect in absent for name, factor in effect.rescales}

    def parameters(self, **options: str) -> FloatArray:
        """Return the parameter vector of the generated code, absent effects at neutral.

        `**options`: conventions by name (`tirefmu.symbolic.options`), the default where absent; those that the model
        does not have are ignored. Returns shape (n_parameters,): in the order of ``PARAMETERS`` of the generated
        modules. Raises `UnknownName` if an option or its value does not exist.
        """
        factors = self.rescaled
        values = [self.values[name] * factors.get(name, 1.0) for name in self.symbolic_model.coefficients]
        chosen = {"signs": self.signs, **options}
        for name, value in chosen.items():
            if name not in OPTIONS:
                raise UnknownName("option", name, OPTIONS)
            if value not in OPTIONS[name].values:
                raise UnknownName(f"value of {name}", value, OPTIONS[name].values)
        indices = [
            option.values.index(chosen.get(option.name, option.values[0])) for option in self.symbolic_model.options
        ]
        return np.array([*values, *indices], dtype=np.float64)

    def in_signs(self, signs: str) -> Self:
        """Return the same tire written in another convention.

        `signs`: "iso" or "adapted-sae". Returns: its forces at an input are those of this tire with Fy, Mz and My
        reversed.
        """
        if signs == self.signs:
            return self
        given = {name: value for name, value in self.values.items() if name not in self.defaulted}
        return replace(self, values=_mirrored(self.symbolic_model.coefficients, given), signs=signs)

    def with_values(self, **coefficients: float) -> Self:
        """Return the same tire with other values of some coefficients.

        `**coefficients`: by .tir name, SI, in the signs of the tire. Bounds of a fit are not enforced. Raises
        `UnknownName` if the model has no such coefficient. Raises `TireError` if a value is not a finite number, or
        only an effect that the tire does not have reads it.

        >>> from tirefmu.tires import published
        >>> softer = published("trento_hoosier").with_values(PDY1=2.5)
        >>> softer.values["PDY1"]
        2.5
        """
        given = {name: value for name, value in self.values.items() if name not in self.defaulted}
        changed = replace(self, values={**given, **coefficients})
        for name, value in coefficients.items():
            if changed.values[name] != float(value):
                effects = [
                    effect for effect in self.symbolic_model.effects if name in self.symbolic_model.owned(effect)
                ]
                raise TireError(f"{name} has no influence: the tire does not have {' or '.join(effects)}")
        return changed

    def nominal(self, name: str) -> float:
        """Return the value of an input that is not given."""
        (quantity,) = (quantity for quantity in self.symbolic_model.inputs if quantity.name == name)
        if isinstance(quantity.nominal, str):  # a formula may read T without a coefficient for its reference
            return self.values.get(quantity.nominal, quantity.typical)
        return quantity.nominal

    @property
    def lags(self) -> bool:
        """True if slips lag behind their inputs: the tire has an effect of relaxation, such as relax_lat."""
        return bool(self.has & self.symbolic_model.relaxing_effects)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states of its added effects; the lagged slips and the distance are not among them."""
        return self.symbolic_model.states_of(self.has)

    def effective_inputs(self, rows: FloatArray) -> FloatArray:
        """Return the rows of inputs; inputs that would request an effect that the tire lacks are 0."""
        silent = np.isin(
            self.inputs, [name for effect, name in self.symbolic_model.on_demand if effect not in self.has]
        )
        return np.where(silent[:, None], 0.0, rows) if rows[silent].any() else rows


@lru_cache(maxsize=16)
def _defaults(model: Model) -> dict[str, float]:
    return {name: declaration.default for name, declaration in model.coefficients.items()}


def _number(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise TireError(f"{name} is {value!r}: a coefficient is a finite number")
    return number


def _mirrored(declarations: Mapping[str, Coefficient], values: Mapping[str, float]) -> dict[str, float]:
    """Write coefficients in the other convention; a zero stays a plain 0.0."""
    return {name: -value if declarations[name].flips and value else value for name, value in values.items()}


def _word(key: str) -> str:
    if not re.fullmatch("[a-z][a-z0-9_]*", key):
        raise TireError(f"about {key!r}: a key is a word of lower-case letters, digits and _")
    return key


def _range(name: str, lower: float, upper: float) -> tuple[float, float]:
    if name not in TABLE_INPUTS:
        raise UnknownName("input", name, TABLE_INPUTS)
    if not lower <= upper:
        raise TireError(f"the range of {name} is crossed: {lower} to {upper}")
    return float(lower), float(upper)


def default_loads(tire: TireDefinition) -> tuple[float, ...]:
    """Return three loads over the range in which a tire is known, as round as the range allows.

    `tire`: of its range, the part from a quarter of the nominal load to three times it; up to twice the nominal load
    where it has no range. The result is in N; fewer loads if the range is a single load.

    >>> from tirefmu.tires import published
    >>> default_loads(published("unicamp_small_tire"))
    (60.0, 110.0, 160.0)
    """
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.0, 2.0 * nominal))
    high = min(high, 3.0 * nominal) if high > 0.0 else 2.0 * nominal
    low = min(max(low, 0.25 * nominal), high)
    even = np.linspace(low, high, 3).tolist()
    rounded = (float(f"{load:.2g}") for load in even)
    loads = (near if low <= near <= high else load for near, load in zip(rounded, even, strict=True))
    return tuple(dict.fromkeys(loads))
