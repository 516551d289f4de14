"""A model: an ordered table of named lines, and all that other packages need of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from types import new_class

import sympy as sp

from ..added import AddedEffect
from ..added.checks import check_effects
from ..contract import PhysicalConstraint, PropertyFile, Role
from ..detection import Detection
from ..effects import EFFECTS
from ..errors import EffectError, UnknownName, nearest, no_single_text
from ..escaping import quoted
from ..notation import Chapter, Choice, Coefficient, Effect, Equation, Option, Quantity, Section, Variant
from ..options import OPTIONS, signs
from ..quantities import BEYOND
from .lines import decided, reaching, reduced, switched, switches

#: Coefficients of every model: other packages scale loads and lengths by them.
INDISPENSABLE = ("FNOMIN", "UNLOADED_RADIUS")


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """A tire model: its lines, and all that other packages have to know of it.

    Attributes
    ----------
    name : str
        As on the command line: a lower-case word.
    title : str
    inputs, outputs : tuple of Quantity
        kappa and alpha first, Fz among them; Fx and Fy among the outputs.
    sections : tuple of type[Section]
        The coefficients, by .tir section.
    chapters : tuple of Chapter
        The lines, in an order in which each uses only earlier ones.
    results : tuple of str
        Named quantities that are results in addition to the outputs, such as radii: a coefficient that reaches
        one of them is not idle.
    on_demand : tuple of (str, str)
        Effects that act only in rows in which an input is not 0, and the input's name (turn_slip: phit).
    own_effects : tuple of Effect
        Effects of its lines that `tirefmu.symbolic.effects` does not have.
    roles : mapping of str to Role
        Which named quantity has which of `tirefmu.symbolic.contract.ROLES`; it lacks the others.
    property_file : PropertyFile
        How its .tir files are recognized and written.
    constraints : mapping of str to tuple of PhysicalConstraint
        What a fit enforces, by the output that it belongs to.
    recipe : str
        The default fit recipe: one of the package's, or of its own.
    recipes : tuple of str
        Its own recipes: ``<name>.toml`` in its folder.
    folder : str
        Its package, with these files: ``__name__`` of the folder's ``__init__.py``.
    baseline : tuple of str
        The coefficients that a tire without effects is fitted by.
    starts : tuple of mapping of str to float
        Several starts of the baseline in adapted SAE, against local optima; others start at generic values.
    spread : mapping of str to float
        Standard deviation among tires of coefficients of the baseline that a recording may leave undetermined.
    refinements : tuple of mapping of str to float
        Refinements of the baseline that a diagnosis tries: coefficients and sizes to probe with, in adapted SAE.
    relaxation : tuple of str
        The coefficients of its relaxation lengths, which act through time only.
    own_relaxation : tuple of str
        The coefficient that scales relaxation lengths which follow from other coefficients, then those that must be
        known for it. An FMU with wheel inputs uses these lengths if the tire has no relaxation.
    low_speed : str
        The coefficient below whose speed, m/s, slips are those of a standing wheel, if it has one.
    added : tuple of AddedEffect
        Effects beyond the book; see `extended`.

    Examples
    --------
    >>> from tirefmu.symbolic import model
    >>> mf96 = model("mf96")
    >>> [quantity.name for quantity in mf96.inputs]
    ['kappa', 'alpha', 'gamma', 'Fz']
    >>> sorted(mf96.owned("camber_thrust"))
    ['PHY3', 'PVY3', 'PVY4']
    """

    name: str
    title: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    sections: tuple[type[Section], ...]
    chapters: tuple[Chapter, ...]
    results: tuple[str, ...] = ()
    on_demand: tuple[tuple[str, str], ...] = ()
    own_effects: tuple[Effect, ...] = ()
    roles: Mapping[str, Role] = field(default_factory=dict)
    property_file: PropertyFile = field(default_factory=PropertyFile)
    constraints: Mapping[str, tuple[PhysicalConstraint, ...]] = field(default_factory=dict)
    recipe: str = "joint"
    recipes: tuple[str, ...] = ()
    folder: str = ""
    baseline: tuple[str, ...] = ()
    starts: tuple[Mapping[str, float], ...] = ({},)
    spread: Mapping[str, float] = field(default_factory=dict)
    refinements: tuple[Mapping[str, float], ...] = ()
    relaxation: tuple[str, ...] = ()
    own_relaxation: tuple[str, ...] = ()
    low_speed: str = ""
    added: tuple[AddedEffect, ...] = ()

    def __repr__(self) -> str:
        return f"<Model {self.name}>"

    @cached_property
    def coefficients(self) -> dict[str, Coefficient]:
        """Every coefficient that a line reads, by .tir name, in the order of the parameter vector."""
        read = {str(symbol) for line in self.equations for symbol in line.expression.free_symbols}
        read |= {str(quantity.nominal) for quantity in self.inputs} | set(INDISPENSABLE)
        declarations = {
            name: declaration for section in self.sections for name, declaration in section.coefficients.items()
        }
        return {name: declaration for name, declaration in declarations.items() if name in read}

    @cached_property
    def options(self) -> tuple[Option, ...]:
        """The conventions that are chosen when the lines are evaluated."""
        read = {str(choice.args[0]) for line in self.equations for choice in line.expression.atoms(Choice)}
        return tuple(option for option in OPTIONS.values() if option.parameter in read)

    @cached_property
    def straight_options(self) -> tuple[Option, ...]:
        """The options that act where no effect on demand does, but for the signs, which straight lines read too."""
        rest = self.effects.keys() - {effect for effect, _ in self.on_demand}
        lines = reaching(self.lines(rest), [quantity.name for quantity in self.outputs])
        read = {symbol.name for line in lines for symbol in line.expression.free_symbols}
        return tuple(option for option in self.options if option.parameter in read and option != signs)

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The parameter vector of all generated code: the coefficients, then the options."""
        return (*self.coefficients, *(option.parameter for option in self.options))

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """Every line as written, with effects as switches and options as choices."""
        written = (equation for chapter in self.chapters for equation in chapter.equations)
        lines = [replace(line, expression=self._own(line.expression)) for line in written]
        for effect in self.added:
            lines = self._acted_on(lines, effect)
        return tuple(reaching(lines, self._targets(lines)))

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """The effects in the lines, in the order in which they occur first."""
        names = (str(switch.args[0]) for line in self.equations for switch in switches(line.expression))
        beyond = {
            effect.name: Effect(effect.name, effect.physics, optional=True, detection=effect.detection)
            for effect in self.added
        }
        beyond |= {effect.name: effect for effect in self.own_effects}
        return {name: beyond.get(name) or EFFECTS[name] for name in dict.fromkeys(names)}

    @cached_property
    def detections(self) -> dict[str, Detection]:
        """How a diagnosis looks for the effects that declare it."""
        return {name: effect.detection for name, effect in self.effects.items() if effect.detection is not None}

    @cached_property
    def prior_center(self) -> dict[str, float]:
        """Prior mean of coefficients without a neutral value, as declared by the effects."""
        return {name: value for one in self.detections.values() for name, value in one.prior_center.items()}

    @cached_property
    def prior_spread(self) -> dict[str, float]:
        """Prior standard deviation of coefficients: among tires, of the baseline and of the effects.

        Examples
        --------
        >>> from tirefmu.symbolic import model
        >>> model("mf61").prior_spread["PDY2"], model("mf61").prior_spread["PCY1"]
        (0.75, 0.2)
        """
        spread = {name: value for one in self.detections.values() for name, value in one.prior_spread.items()}
        return {**spread, **self.spread}

    def quantity(self, role: str) -> str:
        """Return the name of the quantity that has a role, or '' where the model lacks it."""
        return self.roles[role].quantity if role in self.roles else ""

    def leading(self, role: str) -> str:
        """Return the leading coefficient of a role's quantity, or ''."""
        return self.roles[role].leading if role in self.roles else ""

    def has_place_for(self, effect: AddedEffect) -> bool:
        """Return whether all that an added effect acts on and reads is there.

        Examples
        --------
        >>> from tirefmu.symbolic import model
        >>> from tirefmu.symbolic.added import library
        >>> [name for name, effect in library().items() if model("mf96").has_place_for(effect)]
        ['temp_friction', 'temp_stiffness', 'wear_drift']
        """
        named = {line.symbol.name for line in self.equations if line.named} | self.roles.keys()
        known = (
            {quantity.name for quantity in self.inputs}
            | BEYOND.keys()
            | {declaration.name for declaration in effect.declarations}
        )
        known |= {name for section in self.sections for name in section.coefficients}
        read = {symbol.name for act in effect.acts for symbol in act.expression.free_symbols}
        return named.issuperset(effect.acts_on) and known.issuperset(read)

    def extended(self, effects: Sequence[AddedEffect]) -> Model:
        """Return this model with effects beyond the book in its lines.

        Parameters
        ----------
        effects : sequence of AddedEffect

        Returns
        -------
        Model
            Of the same name. The effects are optional ones; inputs that they read come last.

        Raises
        ------
        EffectError
            If one acts on a quantity or reads a name that this model has not, has a name that means something else,
            or two disagree on a coefficient.

        Examples
        --------
        >>> from tirefmu.symbolic import model
        >>> from tirefmu.symbolic.added import library
        >>> warm = model("mf61").extended([library()["temp_friction"]])
        >>> warm.inputs[-1].name, sorted(warm.owned("temp_friction"))
        ('T', ['TMU1', 'TMU2', 'TREF'])
        """
        check_effects(effects)
        self._check_names(effects)
        read = {s.name for effect in effects for act in effect.acts for s in act.expression.free_symbols}
        inputs = (*self.inputs, *(quantity for name, quantity in BEYOND.items() if name in read))
        extended = replace(self, inputs=inputs, sections=(*self.sections, *_sections(effects)), added=tuple(effects))
        extended._check_added()
        return extended

    def _check_names(self, effects: Sequence[AddedEffect]) -> None:
        """Raise `EffectError` where an effect or a coefficient has a name that this model uses."""
        quantities = {quantity.name for quantity in (*self.inputs, *self.outputs, *BEYOND.values())}
        quantities |= {line.symbol.name for line in self.equations}
        declarations = {name for section in self.sections for name in section.coefficients}
        options = {option.parameter for option in OPTIONS.values()}
        taken = {**dict.fromkeys(quantities, "a quantity"), **dict.fromkeys(declarations, "a coefficient")}
        taken |= {**dict.fromkeys(options, "an option"), **dict.fromkeys(EFFECTS, "an effect")}
        for effect in effects:
            for name in (effect.name, *(declaration.name for declaration in effect.declarations)):
                if name in taken:
                    raise EffectError(f"effect {effect.name}: {name} is {taken[name]} of {self.name} already")

    def _check_added(self) -> None:
        """Raise `EffectError` where an added effect reads what is not computed before the line that it acts on."""
        known = {quantity.name for quantity in self.inputs}
        known |= {name for section in self.sections for name in section.coefficients}
        acts = [
            (act, _places(self.quantity(act.on) or act.on, self.equations, effect))
            for effect in self.added
            for act in effect.acts
        ]
        for line in self.equations:
            acting = [act for act, places in acts if line.symbol.name in places]
            for name in sorted({symbol.name for act in acting for symbol in act.expression.free_symbols} - known):
                raise EffectError(f"an effect on {line.symbol} reads {name!r}, which {self.name} has not"
                                  f" before it{nearest(name, known)}")  # fmt: skip
            known.add(line.symbol.name)

    def _acted_on(self, lines: list[Equation], effect: AddedEffect) -> list[Equation]:
        """Put an added effect into the lines of the quantities that it acts on."""
        places = {act.on: _places(self.quantity(act.on) or act.on, lines, effect) for act in effect.acts}
        switch = Effect(effect.name, effect.physics, optional=True)
        changed = []
        for line in lines:
            expression = line.expression
            for act in effect.acts:
                if line.symbol.name in places[act.on]:
                    acted = expression * act.expression if act.how == "factor" else expression + act.expression
                    expression = switch.either(acted, expression)
            changed.append(replace(line, expression=expression))
        return changed

    @cached_property
    def default_effects(self) -> frozenset[str]:
        """The effects that a tire has by default."""
        return frozenset(name for name, effect in self.effects.items() if not effect.optional)

    @cached_property
    def core(self) -> frozenset[str]:
        """Coefficients without a neutral value: the model needs them."""
        return frozenset(name for name, declaration in self.coefficients.items() if declaration.neutral is None)

    @cached_property
    def relaxing_effects(self) -> frozenset[str]:
        """The effects in the lines of the relaxation lengths: with one of them, slips lag."""
        lengths = {self.quantity("relaxation_x"), self.quantity("relaxation_y")}
        lines = (line for line in self.equations if line.symbol.name in lengths)
        return frozenset(str(switch.args[0]) for line in lines for switch in switches(line.expression))

    def lines(self, effects: Collection[str] | None = None, *, straight: bool = False) -> tuple[Equation, ...]:
        """Return the lines with effects switched.

        Parameters
        ----------
        effects : collection of str, optional
            The effects that the tire has; all of the model where None.
        straight : bool
            Omit what most rows do not need: effects on demand are off, options but the signs have their first
            value. Otherwise an option is read from the parameter vector, row by row.

        Returns
        -------
        tuple of Equation
            Without switches.

        Raises
        ------
        UnknownName
            If an effect is not one of this model.
        """
        present = set(self.effects if effects is None else self.known_effects(effects))
        if straight:
            present -= {effect for effect, _ in self.on_demand}
        left = {signs.parameter} if straight else {option.parameter for option in OPTIONS.values()}
        return reduced(self.equations, present, left)

    def as_written(self, effects: Collection[str]) -> dict[str, sp.Expr]:
        """Return every line's right-hand side with effects switched and options at their first value, no line gone.

        For reading; `lines` is what is printed as code.
        """
        present = self.known_effects(effects)
        return {line.symbol.name: decided(switched(line.expression, present), ()) for line in self.equations}

    def known_effects(self, names: Iterable[str]) -> frozenset[str]:
        """Return the names as a set, or raise `UnknownName` for one that this model has not."""
        no_single_text("effects", names)
        chosen = frozenset(names)
        for name in sorted(chosen - self.effects.keys()):
            raise UnknownName(f"effect of {self.name}", name, self.effects)
        return chosen

    def _own(self, expression: sp.Expr) -> sp.Expr:
        """Take this model's side wherever models that share a line differ."""
        return expression.replace(Variant, lambda name, own, others: own if str(name) == self.name else others)

    def _targets(self, lines: Iterable[Equation]) -> set[str]:
        """Return outputs and named quantities: a step that none of them uses belongs to another model."""
        return {quantity.name for quantity in self.outputs} | {line.symbol.name for line in lines if line.named}

    def live(self, effects: Collection[str] | None = None) -> frozenset[str]:
        """Return the coefficients that reach an output with these effects; the ranges of inputs always do."""
        return self._live(frozenset(self.effects if effects is None else effects))

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def _live(self, effects: frozenset[str]) -> frozenset[str]:
        outputs = {quantity.name for quantity in self.outputs} | set(self.results)
        symbols = {str(s) for line in reaching(self.lines(effects), outputs) for s in line.expression.free_symbols}
        ranges = {name for name, declaration in self.coefficients.items() if declaration.section.endswith("_RANGE")}
        return frozenset(symbols & self.coefficients.keys()) | ranges

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def owned(self, *effects: str) -> frozenset[str]:
        """Return the coefficients that reach no output once these effects are off.

        Parameters
        ----------
        *effects : str

        Returns
        -------
        frozenset of str
        """
        return self.live() - self.live(self.effects.keys() - self.known_effects(effects))


def _sections(effects: Sequence[AddedEffect]) -> list[type[Section]]:
    """Return a .tir section for each effect; a coefficient that two share is in the first."""
    seen: dict[str, Coefficient] = {}
    sections = []
    for effect in effects:
        for declaration in effect.declarations:
            if declaration.name in seen and seen[declaration.name] != declaration:
                raise EffectError(f"{declaration.name} of {effect.name} is another coefficient elsewhere")
        own = {
            declaration.name: copy(declaration) for declaration in effect.declarations if declaration.name not in seen
        }
        seen |= own
        if own:
            keywords = {"title": effect.section}
            sections.append(new_class(effect.name, (Section,), keywords, partial(_filled, own)))
    return sections


def _filled(declarations: dict[str, Coefficient], space: dict[str, object]) -> None:
    """Put declarations into a class body."""
    space.update(declarations)


def _places(name: str, lines: Sequence[Equation], effect: AddedEffect) -> set[str]:
    """Return the lines that an effect on a named quantity changes: its own, unless that reads one that acts for it."""
    named = [line.symbol.name for line in lines if line.named]
    if name not in named:
        raise EffectError(f"{effect.name} acts on {quoted(name)}, which is no named quantity{nearest(name, named)}")
    acting = {line.symbol.name for line in lines if line.acts_for == name}
    before = {line.symbol.name for line in reaching(lines, [name])}
    return acting if acting & before else {name, *acting}
