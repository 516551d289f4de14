"""`tirefmu.evaluate`: a tire evaluated over a table in memory or of a file."""

from __future__ import annotations

import pandas as pd

from ..boundary.named_options import named
from ..tires import Tire, TireLike, tire_from
from ..tires.channels import OUTPUTS
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
        Input columns in SI units.
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
    """
    if isinstance(table, pd.DataFrame):
        check_names(map(str, table.columns), "table")
    else:
        table = recording_from(table, signs=signs)
        signs = None
    return tire_from(tire).evaluate(
        table, signs=signs, convention=convention, slip_angle=slip_angle, limits=limits, mirror=mirror, steady=steady,
        hold=hold, code=code,
    )  # fmt: skip


def predicted_outputs(tire: Tire, recording: Recording) -> pd.DataFrame:
    """Return the outputs of a tire for each row of a recording, in its signs."""
    outputs = evaluate_rows(tire, recording.table, Conventions(recording.signs))
    return outputs[[name for name in OUTPUTS if name in tire.outputs]].reset_index(drop=True)
