"""Intervals of a fit by bootstrap and by profile likelihood, computed on several processes or a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ...boundary.errors import UnknownName, no_single_text
from ...fitting import FitResult
from ...fitting.resampling.bootstrap import bootstrap_of, check_replicates, replicate_tasks, replicates_of
from ...fitting.resampling.profile import profiles_of, side_of, side_tasks
from ...measurements import Recording, TableLike, recordings_from
from ...symbolic.models import model_named
from .workers import Progress, all_results


def check_intervals(
    recordings: Sequence[Recording], replicates: int | None, coefficients: Sequence[str], model: str | None
) -> None:
    """Raise for intervals that cannot be computed, before a fit.

    Raises `FitError` if there are too few replicates or sweeps. Raises `UnknownName` if the model does not have a
    coefficient; without a model, this is seen after the fit.
    """
    if replicates is not None:
        check_replicates(replicates, recordings)
    declared = model_named(model).coefficients if model is not None and coefficients else None
    for name in coefficients:
        if declared is not None and name not in declared:
            raise UnknownName("coefficient", name, declared)


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


def profile(
    result: FitResult,
    coefficients: Sequence[str],
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """Return a fit with the profile likelihoods of some coefficients.

    Parameters
    ----------
    result : FitResult
        Of a fit of these tables.
    coefficients : sequence of str
        Names of free coefficients.
    scheduler, workers
        As for `bootstrap`.
    progress : callable, optional
        Called with the numbers of finished and of all sides of curves.

    Returns
    -------
    FitResult
        With `FitResult.profiles`.

    Raises
    ------
    UnknownName
        If a coefficient was not fitted.
    FitError
        If no stage with all its rows determined a coefficient.

    Examples
    --------
    docs/is_my_fit_good.md has an example.

    >>> profile(None, "PKY1")
    Traceback (most recent call last):
    tirefmu.boundary.errors.WrongType: coefficients is 'PKY1' (str): it has to be a list of names, such as ['PKY1']
    """
    no_single_text("coefficients", coefficients)
    tasks = side_tasks(result, coefficients)
    return profiles_of(result, tasks, all_results(side_of, tasks, scheduler, workers, progress))
