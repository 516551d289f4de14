"""Declarations of a model apart from its lines: coefficients and their sections, quantities, options, effects.

Every package reads these declarations. The chapters load SymPy, and the declarations become SymPy terms there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

from .detection import Detection

if TYPE_CHECKING:
    import sympy as sp


@dataclass
class Coefficient:
    """A coefficient, declared once: every package reads this declaration.

    - `description`: what it is; begins in lower case, since it occurs in sentences, or with a symbol or a model: "Fy at
      ...", "MF5.2: ...".
    - `unit`: SI unit; "1" if it has none.
    - `lower`, `upper`: bounds of plausible tires, in adapted SAE signs.
    - `neutral`: the value at which the coefficient has no influence; None for an indispensable coefficient.
    - `start`: a generic initial value of a fit, in adapted SAE signs; the neutral value if None.
    - `flips`: true if its sign changes between adapted SAE and ISO (the same tire, written in the other axes).
    - `sided`: true if its sign changes when the tire is mounted on the other side of the vehicle; neutral at 0.
    - `assumed`: the value that other readers assume, in ISO-W, if a .tir file lacks the key; the default if None.
    - `channels`: the outputs from which it can be identified, the most informative first; those of its section if
      empty.
    - `fitted`: whether a fit frees it by default; as its section if None. If not, a stage of a recipe frees it by its
      name, or by that of a section without any coefficient that is fitted by default. A coefficient that a fit frees on
      request belongs to an effect with `optional = true`.
    - `name`, `section`: the .tir name and the .tir section, filled in by the class that declares it. A coefficient that
      the published model does not have belongs in a section "TIREFMU_...", which other programs skip.
    """

    description: str
    unit: str = "1"
    lower: float = -inf
    upper: float = inf
    neutral: float | None = 0.0
    start: float | None = None
    flips: bool = False
    sided: bool = field(default=False, kw_only=True)
    assumed: float | None = None
    channels: tuple[str, ...] = field(default=(), compare=False)
    fitted: bool | None = field(default=None, compare=False)
    name: str = field(default="", init=False)
    section: str = field(default="", init=False, compare=False)

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @property
    def published(self) -> bool:
        """Whether the published model has it, and so other programs."""
        return not self.section.startswith("TIREFMU")

    def __get__(self, instance: object, owner: type) -> sp.Symbol:
        from sympy import Symbol

        return Symbol(self.name, real=True)

    @property
    def default(self) -> float:
        """The default value of a tire: neutral, else the generic start.

        A neutral value beyond the bounds is a limit (PKY2: stiffness proportional to load), not a default.
        """
        lasting = self.neutral is not None and (self.start is None or self.lower <= self.neutral <= self.upper)
        value = self.neutral if lasting else self.start
        return float("nan") if value is None else value

    @property
    def generic(self) -> float:
        """The initial value of a fit."""
        return self.default if self.start is None else self.start


class Section:
    """A section of the .tir file; its coefficients are the class attributes.

    The class takes the section's title and, for the coefficients that do not declare them, the `channels` from which
    they can be identified (default: Fx, Fy and Mz) and whether a fit frees them by default (`fitted`).

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
        cls.coefficients = {name: declared for name, declared in vars(cls).items() if isinstance(declared, Coefficient)}
        for declaration in cls.coefficients.values():
            declaration.section = title
            declaration.channels = declaration.channels or channels
            declaration.fitted = fitted if declaration.fitted is None else declaration.fitted


@dataclass(frozen=True)
class Quantity:
    """An input or an output of a model, with its unit.

    - `name`: the table's column.
    - `unit`: SI unit; "1" where it has none.
    - `nominal`: the value of an absent input: a number, or the coefficient that holds it.
    - `typical`: a typical value, for scaling.
    - `lower`: limit of the physical range. At and below it a tire is lifted, flat or at rest, or rolls in reverse.
    """

    name: str
    unit: str
    description: str
    nominal: str | float = 0.0
    typical: float = 1.0
    lower: float = -inf

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this quantity."""
        from sympy import Symbol

        return Symbol(self.name, real=True)


@dataclass(frozen=True)
class Option:
    """A named convention, chosen when a tire is evaluated.

    It is not a property of the tire. In generated code it is an entry of the parameter vector after the coefficients,
    in upper case: 0 for the first value, 1 for the second.

    - `values`: the default first.

    >>> import sympy as sp
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
        from sympy import Symbol, sympify

        from .notation import Choice

        return Choice(Symbol(self.parameter, real=True), sympify(first), sympify(second))


@dataclass(frozen=True)
class Effect:
    """A named physical phenomenon that a model has or lacks, with all its terms in the lines.

    Its coefficients are not declared: they are those that reach no output when the effect is off
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
        Whether a tire has it only if it is requested by name.
    detection : Detection or None
        How a diagnosis tests it. Without it, a diagnosis tests only a model's own and user-defined effects.

    Examples
    --------
    >>> import sympy as sp
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
        from sympy import Symbol, sympify

        from .notation import Switch

        return Switch(Symbol(self.name), sympify(on), sympify(off))

    def term(self, expression: Any) -> sp.Expr:
        """Return a term that is 0 without this effect."""
        return self.either(expression, 0)

    def factor(self, expression: Any) -> sp.Expr:
        """Return a factor that is 1 without this effect."""
        return self.either(expression, 1)
