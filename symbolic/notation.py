"""How the book is written: coefficients, quantities, effects, equations, chapters.

A chapter is a Python module that reads like the book. ``eq(...)`` files a line and returns its *symbol*, so
lines never swell into each other; everything else (switching effects off, printing, differentiating) is a
pass over the filed lines, see `tirefmu.symbolic.model`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, ClassVar

import sympy as sp

from .detection import Detection


@dataclass
class Coefficient:
    """A coefficient, declared once: every package reads this declaration.

    Attributes
    ----------
    description : str
        What it is.
    unit : str
        SI unit; "1" where it has none.
    lower, upper : float
        Bounds of plausible tires, in adapted SAE signs.
    neutral : float or None
        The value at which the coefficient does nothing; None for one that the model cannot do without.
    start : float or None
        A generic value to start a fit from, in adapted SAE signs; the neutral value where None.
    flips : bool
        True if its sign changes between adapted SAE and ISO (the same tire, written in the other axes).
    assumed : float or None
        What the field's readers take, in ISO-W, where a .tir file lacks the key; the default where None.
    channels : tuple of str
        The outputs from which it can be identified, the most informative first; those of its section if empty.
    fitted : bool or None
        Whether a fit may free it without naming it; as its section where None.
    name, section : str
        The .tir name and the .tir section, filled in by the class that declares it.
    """

    description: str
    unit: str = "1"
    lower: float = -inf
    upper: float = inf
    neutral: float | None = 0.0
    start: float | None = None
    flips: bool = False
    assumed: float | None = None
    channels: tuple[str, ...] = field(default=(), compare=False)
    fitted: bool | None = field(default=None, compare=False)
    name: str = field(default="", init=False)
    section: str = field(default="", init=False, compare=False)

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, instance: object, owner: type) -> sp.Symbol:
        return sp.Symbol(self.name, real=True)

    @property
    def default(self) -> float:
        """The default value of a tire: neutral, else the generic start.

        A neutral value beyond the bounds is a limit (PKY2: stiffness proportional to load), no default.
        """
        lasting = self.neutral is not None and (self.start is None or self.lower <= self.neutral <= self.upper)
        value = self.neutral if lasting else self.start
        return float("nan") if value is None else value

    @property
    def generic(self) -> float:
        """The value to start a fit from."""
        return self.default if self.start is None else self.start


class Section:
    """A section of the .tir file; its coefficients are the class attributes.

    The class takes the section's title and, for the coefficients that do not declare them, the `channels` from which
    they can be identified (default: Fx, Fy and Mz) and whether a fit may free them (`fitted`).

    Examples
    --------
    >>> class Shape(Section, title="SHAPE"):
    ...     CX = Coefficient("shape factor", start=1.5)
    >>> Shape.CX, Shape.coefficients["CX"].description
    (CX, 'shape factor')
    """

    title: ClassVar[str]
    coefficients: ClassVar[dict[str, Coefficient]]

    def __init_subclass__(
        cls, *, title: str, channels: tuple[str, ...] = ("Fx", "Fy", "Mz"), fitted: bool = True
    ) -> None:
        cls.title = title
        cls.coefficients = {name: each for name, each in vars(cls).items() if isinstance(each, Coefficient)}
        for declaration in cls.coefficients.values():
            declaration.section = title
            declaration.channels = declaration.channels or channels
            declaration.fitted = fitted if declaration.fitted is None else declaration.fitted


@dataclass(frozen=True)
class Quantity:
    """An input or an output of a model, with its unit.

    Attributes
    ----------
    name : str
        The table's column.
    unit : str
        SI unit; "1" where it has none.
    description : str
    nominal : str or float
        The value of an absent input: a number, or the coefficient that holds it.
    typical : float
        A typical value, for scaling.
    """

    name: str
    unit: str
    description: str
    nominal: str | float = 0.0
    typical: float = 1.0

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this quantity."""
        return sp.Symbol(self.name, real=True)


class Switch(sp.Function):
    """A term of a line that an effect owns: ``Switch(effect, on, off)``. Gone before anything is printed."""

    nargs = 3


class Choice(sp.Function):
    """A term of a line that an option decides: ``Choice(option, first, second)``."""

    nargs = 3


class Variant(sp.Function):
    """A term in which the models that share a line differ: ``Variant(model, its own, the others')``."""

    nargs = 3


@dataclass(frozen=True)
class Option:
    """A named convention, chosen when a tire is evaluated.

    It is no property of the tire. In generated code it is an entry of the parameter vector behind the
    coefficients, in upper case: 0 for the first value, 1 for the second.

    Attributes
    ----------
    name : str
    values : (str, str)
        The default first.
    description : str

    Examples
    --------
    >>> slip_angle = Option("slip_angle", ("tan", "angle"), "what alpha* is")
    >>> slip_angle.either(sp.tan(sp.Symbol("alpha")), sp.Symbol("alpha"))
    Choice(SLIP_ANGLE, tan(alpha), alpha)
    """

    name: str
    values: tuple[str, str]
    description: str

    @property
    def parameter(self) -> str:
        """Its name in the parameter vector."""
        return self.name.upper()

    def either(self, first: Any, second: Any) -> sp.Expr:
        """Return a term that is `first` by default and `second` with the other value."""
        return Choice(sp.Symbol(self.parameter, real=True), sp.sympify(first), sp.sympify(second))


def only(model: str, own: Any, others: Any) -> sp.Expr:
    """Return a term that is `own` in one model and `others` in the others that share the line.

    Examples
    --------
    >>> only("mf52", sp.Symbol("PHY3"), 0)
    Variant(mf52, PHY3, 0)
    """
    return Variant(sp.Symbol(model), sp.sympify(own), sp.sympify(others))


@dataclass(frozen=True)
class Effect:
    """A named physical phenomenon that a model has or lacks, with all its terms in the lines.

    Which coefficients it owns is not written down: they are those that reach no output when it is off
    (`tirefmu.symbolic.model.Model.owned`).

    Attributes
    ----------
    name : str
        The public name, as on the command line.
    physics : str
        What happens in the tire, in a sentence.
    rescales : tuple of (str, float)
        Coefficients whose meaning changes when the effect is off, and the factor by which a file written
        for readers without switches multiplies them (all owned coefficients at neutral).
    optional : bool
        True for one that a tire has only if it is requested by name.
    detection : Detection or None
        How a diagnosis looks for it; without it, a diagnosis tries a model's own and user-defined effects only.

    Examples
    --------
    >>> camber = Effect("camber_friction", "friction falls with inclination")
    >>> camber.factor(1 - sp.Symbol("PDY3") * sp.Symbol("gamma") ** 2)
    Switch(camber_friction, -PDY3*gamma**2 + 1, 1)
    """

    name: str
    physics: str
    rescales: tuple[tuple[str, float], ...] = ()
    optional: bool = False
    detection: Detection | None = None

    def either(self, on: Any, off: Any) -> sp.Expr:
        """Return a term that is `on` with this effect and `off` without it."""
        return Switch(sp.Symbol(self.name), sp.sympify(on), sp.sympify(off))

    def term(self, expression: Any) -> sp.Expr:
        """Return a term that is 0 without this effect."""
        return self.either(expression, 0)

    def factor(self, expression: Any) -> sp.Expr:
        """Return a factor that is 1 without this effect."""
        return self.either(expression, 1)


@dataclass(frozen=True)
class Equation:
    """One line of the book.

    Attributes
    ----------
    number : str
        Number in the book, or the name of the source that has the line.
    symbol : sympy.Symbol
        What the line defines.
    expression : sympy.Expr
        Its right-hand side in coefficients, inputs and earlier symbols.
    unit, description, chapter : str
    named : bool
        False for a step inside another line that users need not see.
    acts_for : str
        The named quantity whose added effects change this line too; see `tirefmu.symbolic.model.Model.extended`.
    variant : bool
        True for a repetition of the line at other operating conditions, such as without inclination.
    """

    number: str
    symbol: sp.Symbol
    expression: sp.Expr
    unit: str
    description: str
    chapter: str
    named: bool = True
    acts_for: str = ""
    variant: bool = False


@dataclass
class Chapter:
    """A chapter of the book: calling it files a line and returns the line's symbol.

    Examples
    --------
    >>> eq = Chapter("Side force")
    >>> eq("4.E20", "alpha_y", sp.Symbol("alpha") + sp.Symbol("S_Hy"), "rad", "shifted slip angle")
    alpha_y
    >>> eq.equations[0].expression
    S_Hy + alpha
    """

    title: str
    equations: list[Equation] = field(default_factory=list)

    def __call__(
        self,
        number: str,
        name: str,
        expression: Any,
        unit: str = "1",
        description: str = "",
        *,
        named: bool = True,
        at: str = "",
        acts_for: str = "",
    ) -> sp.Symbol:
        """File a line and return its symbol; `at` is the ending of the same line under other conditions."""
        symbol = sp.Symbol(f"{name}{at}", real=True)
        filed = Equation(number, symbol, sp.sympify(expression), unit, description, self.title, named)
        self.equations.append(replace(filed, acts_for=acts_for or (name if at else ""), variant=bool(at)))
        return symbol


@dataclass(frozen=True)
class MagicFormula:
    """The Magic Formula over one slip, its cosine form and its slope, sharing the inner steps.

    Attributes
    ----------
    sine : sympy.Expr
        D sin(C atan(Bx - E (Bx - atan Bx))), Pacejka (2012), eq. (4.1).
    cosine : sympy.Expr
        The same with the cosine, for the pneumatic trail and the weighting functions, eq. (4.59).
    slope : sympy.Expr
        d(sine)/dx with B, C, D and E held constant.
    """

    sine: sp.Expr
    cosine: sp.Expr
    slope: sp.Expr


def magic(eq: Chapter, name: str, B: sp.Expr, C: sp.Expr, D: sp.Expr, E: sp.Expr, x: sp.Expr) -> MagicFormula:
    """File the inner steps of the Magic Formula as lines and return its three forms.

    Parameters
    ----------
    eq : Chapter
    name : str
        Symbol of the quantity that it makes; the steps are called ``<name>_u``, ``_v`` and ``_w``.
    B, C, D, E : sympy.Expr
        Stiffness, shape, peak and curvature factor.
    x : sympy.Expr
        Slip, shifted.

    Returns
    -------
    MagicFormula

    References
    ----------
    Pacejka, Tire and Vehicle Dynamics (2012), eq. (4.1); the slope with constant E is the Trento worksheet's
    magic_formula_stiffness.
    """
    u = eq("4.1", f"{name}_u", B * x, description="B x", named=False)
    v = eq("4.1", f"{name}_v", u - E * (u - sp.atan(u)), description="B x bent by E", named=False)
    w = eq("4.1", f"{name}_w", C * sp.atan(v), "rad", "angle of the Magic Formula", named=False)
    slope = D * C * sp.cos(w) / (1 + v**2) * B * (1 - E + E / (1 + u**2))
    return MagicFormula(D * sp.sin(w), D * sp.cos(w), slope)


#: Half width squared of the smoothed sign, as the Trento worksheet has it.
SIGN_SMOOTHING = sp.Float("1e-6")


def smooth_sign(eq: Chapter, name: str, x: sp.Expr) -> sp.Symbol:
    """File the sign of x without its jump, x / sqrt(x^2 + 1e-6), and return its symbol.

    It is the Trento worksheet's Sign; 0 at 0.

    Examples
    --------
    >>> eq = Chapter("Side force")
    >>> smooth_sign(eq, "sign_alpha_y", sp.Symbol("alpha_y"))
    sign_alpha_y
    """
    return eq("Trento", name, x / sp.sqrt(x**2 + SIGN_SMOOTHING), description="smoothed sign", named=False)
