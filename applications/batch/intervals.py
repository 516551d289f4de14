"""Intervals of a fit by bootstrap, computed on several processes or a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...boundary.named_options import named
from ...fitting import FitResult
from ...fitting.resampling.bootstrap import bootstrap_of, replicate_tasks, replicates_of
from ...measurements import TableLike, recordings_from
from .workers import Progress, all_results


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
