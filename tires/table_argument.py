"""Table arguments of `Tire.evaluate`: a DataFrame is used as it is; the reader of `tirefmu` reads everything else.

Recordings and their files belong to `tirefmu.measurements`, which imports this package. The package `tirefmu` connects
the two, so this package does not depend on the readers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from ..boundary.errors import WrongType

if TYPE_CHECKING:
    import pandas as pd


class SignedTable(Protocol):
    """A table with its sign convention, such as `tirefmu.measurements.Recording`."""

    @property
    def table(self) -> pd.DataFrame:
        """Columns of the public tables, SI."""

    @property
    def signs(self) -> str:
        """The table's sign convention."""


#: Returns the table of a path or a recording; takes the table and the signs, None if the caller gave none.
Reader = Callable[[Any, str | None], SignedTable]


def _data_frames_only(table: Any, signs: str | None) -> SignedTable:
    raise WrongType("table", table, "a DataFrame")


_reader: Reader = _data_frames_only


def read_tables_with(reader: Reader) -> None:
    """Set the reader of a table that is not a DataFrame.

    Parameters
    ----------
    reader : callable
        From a path or a Recording, and the signs that the caller gave or None, to a DataFrame and its signs.
    """
    global _reader
    _reader = reader


def table_from(table: Any, signs: str | None = None) -> tuple[pd.DataFrame, str]:
    """Return a table and its sign convention.

    `signs`: the convention; for a DataFrame "iso" if None. Raises `DataError` if a file cannot be read, or the signs
    contradict those of a recording. Raises `WrongType` if it is not a table.

    >>> import pandas as pd
    >>> table_from(pd.DataFrame({"alpha": [0.1]}))[1]
    'iso'
    """
    import pandas as pd  # every import of tirefmu imports this module

    if isinstance(table, pd.DataFrame):
        return table, "iso" if signs is None else signs
    recording = _reader(table, signs)
    return recording.table, recording.signs
