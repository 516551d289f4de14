"""Bootstrap and cross-validation of a fit, computed on several processes or a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ...boundary.named_options import named
from ...fitting import FitResult, HeldOut
from ...fitting import cross_validate as in_this_process
from ...fitting.cross_validation import FoldTask
from ...fitting.resampling.bootstrap import bootstrap_of, replicate_tasks, replicates_of
from ...measurements import TableLike, recordings_from
from ...tires import tire_from
from ...tires.tire import Tire
from .execution import Progress, all_results


@named()
def bootstrap(
    result: FitResult,
    tables: TableLike | Iterable[TableLike],
    replicates: int = 200,
    *,
    signs: str | None = None,
    seed: int = 0,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """Return a fit with percentile intervals of its coefficients, from a block bootstrap by sweeps.

    Parameters
    ----------
    result : FitResult
        Of a fit of these tables.
    tables : path, DataFrame or Recording, or a sequence of them
        The data of the fit, in the same order.
    replicates : int
        Number of repetitions of the fit with random weights of sweeps (`tirefmu.fitting.resampling.bootstrap`).
    signs : str, optional
        As for the fit.
    seed : int
        Equal seeds give equal intervals, whatever computes them.
    scheduler : str, optional
        Address of a Dask scheduler. Default: processes of this machine.
    workers : int, optional
        Number of local processes. Default: one for each processor.
    progress : callable, optional
        Called with the numbers of finished and of all replicates.

    Returns
    -------
    FitResult
        With `FitResult.bootstrap`.

    Raises
    ------
    FitError
        If there are too few replicates or sweeps, the tables are not those of the fit, or too few replicates converge.

    Notes
    -----
    Local workers are new Python processes. A script that calls this function needs ``if __name__ == "__main__":``.

    Examples
    --------
    docs/is_my_fit_good.md has an example.

    >>> import tirefmu
    >>> tirefmu.bootstrap(None, [], replicates=5)
    Traceback (most recent call last):
    tirefmu.boundary.errors.FitError: 5 bootstrap replicates: at least 40 are required
    """
    recordings = recordings_from(tables, signs=signs)
    tasks = replicate_tasks(result, recordings, replicates, seed)
    results = all_results(replicates_of, tasks, scheduler, workers, progress, lambda task: len(task.numbers))
    return bootstrap_of(result, tasks, np.concatenate(results))


@named(in_this_process)
def cross_validate(
    tables: TableLike | Iterable[TableLike],
    model: str | None = None,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> tuple[HeldOut, ...]:
    """Return what `tirefmu.fitting.cross_validate` does, each fold in a process of its own.

    Parameters
    ----------
    tables, model
        As for `tirefmu.fitting.cross_validate`.
    scheduler : str, optional
        Address of a Dask scheduler. Default: processes of this machine.
    workers : int, optional
        Number of local processes. Default: one for each processor.
    progress : callable, optional
        Called with the numbers of finished and of all folds.
    **options
        Further options of `tirefmu.fitting.cross_validate`.

    Returns
    -------
    tuple of HeldOut
        The same to the last bit, whatever computes them.

    Raises
    ------
    FitError
        As `tirefmu.fitting.cross_validate`, or if the fit of a fold has no result.

    Notes
    -----
    Local workers are new Python processes. A script that calls this function needs ``if __name__ == "__main__":``.

    Examples
    --------
    >>> from tirefmu.measurements import VirtualBench, alpha_sweeps
    >>> from tirefmu.tires import published
    >>> bench = VirtualBench(published("trento_hoosier")).run(alpha_sweeps([700.0]))
    >>> cross_validate(bench, "mf96", folds=1)
    Traceback (most recent call last):
    tirefmu.boundary.errors.FitError: 1 folds: at least two are required
    """
    if options.get("start") is not None:
        options["start"] = tire_from(options["start"])  # workers read no files

    def compute(function: Callable[[FoldTask], Tire], tasks: Sequence[FoldTask]) -> list[Tire]:
        return all_results(function, tasks, scheduler, workers, progress)

    return in_this_process(tables, model, compute=compute, **options)
