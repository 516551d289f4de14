"""`tirefmu.evaluate`: a tire evaluated over a table in memory or of a file."""

from __future__ import annotations

import pandas as pd

from ..boundary.named_options import named
from ..symbolic.channels import CHANNELS, OUTPUTS
from ..tires import Tire, TireLike, tire_from
from ..tires.evaluation import Conventions
from ..tires.evaluation import evaluate as evaluate_rows
from .column_names import check_names
from .recording import Recording
from .table_argument import TableLike, recording_from


@named()
def evaluate(
    tire: TireLike,
    table: TableLike,
    *,
    signs: str | None = None,
    convention: str = "tno",
    slip_angle: str = "tan",
    limits: bool = False,
    mirror: bool = False,
    steady: bool = False,
    hold: bool = False,
    code: str = "auto",
) -> pd.DataFrame:
    """Evaluate forces, moments and every named quantity of a tire for each row of a table.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    table : pandas.DataFrame, path or Recording
        Input columns. A DataFrame whose headers declare units, such as ``alpha [deg]``, is read as a file is.
    signs, convention, slip_angle, limits, mirror, steady, hold, code
        As for `Tire.evaluate`.

    Returns
    -------
    pandas.DataFrame
        The inputs, forces and moments and named quantities, in the signs of the table.

    Raises
    ------
    UnknownName, DataError, WrongType
        See `tire_from` and `Tire.evaluate`.

    Examples
    --------
    >>> table = pd.DataFrame({"alpha": [0.0, -0.1], "Fz": 1000.0})
    >>> evaluate("trento_hoosier", table)["Fy"].round().tolist()
    [-89.0, 1948.0]
    >>> evaluate("trento_hoosier", pd.DataFrame({"alpha [deg]": [0.0, -5.73], "Fz [kN]": 1.0}))["Fy"].round().tolist()
    [-89.0, 1948.0]
    """
    if isinstance(table, pd.DataFrame) and not _declares_units(table):
        check_names(map(str, table.columns), "table")
    else:
        table = recording_from(table, signs=signs)
        signs = None
    return tire_from(tire).evaluate(
        table, signs=signs, convention=convention, slip_angle=slip_angle, limits=limits, mirror=mirror, steady=steady,
        hold=hold, code=code,
    )  # fmt: skip


def _declares_units(table: pd.DataFrame) -> bool:
    """Return whether a header of a table declares the unit of a channel, as in ``alpha [deg]``."""
    heads = (column.split("[")[0].strip() for column in map(str, table.columns) if "[" in column)
    return any(name in CHANNELS for name in heads)


def predicted_outputs(tire: Tire, recording: Recording) -> pd.DataFrame:
    """Return the outputs of a tire for each row of a recording, in its signs."""
    outputs = evaluate_rows(tire, recording.table, Conventions(recording.signs))
    return outputs[[name for name in OUTPUTS if name in tire.outputs]].reset_index(drop=True)
