"""A model: an ordered table of named lines, and everything that other packages need.

The declarations and the structure of the lines (`structure.py`) suffice to read, evaluate, fit and export a tire. The
lines and SymPy are loaded when code is printed, an effect of a user is added or an equation is shown.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from importlib import import_module
from importlib.resources.abc import Traversable
from typing import TYPE_CHECKING

from ...boundary.errors import UnknownName, no_single_text
from ..added import AddedEffect
from ..added.checks import check_effects
from ..added.effect import sections_of
from ..added.state import LINES, State, couplings
from ..declarations import Coefficient, Effect, Option
from ..detection import LARGEST_IN_SIZES, Detection
from ..effects import EFFECTS
from ..options import OPTIONS, signs
from .declaration import ModelDeclaration
from .extension import check_names, further_inputs, further_results, has_place
from .structure import Structure, stored_structure

if TYPE_CHECKING:
    import sympy as sp

    from ..notation import Chapter, Equation

#: Coefficients of every model: other packages scale loads and lengths by them.
INDISPENSABLE = ("FNOMIN", "UNLOADED_RADIUS")


@dataclass(frozen=True, eq=False, repr=False)
class Model(ModelDeclaration):
    """A tire model: its declarations, and what follows from its lines.

    Attributes
    ----------
    stored : file
        The structure that is stored with the generated code, set by `use`; a changed model has none. The code is in
        the folders next to it.

    Examples
    --------
    >>> from tirefmu.symbolic.models import model_named
    >>> mf96 = model_named("mf96")
    >>> [quantity.name for quantity in mf96.inputs]
    ['kappa', 'alpha', 'gamma', 'Fz']
    >>> sorted(mf96.owned("camber_thrust"))
    ['PHY3', 'PVY3', 'PVY4']
    """

    stored: Traversable | None = field(default=None, init=False)

    def __repr__(self) -> str:
        return f"<Model {self.name}>"

    @cached_property
    def structure(self) -> Structure:
        """The structure of the lines: stored with the generated code, or derived from the lines.

        Raises
        ------
        ModelError
            If the stored structure does not fit the declarations.
        """
        if self.stored is not None:
            return stored_structure(self.stored, self._declared)
        from .derivation import structure_of

        return structure_of(
            self.equations,
            self._declared,
            required={str(quantity.nominal) for quantity in self.inputs} | set(INDISPENSABLE),
            outputs=[quantity.name for quantity in self.outputs],
            on_demand=[effect for effect, _ in self.on_demand],
            lengths={self.quantity("relaxation_x"), self.quantity("relaxation_y")},
        )

    def use(self, stored: Traversable) -> None:
        """Read the structure from a file when it is needed, instead of loading the lines."""
        object.__setattr__(self, "stored", stored)

    @cached_property
    def _declared(self) -> dict[str, Coefficient]:
        """Every declared coefficient, also those of other models with the same sections."""
        return {name: declaration for section in self.sections for name, declaration in section.coefficients.items()}

    @cached_property
    def coefficients(self) -> dict[str, Coefficient]:
        """Every coefficient that a line reads, by .tir name, in the order of the parameter vector."""
        return {name: self._declared[name] for name in self.structure.coefficients}

    @cached_property
    def options(self) -> tuple[Option, ...]:
        """The conventions that are chosen when the lines are evaluated."""
        return tuple(OPTIONS[name] for name in self.structure.options)

    @cached_property
    def plain_options(self) -> tuple[Option, ...]:
        """The options that act where no effect on demand does, but for the signs, which plain lines read too."""
        return tuple(OPTIONS[name] for name in self.structure.plain_options)

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The parameter vector of all generated code: the coefficients, then the options."""
        return (*self.coefficients, *(option.parameter for option in self.options))

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """Every line as written, with effects as switches and options as choices."""
        from .assembly import assembled

        chapters = [self._chapter(chapter) for chapter in self.source.chapters]  # all: one may file lines in another
        return assembled(self.name, chapters, self.added, self._quantities, self._outputs)

    def _chapter(self, chapter: str | Chapter) -> Chapter:
        if not isinstance(chapter, str):
            return chapter
        filed: Chapter = import_module(f"{self.source.folder}.{chapter}").eq
        return filed

    @property
    def _quantities(self) -> dict[str, str]:
        """The name of the quantity of each role, by role."""
        return {role: declared.quantity for role, declared in self.roles.items()}

    @property
    def _outputs(self) -> frozenset[str]:
        return frozenset(quantity.name for quantity in self.outputs)

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """The effects in the lines, in the order in which they occur first."""
        beyond = {
            effect.name: Effect(effect.name, effect.physics, optional=True, detection=effect.detection)
            for effect in self.added
        }
        beyond |= {effect.name: effect for effect in self.source.own_effects}
        return {name: beyond.get(name) or EFFECTS[name] for name in self.structure.effects}

    @cached_property
    def detections(self) -> dict[str, Detection]:
        """How a diagnosis looks for the effects that declare it."""
        return {name: effect.detection for name, effect in self.effects.items() if effect.detection is not None}

    @cached_property
    def prior_center(self) -> dict[str, float]:
        """Prior mean of coefficients without a neutral value, as declared by the effects."""
        return {name: value for detection in self.detections.values() for name, value in detection.prior_center.items()}

    @cached_property
    def prior_spread(self) -> dict[str, float]:
        """Prior standard deviation of coefficients: among tires, of the baseline and of the effects.

        Examples
        --------
        >>> from tirefmu.symbolic.models import model_named
        >>> model_named("mf61").prior_spread["PDY2"], model_named("mf61").prior_spread["PCY1"]
        (0.75, 0.2)
        """
        spread = {
            name: value for detection in self.detections.values() for name, value in detection.prior_spread.items()
        }
        probes = (probe for sizes in self.baseline.refinements for probe in sizes.items())
        refined = {name: LARGEST_IN_SIZES * abs(size) for name, size in probes}
        return {**spread, **refined, **self.baseline.spread}

    def quantity(self, role: str) -> str:
        """Return the name of the quantity that has a role, or '' if the model lacks it."""
        return self.roles[role].quantity if role in self.roles else ""

    def leading(self, role: str) -> str:
        """Return the leading coefficient of a role's quantity, or ''."""
        return self.roles[role].leading if role in self.roles else ""

    def has_place_for(self, effect: AddedEffect) -> bool:
        """Return whether the model has everything on which an added effect acts and that it reads.

        Examples
        --------
        >>> from tirefmu.symbolic.models import model_named
        >>> from tirefmu.symbolic.added import library
        >>> [name for name, effect in library().items() if not model_named("mf96").has_place_for(effect)]
        ['carcass_2nd_order', 'relax_slip', 'speed_friction']
        """
        named = self.structure.quantities.keys() | self.roles.keys()
        return has_place(effect, named, {quantity.name for quantity in self.inputs} | self._declared.keys())

    def extended(self, effects: Sequence[AddedEffect], stored: Traversable | None = None) -> Model:
        """Return this model with effects beyond the book in its lines.

        Parameters
        ----------
        effects : sequence of AddedEffect
            In the order in which their lines are inserted.
        stored : file, optional
            The structure of the result. Its lines, and with them the effects, were checked when it was printed.

        Returns
        -------
        Model
            Of the same name. The effects are optional ones; inputs that they read come last.

        Raises
        ------
        EffectError
            If one acts on a quantity or reads a name that this model lacks, has a name with another meaning, or two
            declare a coefficient differently.

        Examples
        --------
        >>> from tirefmu.symbolic.models import model_named
        >>> from tirefmu.symbolic.added import library
        >>> warm = model_named("mf61").extended([library()["temp_friction"]])
        >>> warm.inputs[-1].name, sorted(warm.owned("temp_friction"))
        ('T', ['TMU1', 'TMU2', 'TMUA', 'TREF'])
        """
        if stored is None:
            check_effects(effects)
            quantities = {quantity.name for quantity in (*self.inputs, *self.outputs)}
            lines = {line.symbol.name for line in self.equations}
            check_names(self.name, effects, quantities | lines, self._declared)
        inputs = (*self.inputs, *further_inputs(effects, self.inputs))
        results = (*self.results, *further_results(effects))
        sections = (*self.sections, *sections_of(effects))
        extended = replace(self, inputs=inputs, sections=sections, results=results, added=tuple(effects))
        if stored is None:
            extended._check_added({quantity.name for quantity in inputs} | extended._declared.keys())
        else:
            extended.use(stored)
        return extended

    def _check_added(self, names: set[str]) -> None:
        """Raise `EffectError` if an added effect reads what the lines, their inputs and coefficients do not have."""
        from .assembly import check_reads
        from .state_lines import check_oscillators, check_state_reads, check_temperatures

        check_reads(self.name, self.equations, self.added, self._quantities, names)
        check_state_reads(self.name, self.added, names | {line.symbol.name for line in self.equations})
        check_oscillators(self.states.values(), self.is_direct)
        check_temperatures(self.states.values())

    @cached_property
    def states(self) -> dict[str, State]:
        """The states of the added effects by name, in the order of the inputs."""
        return {state.name: state for effect in self.added for state in effect.states}

    def states_of(self, effects: Collection[str]) -> tuple[str, ...]:
        """Return the names of the states that these effects have."""
        used = {state.name for effect in self.added if effect.name in effects for state in effect.states}
        return tuple(name for name in self.states if name in used)

    @cached_property
    def state_lines(self) -> tuple[str, ...]:
        """The lines that determine the states, three for each, then `couplings`: results of a routine of this name."""
        of_states = [line for name in self.states for line in self._lines_of(name)[:3]]
        return (*of_states, *(line for line, _, _ in couplings(self.states.values())))

    def is_direct(self, state: State) -> bool:
        """Return whether a state depends on inputs only, not on a force or another state."""
        inputs = {quantity.name for quantity in self.inputs} - self.states.keys()
        return not state.follows_a_path and state.reads_only(inputs, self._declared)

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
        return frozenset(self.structure.relaxing_effects)

    def lines(self, effects: Collection[str] | None = None, *, plain: bool = False) -> tuple[Equation, ...]:
        """Return the lines with effects switched.

        Parameters
        ----------
        effects : collection of str, optional
            The effects that the tire has; all of the model where None.
        plain : bool
            Omit what most rows do not need: effects on demand are off, options except the signs have their first value.
            Otherwise an option is read from the parameter vector, row by row.

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
        if plain:
            present -= {effect for effect, _ in self.on_demand}
        left = {signs.parameter} if plain else {option.parameter for option in OPTIONS.values()}
        return self._reduced(frozenset(present), frozenset(left))

    @lru_cache(maxsize=64)  # noqa: B019  (models live as long as the program)
    def _reduced(self, present: frozenset[str], read: frozenset[str]) -> tuple[Equation, ...]:
        from .lines import reduced

        return reduced(self.equations, present, read)

    def as_written(self, effects: Collection[str]) -> dict[str, sp.Expr]:
        """Return every line's right-hand side with effects switched and options at their first value, no line gone.

        For reading; `lines` is what is printed as code.
        """
        from .lines import decided, switched

        present = self.known_effects(effects)
        return {line.symbol.name: decided(switched(line.expression, present), ()) for line in self.equations}

    def known_effects(self, names: Iterable[str]) -> frozenset[str]:
        """Return the names as a set, or raise `UnknownName` for one that this model has not."""
        no_single_text("effects", names)
        chosen = frozenset(names)
        for name in sorted(chosen - self.effects.keys()):
            raise UnknownName(f"effect of {self.name}", name, self.effects)
        return chosen

    def reached(self, targets: Iterable[str], effects: Collection[str] | None = None) -> frozenset[str]:
        """Return the inputs, coefficients, options and lines that named quantities and outputs depend on.

        Parameters
        ----------
        targets : iterable of str
            Outputs or named quantities.
        effects : collection of str, optional
            The effects that the tire has; all of the model where None.

        Returns
        -------
        frozenset of str
            Names of inputs, coefficients, options and lines.
        """
        present = self.effects if effects is None else effects
        needed = set(targets)
        reached = self.structure.reached(needed, present)
        while behind := {line for name in reached & self.states.keys() for line in self._lines_of(name)} - needed:
            needed |= behind  # a state is an input of the lines, but depends on them
            reached = self.structure.reached(needed, present)
        return reached

    def _lines_of(self, state: str) -> tuple[str, ...]:
        return tuple(f"{state}_{ending}" for ending in LINES)

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def read_by(self, effect: str) -> frozenset[str]:
        """Return the inputs behind what an effect adds to the core: the spin of turn slip reads the inclination.

        Examples
        --------
        >>> from tirefmu.symbolic.models import model_named
        >>> "gamma" in model_named("mf61").read_by("turn_slip"), "gamma" in model_named("mf61").read_by("plysteer")
        (True, False)
        """
        present, outputs = self.known_effects([effect]), self._outputs.union(self.results)
        added = self.structure.reached(outputs, present) - self.structure.reached(outputs, ())
        inputs = {quantity.name for quantity in self.inputs} - self.states.keys()
        return (added | self.structure.reached(added, present)) & inputs

    def live(self, effects: Collection[str] | None = None) -> frozenset[str]:
        """Return the coefficients that reach an output with these effects; the ranges of inputs always do."""
        return self._live(frozenset(self.effects if effects is None else effects))

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def _live(self, effects: frozenset[str]) -> frozenset[str]:
        ranges = {name for name, declaration in self.coefficients.items() if declaration.section.endswith("_RANGE")}
        return (self.reached(self._outputs.union(self.results), effects) & self.coefficients.keys()) | ranges

    @lru_cache(maxsize=256)  # noqa: B019  (models live as long as the program)
    def owned(self, *effects: str) -> frozenset[str]:
        """Return the coefficients that reach no output once these effects are off.

        Parameters
        ----------
        *effects : str
            Names of effects of the model.

        Returns
        -------
        frozenset of str
            Names of coefficients.
        """
        return self.live() - self.live(self.effects.keys() - self.known_effects(effects))
