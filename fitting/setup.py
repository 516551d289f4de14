"""The setup of a fit: everything that is decided before its first stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import pandas as pd

from ..boundary.errors import FitError, TirError, UnknownName, WrongType, no_single_text
from ..measurements import Recording
from ..measurements.nominal_values import NOMINAL, check_nominal, check_radius, rounded_median
from ..numerics.arrays import FloatArray
from ..symbolic import DEFAULT_MODEL
from ..symbolic.model import Model
from ..symbolic.models import model_named, with_library
from ..tires import TireLike, tire_from
from ..tires.code.printed import model_with
from ..tires.property_file.names import not_given
from ..tires.tire import Tire
from .constraints.physical import Constraint, chosen_constraints, operating_range
from .constraints.verification import VerifiedConstraints
from .data.dimensions import dimensions
from .data.fit_data import FitData, prepare
from .data.initial_values import starting_values
from .family import Family
from .options import FitOptions
from .problem.loss import Loss, loss_named
from .problem.recipe import Recipe, load_recipe
from .problem.rows import Rows
from .problem.weights import emphasis
from .solvers.selection import Solver, solver_for

#: Value of `start` for initial values that are read from the data.
FEATURES = "features"
#: Radius that is assumed for a tire of unknown radius, m. Forces do not depend on it.
UNKNOWN_RADIUS = 0.3


@dataclass(frozen=True)
class Plan:
    """What is fitted, without the data: the arguments of a fit, checked.

    - `model`: with the added effects of the start tire and the requested ones of the library.
    - `start`: the start tire.
    - `features`: whether initial values are read from the data.
    - `constraints`: constraints to enforce, by output.
    - `family`: the prior of the coefficients.
    """

    options: FitOptions
    symbolic_model: Model
    start: Tire | None
    features: bool
    recipe: Recipe
    constraints: Mapping[str, Sequence[Constraint]]
    solver: Solver
    loss: Loss
    family: Family | None = None

    @classmethod
    def of(cls, model_name: str | None, start: TireLike | None, options: FitOptions) -> Plan:
        """Check the arguments of a fit.

        `model`: by default the model of the start tire, or the default model. Raises `UnknownName`, `FitError`,
        `WrongType` if an argument names something unknown, or arguments contradict each other.
        """
        features = isinstance(start, str) and start == FEATURES and not Path(start).is_file()
        tire = None if start is None or features else _start_tire(start, (options.nominal or {}).get("R0"))
        model = model_named(model_name if model_name is not None else tire.model if tire else DEFAULT_MODEL)
        no_single_text("effects", options.effects)
        requested = options.effects if options.effects is not None else tire.has if tire is not None else ()
        model = model_with(
            model.name, with_library(model.name, tuple(requested), tire.added if tire is not None else ())
        )
        family = None
        if options.family is not None:
            given = {NOMINAL[name]: value for name, value in (options.nominal or {}).items()}
            family = Family.of(options.family, model, given)
            tire = family.tire if tire is None else tire
        recipe = load_recipe(options.recipe or ("family" if family else None), model.name)
        constraints = chosen_constraints(model.name, options.constraints, options.without_constraints)
        solver = solver_for(options.method, options.iterations, options.seed)
        if recipe.scales and tire is None:
            raise FitError(f"recipe {recipe.name} scales a given tire: a start tire is required (--start)")
        return cls(options, model, tire, features, recipe, constraints, solver, loss_named(options.loss), family)


@dataclass(frozen=True)
class Setup:
    """What a fit starts from.

    - `tire`: initial values, in adapted SAE.
    - `table`: the fitted rows. Without states of effects, which a fit simulates again and again, its columns are the
      arrays of `rows`.
    - `read`: initial values that were read from the data.
    - `notes`: notes for the user: what was assumed, what is not fitted.
    - `measured`: coefficients with dimensions that the size or the recordings give.
    """

    plan: Plan
    data: FitData
    tire: Tire
    read: Mapping[str, float]
    notes: tuple[str, ...]
    table: pd.DataFrame
    rows: Rows | None = None
    measured: frozenset[str] = frozenset()

    @classmethod
    def of(cls, plan: Plan, recordings: Sequence[Recording]) -> Setup:
        """Combine a plan with data.

        `recordings`: of any signs. Raises `UnknownName`, `DataError`, `FitError` if the data have no information on the
        tire, or contradict the nominal values.
        """
        options, model, start = plan.options, plan.symbolic_model, plan.start
        given_nominal = {NOMINAL[name] for name in options.nominal or {} if name in NOMINAL}
        check_nominal(options.nominal or {}, model, (recording.table for recording in recordings))
        other_radii = check_radius(options.nominal or {}, recordings)
        given = start.has if options.effects is None and start is not None else options.effects
        effects = model.default_effects if given is None else model.known_effects(given)
        effects -= model.known_effects(options.without)
        data = prepare(recordings, model, screening=options.screening, rows=options.rows, factors=options.weights)
        notes = [*data.notes, *other_radii]
        for name in options.nominal or {}:
            if NOMINAL[name] not in model.coefficients:
                notes.append(f"nominal {name} is not used by {model.name}")
        measured, sources = dimensions(recordings, options.size) if start is None or options.size else ({}, [])
        measured = {name: value for name, value in measured.items() if name in model.coefficients}
        measured = {name: value for name, value in measured.items() if name not in given_nominal}
        notes += [note for note in sources if not (note.startswith("radius") and "UNLOADED_RADIUS" not in measured)]
        values = {**_initial_values(plan, data.fitted, measured, notes), **_fixed(plan)}
        name, about = (start.name, start.about) if start is not None else ("", {})
        tire = Tire(
            model.name, values, effects=effects, signs="adapted-sae", name=name, about=about, added=model.added,
        )  # fmt: skip
        read = starting_values(tire, data.fitted) if plan.features else {}
        if plan.features:
            summary = ", ".join(f"{name} {value:.3g}" for name, value in read.items())
            notes.append(f"initial values read from the data: {summary or 'none, generic values used'}")
        setup = cls(plan, data, tire, read, tuple(notes), data.fitted, None, frozenset(measured))
        return setup if tire.states else setup._with_rows()

    def _with_rows(self) -> Setup:
        rows = Rows.of(self.table, self.tire, self.channels)
        table = rows.in_table(self.table, self.tire)
        # Columns of all data share no memory with these rows.
        data = replace(self.data, table=table) if len(self.data.table) == len(rows) else self.data
        return replace(self, data=data, table=table, rows=rows)

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The outputs that are fitted."""
        measured = self.table.notna().any()
        outputs = self.plan.symbolic_model.outputs
        return tuple(quantity.name for quantity in outputs if measured.get(quantity.name, False))

    @cached_property
    def plain(self) -> bool:
        """Whether no row has turn slip, so that its coefficients have no influence."""
        on_demand = [name for _, name in self.plan.symbolic_model.on_demand if name in self.table]
        return not any(self.table[name].any() for name in on_demand)

    @cached_property
    def emphasis(self) -> FloatArray:
        """Weight factors of the channels of recordings, shape (n_recordings, n_outputs)."""
        return emphasis(self.table, self.tire.outputs)

    @cached_property
    def constraints(self) -> VerifiedConstraints:
        """The physical constraints over the operating range."""
        return VerifiedConstraints(self.tire, self.plan.constraints, self.ranges)

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The operating range: smallest and largest value of each input."""
        return operating_range(self.table, self.tire)

    @property
    def assumed(self) -> frozenset[str]:
        """The coefficients whose initial values neither the caller nor the data have given."""
        start = self.plan.start
        unknown = self.tire.defaulted if start is not None else (*self.tire.defaulted, "UNLOADED_RADIUS")
        inherited = () if start is None else not_given(start)
        given = {NOMINAL[name] for name in self.plan.options.nominal or {}}
        return frozenset((*unknown, *inherited)) - given - self.measured


def _start_tire(start: TireLike, radius: float | None) -> Tire:
    """Return the start tire; an error message for an unknown name also suggests "features"."""
    try:
        return tire_from(start, "start")
    except TirError:
        if radius is None:
            raise
        return tire_from(start, "start", radius=radius)  # a file without a radius
    except WrongType:
        raise WrongType("start", start, f"a Tire, a path, the name of a published tire or {FEATURES!r}") from None
    except UnknownName as error:
        raise UnknownName("start", str(start), [FEATURES, *error.known]) from None


def _initial_values(
    plan: Plan, data: pd.DataFrame, measured: Mapping[str, float], notes: list[str]
) -> dict[str, float]:
    """Return the known initial values: of the start tire, nominal ones, `measured` dimensions, medians of the data."""
    model, start = plan.symbolic_model, plan.start
    nominal = {NOMINAL[name]: value for name, value in (plan.options.nominal or {}).items()}
    given = {name: value for name, value in nominal.items() if name in model.coefficients}
    if start is not None:
        if start.model != model.name:
            raise FitError(f"the start tire is {start.model}, not {model.name}")
        return {**start.in_signs("adapted-sae").values, **measured, **given}
    values = nominal_values(model, data, given, measured, notes)
    if "FNOMIN" not in values:
        raise FitError("no load Fz in the data: specify --nominal Fz0=...")
    return values


def nominal_values(
    model: Model, data: pd.DataFrame, given: Mapping[str, float], measured: Mapping[str, float], notes: list[str]
) -> dict[str, float]:
    """Return the given coefficients, `measured` dimensions and, for nominal values that are not given, medians."""
    values = {"UNLOADED_RADIUS": UNKNOWN_RADIUS, **measured, **_medians(model, data, given, notes), **given}
    if "UNLOADED_RADIUS" not in {*measured, *given}:
        notes.append(f"radius R0 not known: {UNKNOWN_RADIUS} m is assumed; give --size 205/55R16 or --nominal R0=0.31")
    return values


def _fixed(plan: Plan) -> dict[str, float]:
    """Return the values of coefficients that are not fitted, in adapted SAE."""
    declared = plan.symbolic_model.coefficients
    for name in plan.options.fixed:
        if name not in declared:
            raise UnknownName(f"coefficient of {plan.symbolic_model.name}", name, declared)
    return {name: -value if declared[name].flips else float(value) for name, value in plan.options.fixed.items()}


def _medians(model: Model, data: pd.DataFrame, given: Mapping[str, float], notes: list[str]) -> dict[str, float]:
    """Return the nominal values that the caller did not give: rounded medians of the data, each with a note."""
    values = {}
    for name, coefficient, text, unit in (
        ("Fz", "FNOMIN", "load", "N"),
        ("p", "NOMPRES", "pressure p0", "Pa"),
        ("V", "LONGVL", "speed V0", "m/s"),
    ):
        if coefficient not in model.coefficients or coefficient in given or name not in data:
            continue
        median = rounded_median(data[name])
        if median > 0:
            values[coefficient] = median
            notes.append(f"nominal {text} not given: the median, {median:g} {unit}")
    if "INFLPRES" in model.coefficients and {"NOMPRES"} & {*values, *given.keys()}:
        # The tire has nominal pressure if its user specifies none.
        values["INFLPRES"] = given.get("NOMPRES", values.get("NOMPRES", 0.0))
    return values
