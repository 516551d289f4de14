"""From recordings to a tire: the data made ready, the recipe's stages solved one after another, the result told."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pandas as pd

from tirefmu.measurements import TableLike, recordings_from
from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.symbolic import model as book_of
from tirefmu.symbolic.errors import FitError, UnknownName, WrongType
from tirefmu.symbolic.model import Model
from tirefmu.tires import TireLike, tire_from
from tirefmu.tires.tire import Tire

from .constraints.physical import chosen_constraints
from .data.fit_data import FitData, prepare
from .data.initial_values import starts_from
from .fit_run import FitRun
from .problem.recipe import Recipe, load_recipe
from .results.checkpoint import Checkpoint, fingerprint
from .results.fit_result import FitResult
from .solvers.interruption import Interruption, Progress
from .solvers.selection import solver_for

#: What --nominal may name, and the coefficient that it sets.
NOMINAL = {"Fz0": "FNOMIN", "R0": "UNLOADED_RADIUS", "p0": "NOMPRES", "V0": "LONGVL"}

#: What to start from where it is no tire: what the data show by themselves.
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
        Together they are the data; each may have its own signs.
    model : str, optional
        Where None, that of the start tire; without one, "mf61".
    start : Tire, path of a .tir file, name of a published tire, or "features", optional
        Initial values: a tire's, or what the data show by themselves (`tirefmu.fitting.data.initial_values`);
        generic ones where None. "features" is a path only if there is such a file.
    effects : collection of str, optional
        Exactly these effects on top of the model's core; all of the model where None.
    without : collection of str
        Effects to leave out.
    recipe : str, optional
        "progressive", "joint", "trento", "scaling" (of the start tire), a recipe of the model's own or the path of a
        TOML file; the model's default where None.
    loss : {"squares", "huber", "cauchy"}
        What a residual costs: where a few rows are grossly wrong, "huber" lets one count by its size instead of its
        square, "cauchy" hardly at all; from 1.3 and 2.4 standard deviations of its own channel's noise on.
    method : {"ipopt", "ioa"}
        IPOPT with exact derivatives, or the UNICAMP paper's evolutionary algorithm
        (`tirefmu.fitting.solvers.evolution`).
    iterations : int, optional
        The most that a stage may take; the method's own limit (300, 10,000) where None.
    seed : int
        Of a method that draws at random.
    nominal : mapping of str to float, optional
        Fz0 (N), R0 (m), p0 (Pa), V0 (m/s), as far as the model has them; the medians of the data and 0.3 m where
        not given.
    signs : str, optional
        Convention of files and DataFrames, where it is not the default (that of the format; "iso" for a DataFrame).
    screening : bool
        Whether to set aside rows of a cold tread, of transitions between levels, of a lifted or standing wheel, and
        outliers; `FitResult.excluded_rows` tells which. Scores count every row.
    rows : str
        How rows count: "condition" (every load, inclination, pressure, ... that a recording held counts the same,
        however often or slowly it was logged), "equal" (every row the same), or "independent" (as "condition", and
        each recording's channel by how many independent rows it is worth).
    progress : callable, optional
        Called with stage, iteration and cost.
    constraints, without_constraints : collection of str
        Physical conditions to keep beside the usual ones, and not to keep, by name or kind
        (`tirefmu.fitting.constraints.physical`); "all" means every one.
    checkpoint : path, optional
        File for the finished stages; removed when all of them are done.
    resume : bool
        Go on after the stages in that file.

    Returns
    -------
    FitResult
        Coefficients are in ISO-W, as in the tire file; `FitResult.in_signs` converts them. Also where the
        solver did not converge, or the fit was interrupted (Ctrl-C, or a `KeyboardInterrupt` of ``progress``) and
        kept the best values so far: `FitResult.ok` and `FitResult.status` say so.

    Raises
    ------
    UnknownName, DataError, FitError
        If something that was asked for does not exist or does not fit together.
    WrongType
        If a table or the start is of another type.

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
    tire_given = None if start is None or features else _start_tire(start)
    book = book_of(model if model is not None else tire_given.model if tire_given else DEFAULT_MODEL)
    plan = load_recipe(recipe, book.name)
    if resume and checkpoint is None:
        raise FitError("to go on takes the file of the finished stages (checkpoint)")
    chosen = chosen_constraints(book.name, constraints, without_constraints)
    solver = solver_for(method, iterations, seed)
    if method != "ipopt" and loss != "squares":
        raise FitError(f"loss {loss} is for method ipopt: {method} minimizes squares")
    if plan.scales and tire_given is None:
        raise FitError(f"recipe {plan.name} scales a given tire: say which to start from (--start)")
    recordings = recordings_from(tables, signs=signs)
    if not recordings:
        raise FitError("no table to fit")
    present = _effects(book, tire_given, effects, without)
    data = prepare(recordings, book, screening=screening, rows=rows)
    notes = list(data.notes)
    tire = _starting_tire(book, present, tire_given, data.fitted, nominal or {}, notes)
    read = starts_from(tire, data.fitted, notes) if features else {}
    options = {
        "rows": rows,
        "screening": str(screening),
        "loss": loss,
        "method": f"{method}, {iterations or 'usual'} iterations, seed {seed}",
        "start": FEATURES if features else "values",
        "constraints": ",".join(each.name for own in chosen.values() for each in own),
    }
    saved = Checkpoint(Path(checkpoint), _identity(data, tire, plan, options)) if checkpoint else None
    with Interruption(progress) as interruption:
        run = FitRun(
            book, tire, data, plan, interruption, notes,
            solver=solver, given=tire_given is not None, read=read, constraints=chosen, loss=loss,
        )  # fmt: skip
        if resume and saved:
            run.restore(saved.load(), str(saved.path))
        run.run(saved)
    interruption.raise_failure()
    result = replace(run.result(recordings, time.perf_counter() - began), method=method).in_signs("iso")
    if saved and not result.interrupted:
        saved.remove()
    return result


def _start_tire(start: TireLike) -> Tire:
    """Return the tire to start from; where there is none of that name, "features" is a possibility, too."""
    try:
        return tire_from(start, "start")
    except WrongType:
        raise WrongType("start", start, f"a Tire, a path, the name of a published tire or {FEATURES!r}") from None
    except UnknownName as error:
        raise UnknownName("start", str(start), [FEATURES, *error.known]) from None


def _identity(data: FitData, tire: Tire, plan: Recipe, options: Mapping[str, str]) -> dict[str, str]:
    """Return what a fit depends on, by what a user calls it."""
    return {
        "version of tirefmu": version("tirefmu"),
        "data": fingerprint(data.table.drop(columns=["included", "weight"])),
        "model": tire.model,
        "effects": ",".join(sorted(tire.has)),
        "recipe": repr(plan),
        "values to start from": repr(sorted(tire.values.items())),
        **options,
    }


def _effects(
    book: Model, start: Tire | None, effects: Collection[str] | None, without: Collection[str]
) -> frozenset[str]:
    given = start.has if effects is None and start is not None else effects
    return (book.usual_effects if given is None else book.known_effects(given)) - book.known_effects(without)


def _starting_tire(
    book: Model,
    present: frozenset[str],
    start: Tire | None,
    data: pd.DataFrame,
    nominal: Mapping[str, float],
    notes: list[str],
) -> Tire:
    for name in nominal:
        if name not in NOMINAL:
            raise UnknownName("nominal value", name, NOMINAL)
        if not nominal[name] > 0:
            raise FitError(f"nominal {name} = {nominal[name]:g} is not positive")
        if NOMINAL[name] not in book.coefficients:
            notes.append(f"nominal {name} has no place in {book.name}")
    given = {NOMINAL[name]: value for name, value in nominal.items() if NOMINAL[name] in book.coefficients}
    if start is not None:
        if start.model != book.name:
            raise FitError(f"the start tire is {start.model}, not {book.name}")
        values = {**start.in_signs("adapted-sae").values, **given}
        return Tire(book.name, values, effects=present, signs="adapted-sae", name=start.name, about=start.about)
    values = {"UNLOADED_RADIUS": 0.3, **_medians(book, data, given, notes), **given}
    if "UNLOADED_RADIUS" not in given:
        notes.append("radius R0 not given: 0.3 m (it only scales the moment coefficients)")
    if "FNOMIN" not in values:
        raise FitError("no load Fz in the data: say --nominal Fz0=...")
    return Tire(book.name, values, effects=present, signs="adapted-sae")


def _medians(book: Model, data: pd.DataFrame, given: Mapping[str, float], notes: list[str]) -> dict[str, float]:
    """Return the nominal values that nobody gave, from the data: medians of two digits, noted."""
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
        # Where a user of the tire says nothing of pressure, it has the nominal one.
        values["INFLPRES"] = given.get("NOMPRES", values.get("NOMPRES", 0.0))
    return values
