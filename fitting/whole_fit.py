"""Fit of a tire to recordings: checks the arguments, preprocesses the data, runs the stages, returns the result."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import replace

from ..boundary.errors import FitError
from ..measurements import TableLike, check_columns, recordings_from
from ..numerics.one_thread import one_blas_thread
from ..tires import TireLike
from .assembly import result_of
from .fit_result import FitResult
from .options import FitOptions
from .resampling.near_solution import with_consequences, with_second_solutions
from .setup import Plan, Setup
from .solvers.interruption import Interruption, Progress
from .stage import solve_stages
from .temperature.temperature_fit import fit_temperature, forces_alone, temperature_column, with_temperature


def fitted(
    tables: TableLike | Iterable[TableLike], model: str | None, start: TireLike | None, signs: str | None,
    options: FitOptions, progress: Progress | None,
) -> FitResult:  # fmt: skip
    """Return the result of a fit; see `tirefmu.fitting.fit`."""
    began = time.perf_counter()
    column = temperature_column(options)
    plan = Plan.of(model, start, forces_alone(options))
    # By name: digits of sums, which decide in flat directions, must not depend on the order of the files.
    recordings = sorted(recordings_from(tables, signs=signs), key=lambda recording: recording.source)
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
