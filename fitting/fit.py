"""Fit of a tire to recordings: its arguments."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..boundary.named_options import named
from .options import FitOptions

if TYPE_CHECKING:
    from ..measurements import TableLike
    from ..tires import TireLike
    from .fit_result import FitResult
    from .solvers.interruption import Progress


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
        The data of one fit, in any order; recordings may have different sign conventions. The result has them in the
        order of their names.
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
        with the names of the stages and their work (rows times coefficients), and its method ``reached`` after each
        iteration and stage with the tire so far.
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
    from .whole_fit import fitted  # loads pandas and CasADi

    return fitted(tables, model, start, signs, replace(options or FitOptions(), **settings), progress)
