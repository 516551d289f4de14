"""Sign conventions of tire tables, and the conversion from one to another.

All three measure forces at the contact point in the wheel's own axes:

- ``iso``: the TYDEX W axes, z up. Fz > 0 is load; a normal tire has Fy < 0 for alpha > 0.
- ``adapted-sae``: as ``iso`` with Fy, My and Mz reversed, so that Fy > 0 for alpha > 0. Many student tables and the
  Trento report use it.
- ``sae``: as ``adapted-sae`` with alpha and Fz reversed too: a loaded tire has Fz < 0. The FSAE TTC's bench files use
  it.

kappa, gamma, Fx and Mx are the same in all three.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.errors import UnknownName
from ..symbolic.channels import INPUTS, OUTPUTS, reversed_by

if TYPE_CHECKING:
    import pandas as pd

#: The input and output columns of the public tables. A model reads the inputs that it has.
TABLE_INPUTS, TABLE_OUTPUTS = INPUTS, OUTPUTS
SIGNS = ("iso", "adapted-sae", "sae")
#: The columns that each convention writes with the opposite sign of ``iso``.
REVERSED: dict[str, frozenset[str]] = {signs: reversed_by(signs) for signs in SIGNS}
#: What a mirror in the wheel plane reverses.
MIRRORED = reversed_by("mirror")


def reversed_columns(source: str, target: str) -> frozenset[str]:
    """Return the columns that change sign between two conventions.

    `source`, `target`: one of ``iso``, ``adapted-sae``, ``sae``. Raises `UnknownName` if a convention is not one of the
    three.

    >>> sorted(reversed_columns("sae", "adapted-sae"))
    ['Fz', 'alpha']
    """
    for signs in (source, target):
        if signs not in SIGNS:
            raise UnknownName("sign convention", signs, SIGNS)
    return REVERSED[source] ^ REVERSED[target]


def convert_signs(table: pd.DataFrame, source: str, target: str) -> pd.DataFrame:
    """Return the table written in another sign convention.

    Parameters
    ----------
    table : pandas.DataFrame
        SI columns with the names of the public contract; others are unchanged.
    source, target : str
        One of ``iso``, ``adapted-sae``, ``sae``.

    Returns
    -------
    pandas.DataFrame
        A new table; the given one is not changed.

    Examples
    --------
    >>> import pandas as pd
    >>> bench = pd.DataFrame({"alpha": [0.1], "Fz": [-1000.0], "Fy": [-900.0]})
    >>> convert_signs(bench, "sae", "iso").iloc[0].to_dict()
    {'alpha': -0.1, 'Fz': 1000.0, 'Fy': 900.0}
    """
    columns = [name for name in table.columns if name in reversed_columns(source, target)]
    return table.assign(**{name: -table[name] for name in columns})
