"""A tire: a model of the book, the effects that it has, and the values of its coefficients."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.symbolic import model as book
from tirefmu.symbolic.errors import DataError, TireError, UnknownName
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.notation import Coefficient

from .code import Code, code_for
from .signs import convert_signs, reversed_columns

FloatArray = npt.NDArray[np.float64]

#: The input columns of the public tables; a model reads those that it knows.
TABLE_INPUTS = ("t", "kappa", "alpha", "gamma", "Fz", "p", "V", "T", "phit")
#: The output columns of the public tables.
TABLE_OUTPUTS = ("Fx", "Fy", "Mz", "Mx", "My")


class Forces(Mapping[str, FloatArray]):
    """Forces and moments by name: ``forces["Fy"]`` and ``forces.Fy`` are the same.

    Examples
    --------
    >>> forces = Forces({"Fx": np.array(1.0), "Fy": np.array(2.0)})
    >>> float(forces.Fy), list(forces)
    (2.0, ['Fx', 'Fy'])
    """

    def __init__(self, values: Mapping[str, FloatArray]) -> None:
        self._values = dict(values)

    def __getitem__(self, name: str) -> FloatArray:
        return self._values[name]

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("_values", {})
        if name not in values:
            raise AttributeError(f"this model has no output {name}")
        return values[name]  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Forces({', '.join(f'{name}={value}' for name, value in self._values.items())})"


@dataclass(frozen=True)
class Tire:
    """A tire with values for every coefficient of its model.

    Parameters
    ----------
    model : str
        Name of the model, such as "mf96".
    values : mapping of str to float
        Coefficients by .tir name in SI units; those left out take the model's default in these signs
        (`defaulted` lists them). FNOMIN and UNLOADED_RADIUS cannot be left out.
    effects : collection of str, optional
        The effects that the tire has; all of the model where None. Coefficients that only an absent effect
        reads are set to neutral.
    signs : str
        The convention in which the coefficients are written: "iso" (default) or "adapted-sae".
    name : str
    about : mapping of str to str
        Where the tire comes from: source, fit, remarks; the keys are lower-case words.
    ranges : mapping of str to (float, float)
        The inputs' range in which the tire is known, by input name.

    Raises
    ------
    UnknownName
        If the model, an effect, a coefficient or an input does not exist.
    TireError
        If a value is not a finite number, an indispensable one is missing, or a range is crossed.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> round(float(tire.forces(alpha=0.1, Fz=1000.0)["Fy"]))
    1886
    """

    model: str
    values: Mapping[str, float]
    effects: Collection[str] | None = None
    signs: str = "iso"
    name: str = ""
    about: Mapping[str, str] = field(default_factory=dict)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    defaulted: tuple[str, ...] = field(init=False, default=(), compare=False)

    def __post_init__(self) -> None:
        if self.signs not in ("iso", "adapted-sae"):
            raise UnknownName("sign convention of a tire", self.signs, ("iso", "adapted-sae"))
        cards = self.book.coefficients
        present = frozenset(self.book.effects) if self.effects is None else self.book.known_effects(self.effects)
        for name in self.values:
            if name not in cards:
                raise UnknownName(f"coefficient of {self.model}", name, cards)
        for name in ("FNOMIN", "UNLOADED_RADIUS"):
            if name not in self.values:
                raise TireError(f"a tire needs {name} ({cards[name].description}, {cards[name].unit})")
        absent = self.book.owned(*sorted(self.book.effects.keys() - present))
        defaults = {name: card.default for name, card in cards.items()}
        values = defaults if self.signs == "adapted-sae" else _mirrored(cards, defaults)
        values |= {name: _number(name, value) for name, value in self.values.items() if name not in absent}
        object.__setattr__(self, "defaulted", tuple(name for name in cards if name not in self.values))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "effects", present)
        object.__setattr__(self, "about", {_word(key): str(text) for key, text in self.about.items()})
        object.__setattr__(self, "ranges", {name: _range(name, *r) for name, r in self.ranges.items()})

    @property
    def book(self) -> Model:
        """The model of the book."""
        return book(self.model)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs that the model reads."""
        return tuple(quantity.name for quantity in self.book.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the forces and moments that the model gives."""
        return tuple(quantity.name for quantity in self.book.outputs)

    @property
    def has(self) -> frozenset[str]:
        """The effects that the tire has."""
        return frozenset(self.effects or ())

    @property
    def rescaled(self) -> dict[str, float]:
        """Coefficients whose meaning an absent effect changes, and their factor in `parameters`.

        Examples
        --------
        >>> core = Tire("mf96", {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3}, effects=())
        >>> core.rescaled
        {'PKY1': 500000.0}
        """
        absent = (effect for name, effect in self.book.effects.items() if name not in self.has)
        return {name: factor for effect in absent for name, factor in effect.rescales}

    def parameters(self) -> FloatArray:
        """Return the parameter vector of the generated code, absent effects at neutral.

        Returns
        -------
        ndarray, shape (n_parameters,)
            In the order of ``PARAMETERS`` of the generated modules.
        """
        factors = self.rescaled
        values = [self.values[card.name] * factors.get(card.name, 1.0) for card in self.book.parameters]
        return np.array(values, dtype=np.float64)

    def in_signs(self, signs: str) -> Tire:
        """Return the same tire written in another convention.

        Parameters
        ----------
        signs : str
            "iso" or "adapted-sae".

        Returns
        -------
        Tire
            Its forces at an input are those of this tire with Fy, Mz and My reversed.
        """
        if signs == self.signs:
            return self
        given = {name: value for name, value in self.values.items() if name not in self.defaulted}
        return replace(self, values=_mirrored(self.book.coefficients, given), signs=signs)

    def nominal(self, name: str) -> float:
        """Return the value of an input that nobody gave."""
        (quantity,) = (quantity for quantity in self.book.inputs if quantity.name == name)
        return self.values[quantity.nominal] if isinstance(quantity.nominal, str) else quantity.nominal

    def forces(self, *, code: str = "numpy", **inputs: npt.ArrayLike) -> Forces:
        """Return forces and moments in the tire's own signs.

        Parameters
        ----------
        code : {"numpy", "c", "casadi"}
            Which generated code evaluates.
        **inputs : array_like
            kappa (fraction), alpha, gamma (rad), Fz (N) and what else the model reads, of shapes that
            broadcast; one left out takes its nominal value, one that the model does not read has no
            influence.

        Returns
        -------
        Forces
            Arrays of the broadcast shape, N and N m. Zero where Fz <= 0; NaN where an input is NaN.

        Raises
        ------
        UnknownName
            If an input is none of the public tables.
        """
        for name in inputs:
            if name not in TABLE_INPUTS:
                raise UnknownName("input", name, TABLE_INPUTS)
        columns = [np.asarray(inputs.get(name, self.nominal(name)), dtype=np.float64) for name in self.inputs]
        shape = np.broadcast_shapes(*(column.shape for column in columns))
        rows = np.stack([np.broadcast_to(column, shape).ravel() for column in columns])
        results = self._code(code).forces(rows, self.parameters())
        return Forces({name: row.reshape(shape) for name, row in zip(self.outputs, results, strict=True)})

    def evaluate(
        self, table: pd.DataFrame, *, signs: str = "iso", limits: bool = False, code: str = "numpy"
    ) -> pd.DataFrame:
        """Evaluate forces and every named quantity for each row of a table.

        Parameters
        ----------
        table : pandas.DataFrame
            Input columns in SI units, with the names of the public tables; an absent one takes the nominal
            value, other columns are left aside.
        signs : {"iso", "adapted-sae", "sae"}
            The table's convention; the result comes back in it. Named quantities are those of the formula
            written in it ("sae": in adapted SAE).
        limits : bool
            Clamp the inputs to the ranges in which the tire is known.
        code : {"numpy", "c", "casadi"}
            Which generated code evaluates.

        Returns
        -------
        pandas.DataFrame
            The input columns, the model's forces, the named quantities; the table's index.

        Raises
        ------
        DataError
            If an input is NaN or infinite.
        """
        formula = "iso" if signs == "iso" else "adapted-sae"
        reversed_columns(signs, formula)  # an unknown convention is an error before anything is computed
        tire = self.in_signs(formula)
        given = convert_signs(table, signs, formula)
        columns = {name: given.get(name, pd.Series(self.nominal(name), table.index)) for name in self.inputs}
        rows = np.stack([_finite(column, name) for name, column in columns.items()])
        if limits:
            bounds = np.array([self.ranges.get(name, (-np.inf, np.inf)) for name in self.inputs])
            rows = np.clip(rows, bounds[:, :1], bounds[:, 1:])
        generated, parameters = self._code(code), tire.parameters()
        forces = dict(zip(self.outputs, generated.forces(rows, parameters), strict=True))
        quantities = dict(zip(generated.quantities_names, generated.quantities(rows, parameters), strict=True))
        kept = table[[name for name in TABLE_INPUTS if name in table]]
        absent = pd.DataFrame({name: columns[name] for name in self.inputs if name not in table}, table.index)
        told = [convert_signs(part, formula, signs) for part in (absent, pd.DataFrame(forces, table.index))]
        return pd.concat([kept, *told, pd.DataFrame(quantities, table.index)], axis=1)

    def save(self, path: str | Path) -> None:
        """Write the tire as a .tir file, in ISO-W.

        Parameters
        ----------
        path : str or Path
        """
        from .tir import write_tir  # the file format knows the tire, not the tire the format

        write_tir(self, path)

    def _code(self, language: str) -> Code:
        return code_for(self.model, language)


def _number(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise TireError(f"{name} is {value!r}: a coefficient is a finite number")
    return number


def _mirrored(cards: Mapping[str, Coefficient], values: Mapping[str, float]) -> dict[str, float]:
    """Write coefficients in the other convention; a zero stays a plain 0.0."""
    return {name: -value if cards[name].flips and value else value for name, value in values.items()}


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


def _finite(column: pd.Series[float], name: str) -> FloatArray:
    """Return an input column as an array, or report its first row that is no finite number."""
    values = np.asarray(column, dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        what = "NaN" if np.isnan(values[bad[0]]) else "infinite"
        raise DataError(f"row {bad[0] + 1}: {name} is {what} ({bad.size} of {len(values)} rows)")
    return values
