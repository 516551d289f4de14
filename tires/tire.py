"""A tire: a model of the book, the effects that it has, and the values of its coefficients."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.symbolic import model as book
from tirefmu.symbolic import with_library
from tirefmu.symbolic.added import AddedEffect, library
from tirefmu.symbolic.errors import TireError, UnknownName
from tirefmu.symbolic.model import INDISPENSABLE, Model
from tirefmu.symbolic.notation import Coefficient
from tirefmu.symbolic.options import OPTIONS

from .code import Code, code_for, fastest_code
from .evaluation import Conventions, evaluate
from .forces import Forces
from .signs import TABLE_INPUTS
from .summary import tire_html, tire_text
from .table_argument import table_from

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
        The inputs' range in which the tire is known, by input name. Where the model has coefficients for a
        range (KPUMIN, KPUMAX, ...) the two are one.
    side : str
        The side of the vehicle that the coefficients stand for, TYRESIDE of the file: "left", "right" or "".
        It changes nothing by itself; see `mirror` of `evaluate`.
    added : tuple of AddedEffect
        Effects beyond the book. Those of the library are added by their names in `effects`.
    kept : tuple of (str, str, str)
        Section, key and text of what a file said beyond the model, written again when the tire is saved.

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
    side: str = ""
    added: tuple[AddedEffect, ...] = ()
    kept: tuple[tuple[str, str, str], ...] = ()
    defaulted: tuple[str, ...] = field(init=False, default=(), compare=False)

    def __post_init__(self) -> None:
        if self.signs not in ("iso", "adapted-sae"):
            raise UnknownName("sign convention of a tire", self.signs, ("iso", "adapted-sae"))
        if self.side not in ("left", "right", ""):
            raise UnknownName("side of the vehicle", self.side, ("left", "right"))
        object.__setattr__(self, "added", with_library(self.model, self.effects or (), self.added))
        cards = self.book.coefficients
        present = self._present()
        given = {**self._range_values(), **self.values}
        for name in given:
            if name not in cards:
                raise UnknownName(f"coefficient of {self.model}", name, cards)
        for name in INDISPENSABLE:
            if name not in given:
                raise TireError(f"a tire needs {name} ({cards[name].description}, {cards[name].unit})")
        absent = self.book.owned(*sorted(self.book.effects.keys() - present))
        defaults = {name: card.default for name, card in cards.items()}
        values = defaults if self.signs == "adapted-sae" else _mirrored(cards, defaults)
        neutral = {name: cards[name].neutral for name in absent}
        values |= {name: value for name, value in neutral.items() if value is not None}
        values |= {name: _number(name, value) for name, value in given.items() if name not in absent}
        object.__setattr__(self, "defaulted", tuple(name for name in cards if name not in given))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "effects", present)
        object.__setattr__(self, "about", {_word(key): str(text) for key, text in self.about.items()})
        known = {name: pair for name, pair in RANGES.items() if set(pair) <= given.keys()}
        ranges = {**self.ranges, **{name: (values[low], values[high]) for name, (low, high) in known.items()}}
        object.__setattr__(self, "ranges", {name: _range(name, *r) for name, r in ranges.items()})

    def _present(self) -> frozenset[str]:
        if self.effects is None:
            return self.book.usual_effects | {effect.name for effect in self.added if effect.name not in library()}
        for name in self.effects:
            if name not in self.book.effects:
                raise UnknownName(f"effect of {self.model}", name, [*self.book.effects, *library()])
        return frozenset(self.effects)

    def _range_values(self) -> dict[str, float]:
        """Return the given ranges as coefficients of the model, where it has them."""
        cards = self.book.coefficients
        pairs = ((RANGES[name], ends) for name, ends in self.ranges.items() if name in RANGES)
        return {key: end for keys, ends in pairs for key, end in zip(keys, ends, strict=True) if key in cards}

    @cached_property
    def book(self) -> Model:
        """The model of the book, the added effects in its lines."""
        return book(self.model, self.added)

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

    def parameters(self, **options: str) -> FloatArray:
        """Return the parameter vector of the generated code, absent effects at neutral.

        Parameters
        ----------
        **options : str
            Conventions by name (`tirefmu.symbolic.options`), the default where left out; those that the model
            does not have are left aside.

        Returns
        -------
        ndarray, shape (n_parameters,)
            In the order of ``PARAMETERS`` of the generated modules.

        Raises
        ------
        UnknownName
            If an option or its value does not exist.
        """
        factors = self.rescaled
        values = [self.values[name] * factors.get(name, 1.0) for name in self.book.coefficients]
        chosen = {"signs": self.signs, **options}
        for name, value in chosen.items():
            if name not in OPTIONS:
                raise UnknownName("option", name, OPTIONS)
            if value not in OPTIONS[name].values:
                raise UnknownName(f"value of {name}", value, OPTIONS[name].values)
        places = [option.values.index(chosen.get(option.name, option.values[0])) for option in self.book.options]
        return np.array([*values, *places], dtype=np.float64)

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

    def with_values(self, **coefficients: float) -> Tire:
        """Return the same tire with other values of some coefficients.

        Parameters
        ----------
        **coefficients : float
            By .tir name, SI, in the signs of the tire. Bounds of a fit are not enforced.

        Returns
        -------
        Tire

        Raises
        ------
        UnknownName
            If the model has no such coefficient.
        TireError
            If a value is not a finite number, or only an effect that the tire does not have reads it.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> softer = published("trento_hoosier").with_values(PDY1=2.5)
        >>> softer.values["PDY1"]
        2.5
        """
        given = {name: value for name, value in self.values.items() if name not in self.defaulted}
        changed = replace(self, values={**given, **coefficients})
        for name, value in coefficients.items():
            if changed.values[name] != float(value):
                effects = [effect for effect in self.book.effects if name in self.book.owned(effect)]
                raise TireError(f"{name} has no influence: the tire does not have {' or '.join(effects)}")
        return changed

    def nominal(self, name: str) -> float:
        """Return the value of an input that nobody gave."""
        (quantity,) = (quantity for quantity in self.book.inputs if quantity.name == name)
        if isinstance(quantity.nominal, str):  # a formula may read T without a card for its reference
            return self.values.get(quantity.nominal, quantity.typical)
        return quantity.nominal

    def forces(self, *, code: str = "auto", **inputs: npt.ArrayLike) -> Forces:
        """Return forces and moments in the tire's own signs, in steady state.

        Parameters
        ----------
        code : {"auto", "numpy", "c", "casadi", "batch"}
            Which generated code evaluates; "auto": NumPy for few rows, the batch kernel for many where there is
            a compiler.
        **inputs : array_like
            kappa (fraction), alpha, gamma (rad), Fz (N), p (Pa), V (m/s), phit (1/m), of shapes that
            broadcast; one left out takes its nominal value, one that the model does not read has no
            influence. The conventions of `evaluate` are at their defaults.

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
        results = self._code(code, rows.shape[1]).forces(self.asked(rows), self.parameters())
        return Forces({name: row.reshape(shape) for name, row in zip(self.outputs, results, strict=True)})

    def evaluate(
        self,
        table: pd.DataFrame | Any,
        *,
        signs: str | None = None,
        convention: str = "tno",
        slip_angle: str = "tan",
        limits: bool = False,
        mirror: bool = False,
        steady: bool = False,
        hold: bool = False,
        code: str = "auto",
    ) -> pd.DataFrame:
        """Evaluate forces and every named quantity for each row of a table.

        Parameters
        ----------
        table : pandas.DataFrame, path or Recording
            Input columns in SI units, with the names of the public tables; an absent one takes the nominal
            value, other columns are left aside. Files and recordings are checked as every command does; a
            DataFrame may hold any finite inputs.
        signs : {"iso", "adapted-sae", "sae"}, optional
            The table's convention; the result comes back in it. Where None: "iso" for a DataFrame, that of the
            format for a file, a recording's own. Named quantities are those of the formula written in it
            ("sae": in adapted SAE).
        convention : {"tno", "book"}
            As the industry's solvers compute, or as Pacejka (2012), section 4.E, prints. MF96 has one form.
        slip_angle : {"tan", "angle"}
            alpha* and gamma*: tangent and sine, or the angles themselves. MF96 has the angles.
        limits : bool
            Keep the inputs within the ranges in which the tire is known; in MF5.2 to 6.2 slips also fade out
            below VXLOW and curvature factors are 1 at most.
        mirror : bool
            Evaluate the tire as mounted on the other side of the vehicle than the one it was measured for.
            Named quantities are those of the tire as measured, at mirrored inputs.
        steady : bool
            Evaluate each row for itself. Otherwise, where the table has a column t and the tire a relax_*
            effect, slips lag behind the inputs from row to row; the columns ``kappa_lagged`` and
            ``alpha_lagged`` are those that act.
        hold : bool
            Inputs are held over each step, as in a co-simulation; otherwise they are linear between rows.
        code : {"auto", "numpy", "c", "casadi", "batch"}
            Which generated code evaluates; "auto": NumPy for few rows, the batch kernel for many where there is
            a compiler.

        Returns
        -------
        pandas.DataFrame
            The input columns, the model's forces, the named quantities; the table's index.

        Raises
        ------
        DataError
            If an input is NaN or infinite, or a file or recording cannot be used.
        UnknownName
            If a convention does not exist.
        WrongType
            If it is not a table.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> table = pd.DataFrame({"alpha": [0.0, -0.1], "Fz": 1000.0})
        >>> published("trento_hoosier").evaluate(table)["Fy"].round().tolist()
        [-89.0, 1948.0]
        """
        table, written = table_from(table, signs)
        conventions = Conventions(written, convention, slip_angle, limits, mirror, steady, hold)
        return evaluate(self, table, conventions, self._code(code, len(table)))

    def save(self, path: str | Path) -> None:
        """Write the tire as a .tir file, in ISO-W.

        Parameters
        ----------
        path : str or Path
        """
        from .property_file.writing import write_tir  # the file format knows the tire, not the tire the format

        write_tir(self, path)

    def plot(self, kind: str = "pure", *, loads: Sequence[float] | None = None, signs: str = "iso") -> Figure:
        r"""Draw the tire.

        Parameters
        ----------
        kind : {"pure", "surfaces", "combined"}
            Fx over kappa, Fy and Mz over alpha in pure slip; Fx and Fy over both slips; Fy against Fx.
        loads : sequence of float, N, optional
            Three over the tire's range where None. Surfaces are drawn at the middle one.
        signs : {"iso", "adapted-sae", "sae"}
            Convention in which the figure is drawn.

        Returns
        -------
        matplotlib.figure.Figure
            Of its own, not one of pyplot's: ``figure.savefig("tire.png")`` writes it.

        Raises
        ------
        UnknownName
            If the kind or the convention does not exist.
        TirefmuError
            If a load is not positive, or the tire makes no force or one that is not finite.

        Examples
        --------
        >>> from tirefmu.tires import published
        >>> figure = published("unicamp_small_tire").plot(loads=[110.0])
        >>> [ax.get_title() for ax in figure.axes][1]
        '$F_y$ over $\\alpha$ at $\\kappa$ = 0'
        """
        from .drawing import plot  # matplotlib takes its time

        return plot(self, kind, loads=loads, signs=signs)

    def __repr__(self) -> str:
        """Return a few lines: model, signs, nominal inputs, ranges, effects."""
        return tire_text(self)

    def _repr_html_(self) -> str:
        """Return the same as a table, and the coefficients, for a notebook."""
        return tire_html(self)

    def _code(self, language: str, n_rows: int) -> Code:
        return fastest_code(self.book, n_rows) if language == "auto" else code_for(self.book, language)

    @property
    def lags(self) -> bool:
        """True if slips lag behind their inputs: the tire has an effect of relaxation, such as relax_lat."""
        return bool(self.has & self.book.relaxing_effects)

    def asked(self, rows: FloatArray) -> FloatArray:
        """Return the rows of inputs without what would ask for an effect that the tire has not."""
        silent = [place for effect, place in self.book.on_demand if effect not in self.has]
        return np.where(np.isin(self.inputs, silent)[:, None], 0.0, rows) if silent else rows


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
