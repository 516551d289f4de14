"""Fit of a tire to recordings: preprocesses the data, runs the stages of the recipe, returns the result."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from importlib.metadata import version
from math import inf
from pathlib import Path

import pandas as pd

from tirefmu.estimation.nominal_values import NOMINAL, check_nominal
from tirefmu.estimation.one_thread import one_blas_thread
from tirefmu.measurements import TableLike, check_convention, recordings_from
from tirefmu.measurements.provenance import table_digest
from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.symbolic.errors import FitError, TirError, UnknownName, WrongType, no_single_text
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.models import model as book_of
from tirefmu.symbolic.models import with_library
from tirefmu.tires import TireLike, tire_from
from tirefmu.tires.code.printed import model_with
from tirefmu.tires.property_file.names import not_given
from tirefmu.tires.tire import Tire

from .constraints.physical import chosen_constraints
from .data.fit_data import FitData, prepare
from .data.initial_values import starts_from
from .fit_run import FitRun
from .problem.recipe import Recipe, load_recipe
from .results.checkpoint import Checkpoint
from .results.fit_result import FitResult
from .solvers.interruption import Interruption, Progress
from .solvers.selection import solver_for

#: Default weight of a slip stiffness that is read from the data: the study in docs/stiffness.md.
STIFFNESS_WEIGHT = 10.0
#: Value of `start` for initial values that are read from the data.
FEATURES = "features"


def fit(
    tables: TableLike | Iterable[TableLike],
    model: str | None = None,
    *,
    start: TireLike | None = None,
    effects: Collection[str] | None = None,
    without: Collection[str] = (),
    recipe: str | None = None,
    loss: str = "squares",
    method: str = "ipopt",
    iterations: int | None = None,
    seed: int = 0,
    nominal: Mapping[str, float] | None = None,
    signs: str | None = None,
    screening: bool = True,
    rows: str = "condition",
    stiffness_weight: float = STIFFNESS_WEIGHT,
    progress: Progress | None = None,
    constraints: Collection[str] = (),
    without_constraints: Collection[str] = (),
    checkpoint: str | Path | None = None,
    resume: bool = False,
) -> FitResult:
    """Fit a tire to recordings of a test bench.

    Parameters
    ----------
    tables : path, DataFrame or Recording, or a sequence of them
        The data of one fit; recordings may have different sign conventions.
    model : str, optional
        By default the model of the start tire; without a start tire "mf61".
    start : Tire, path of a .tir file, name of a published tire, or "features", optional
        Initial values: those of a tire, or with "features" values read from the data
        (`tirefmu.fitting.data.initial_values`); by default generic values. "features" is a path only if such a file
        exists.
    effects : collection of str, optional
        Exactly these effects in addition to the model's core; by default all effects of the model.
    without : collection of str
        Effects to exclude.
    recipe : str, optional
        "progressive", "joint", "trento", "scaling" (of the start tire), a recipe that the model defines, or the path of
        a TOML file; by default the recipe of the model.
    loss : {"squares", "huber", "cauchy"}
        Cost of a residual. "huber" (linear) and "cauchy" (logarithmic) reduce the influence of outliers. They apply
        above 1.3 and 2.4 standard deviations of the noise of the channel.
    method : {"ipopt", "ioa"}
        IPOPT with exact derivatives, or the UNICAMP paper's evolutionary algorithm
        (`tirefmu.fitting.solvers.evolution`).
    iterations : int, optional
        Upper limit for each stage; by default the limit of the method (300, 10,000).
    seed : int
        Seed of a random method.
    nominal : mapping of str to float, optional
        Fz0 (N), R0 (m), p0 (Pa), V0 (m/s), as far as the model has them; by default the medians of the data and 0.3 m.
    signs : str, optional
        Sign convention of files and DataFrames; by default that of the format, and "iso" for a DataFrame.
    screening : bool
        Whether to exclude outliers and rows of a cold tread, of transitions between levels, and of a lifted or
        stationary wheel (`FitResult.excluded_rows`). Goodness of fit is computed over all rows.
    rows : str
        Weights of rows: "condition" (equal weight of every operating condition of a recording, independent of its
        number of rows), "equal" (equal weight of every row), "independent" (as "condition", and each channel of a
        recording by its effective sample size), or "load" (as "condition", with errors relative to the load).
    stiffness_weight : float
        Weight of the slip stiffness that is read from the data at each load, as a number of independent rows; 0: it is
        not fitted (`docs/stiffness.md`).
    progress : callable, optional
        Called with stage, iteration and cost. Its method ``planned``, if it has one, is called before the first stage
        with the names of the stages and their work (rows times coefficients).
    constraints, without_constraints : collection of str
        Physical constraints to enforce in addition to the default ones, and constraints not to enforce, by name or kind
        (`tirefmu.fitting.constraints.physical`); "all" means all constraints.
    checkpoint : path, optional
        File in which completed stages are saved. It remains after the fit; remove it when the result is stored.
    resume : bool
        Continue after the stages in that file; if all are complete, the result follows from them.

    Returns
    -------
    FitResult
        Coefficients are in ISO-W, as in the tire file; `FitResult.in_signs` converts them. A fit that does not
        converge, or that is interrupted (Ctrl-C, or a `KeyboardInterrupt` of ``progress``), returns the best values so
        far. `FitResult.ok` and `FitResult.status` report this.

    Raises
    ------
    UnknownName, DataError, FitError
        If an argument names something unknown, or arguments or data are inconsistent, in particular if the data
        contradict their sign convention.
    WrongType
        If a table or the start has a wrong type.

    Examples
    --------
    >>> from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps
    >>> from tirefmu.tires import published
    >>> bench = VirtualBench(published("trento_hoosier"), Noise.none())
    >>> table = bench.run(alpha_sweeps([220.0, 700.0], sample_rate=2.0)).with_signs("iso").table
    >>> result = fit(table[["alpha", "Fz", "Fy"]], "mf96", effects=["load_friction"], nominal={"Fz0": 700, "R0": 0.23})
    >>> result.signs, result.covariance.loc["PDY1", "PDY1"] > 0
    ('iso', np.True_)
    """
    began = time.perf_counter()
    features = isinstance(start, str) and start == FEATURES and not Path(start).is_file()
    tire_given = None if start is None or features else _start_tire(start, (nominal or {}).get("R0"))
    book = book_of(model if model is not None else tire_given.model if tire_given else DEFAULT_MODEL)
    book = _with_added(book, tire_given, effects)
    plan = load_recipe(recipe, book.name)
    if resume and checkpoint is None:
        raise FitError("resume requires the file of the completed stages (checkpoint)")
    if not 0.0 <= stiffness_weight < inf:
        raise FitError(f"stiffness weight {stiffness_weight:g} is not a number of rows")
    chosen = chosen_constraints(book.name, constraints, without_constraints)
    solver = solver_for(method, iterations, seed)
    if method != "ipopt" and loss != "squares":
        raise FitError(f"loss {loss} is for method ipopt: {method} minimizes squares")
    if plan.scales and tire_given is None:
        raise FitError(f"recipe {plan.name} scales a given tire: a start tire is required (--start)")
    recordings = recordings_from(tables, signs=signs)
    if not recordings:
        raise FitError("no table to fit")
    for i in range(len(recordings)):
        check_convention(recordings[i])
    check_nominal(nominal or {}, book, (recording.table for recording in recordings))
    present = _effects(book, tire_given, effects, without)
    data = prepare(recordings, book, screening=screening, rows=rows)
    names = [recording.source for recording in recordings]
    del recordings  # much memory, if the caller has no reference
    notes = list(data.notes)
    tire = _starting_tire(book, present, tire_given, data.fitted, nominal or {}, notes)
    read = starts_from(tire, data.fitted, notes) if features else {}
    options = {
        "rows": rows,
        "screening": str(screening),
        "stiffness weight": f"{stiffness_weight:g}",
        "loss": loss,
        "method": f"{method}, {iterations or 'default'} iterations, seed {seed}",
        "start": FEATURES if features else "values",
        "constraints": ",".join(each.name for own in chosen.values() for each in own),
    }
    saved = Checkpoint(Path(checkpoint), _identity(data, tire, plan, options)) if checkpoint else None
    with Interruption(progress) as interruption, one_blas_thread():
        run = FitRun(
            book, tire, data, plan, interruption, notes,
            solver=solver, given=tire_given is not None, read=read, constraints=chosen, loss=loss,
            stiffness_weight=stiffness_weight, assumed=_assumed(tire, tire_given, nominal or {}),
        )  # fmt: skip
        del data
        if resume and saved:
            run.restore(saved.load(), str(saved.path))
        run.run(saved)
    interruption.raise_failure()
    with one_blas_thread():
        return replace(run.result(names, time.perf_counter() - began), method=method).in_signs("iso")


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


def _identity(data: FitData, tire: Tire, plan: Recipe, options: Mapping[str, str]) -> dict[str, str]:
    """Return the inputs of a fit by the names that a user knows."""
    return {
        "version of tirefmu": version("tirefmu"),
        "data": table_digest(data.table.drop(columns=["included", "weight"])),
        "model": tire.model,
        "effects": ",".join(sorted(tire.has)),
        "recipe": repr(plan),
        "initial values": repr(sorted(tire.values.items())),
        **options,
    }


def _with_added(book: Model, start: Tire | None, effects: Collection[str] | None) -> Model:
    """Return the model with the added effects of the start tire and those of the library that are requested."""
    no_single_text("effects", effects)
    requested = tuple(effects) if effects is not None else tuple(start.has) if start is not None else ()
    return model_with(book.name, with_library(book.name, requested, start.added if start is not None else ()))


def _effects(
    book: Model, start: Tire | None, effects: Collection[str] | None, without: Collection[str]
) -> frozenset[str]:
    given = start.has if effects is None and start is not None else effects
    return (book.default_effects if given is None else book.known_effects(given)) - book.known_effects(without)


def _starting_tire(
    book: Model,
    present: frozenset[str],
    start: Tire | None,
    data: pd.DataFrame,
    nominal: Mapping[str, float],
    notes: list[str],
) -> Tire:
    for name in nominal:
        if NOMINAL[name] not in book.coefficients:
            notes.append(f"nominal {name} is not used by {book.name}")
    given = {NOMINAL[name]: value for name, value in nominal.items() if NOMINAL[name] in book.coefficients}
    if start is not None:
        if start.model != book.name:
            raise FitError(f"the start tire is {start.model}, not {book.name}")
        values = {**start.in_signs("adapted-sae").values, **given}
        return Tire(
            book.name,
            values,
            effects=present,
            signs="adapted-sae",
            name=start.name,
            about=start.about,
            added=book.added,
        )
    values = {"UNLOADED_RADIUS": 0.3, **_medians(book, data, given, notes), **given}
    if "UNLOADED_RADIUS" not in given:
        notes.append("radius R0 not given: 0.3 m (it only scales the moment coefficients)")
    if "FNOMIN" not in values:
        raise FitError("no load Fz in the data: specify --nominal Fz0=...")
    return Tire(book.name, values, effects=present, signs="adapted-sae", added=book.added)


def _assumed(tire: Tire, start: Tire | None, nominal: Mapping[str, float]) -> frozenset[str]:
    """Return the coefficients whose initial values neither the caller nor the data have given."""
    unknown = tire.defaulted if start is not None else (*tire.defaulted, "UNLOADED_RADIUS")
    inherited = () if start is None else not_given(start)
    return frozenset((*unknown, *inherited)) - {NOMINAL[name] for name in nominal}


def _medians(book: Model, data: pd.DataFrame, given: Mapping[str, float], notes: list[str]) -> dict[str, float]:
    """Return the nominal values that the caller did not give: medians of the data with two digits, each with a note."""
    values = {}
    for name, coefficient, text, unit in (
        ("Fz", "FNOMIN", "load", "N"),
        ("p", "NOMPRES", "pressure p0", "Pa"),
        ("V", "LONGVL", "speed V0", "m/s"),
    ):
        if coefficient not in book.coefficients or coefficient in given or name not in data:
            continue
        median = float(f"{data[name].median():.2g}")
        if median > 0:
            values[coefficient] = median
            notes.append(f"nominal {text} not given: the median, {median:g} {unit}")
    if "INFLPRES" in book.coefficients and {"NOMPRES"} & {*values, *given.keys()}:
        # The tire has nominal pressure if its user specifies none.
        values["INFLPRES"] = given.get("NOMPRES", values.get("NOMPRES", 0.0))
    return values
