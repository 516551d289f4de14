"""Fit of a tire to recordings: checks the arguments, preprocesses the data, runs the stages, returns the result."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from ..boundary.errors import FitError
from ..boundary.named_options import named
from ..measurements import TableLike, check_columns, recordings_from
from ..numerics.one_thread import one_blas_thread
from ..tires import TireLike
from .assembly import result_of
from .fit_result import FitResult
from .options import FitOptions
from .resampling.bounds import with_consequences
from .resampling.second_solutions import with_second_solutions
from .setup import Plan, Setup
from .solvers.interruption import Interruption, Progress
from .stage import solve_stages
from .temperature.selection import forces_alone, temperature_column, with_temperature
from .temperature.temperature_fit import fit_temperature


@named(FitOptions)
def fit(
    tables: TableLike | Iterable[TableLike],
    model: str | None = None,
    *,
    start: TireLike | None = None,
    signs: str | None = None,
    options: FitOptions | None = None,
    progress: Progress | None = None,
    **settings: Any,
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
    signs : str, optional
        Sign convention of files and DataFrames; by default that of the format, and "iso" for a DataFrame.
    options : FitOptions, optional
        What is fitted and how: effects, recipe, loss, nominal values, weights, constraints.
    progress : callable, optional
        Called with stage, iteration and cost. Its method ``planned``, if it has one, is called before the first stage
        with the names of the stages and their work (rows times coefficients), and its method ``completed`` after each
        stage with the tire so far.
    **settings
        Fields of `FitOptions`, in addition to `options`: ``fit(table, effects=["load_friction"], loss="huber")``.

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
    UnknownOption
        If `settings` has a name that is no field of `FitOptions`; a `TypeError` with the nearest one.

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
    options = replace(options or FitOptions(), **settings)
    column = temperature_column(options)
    plan = Plan.of(model, start, forces_alone(options))
    recordings = recordings_from(tables, signs=signs)
    if not recordings:
        raise FitError("no table to fit")
    for recording in recordings:
        check_columns(recording)
    names = [recording.source for recording in recordings]
    setup = Setup.of(plan, recordings)
    heated = with_temperature(recordings, column) if column else []
    del recordings, recording  # much memory, if the caller has no reference
    with Interruption(progress) as interruption, one_blas_thread():
        state = solve_stages(setup, interruption)
    interruption.raise_failure()
    with one_blas_thread():
        result = result_of(setup, state, names, time.perf_counter() - began, interruption)
        result = result if result.run.interrupted else with_second_solutions(with_consequences(result))
        result = result.in_signs("iso")
        if not (column and not result.run.interrupted):
            return result
        tire, temperature = fit_temperature(result.tire, heated, column)
        return replace(result, tire=tire, temperature=temperature)
