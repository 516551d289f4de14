"""The formats of recordings: one declaration each, from which the readers and the help texts follow.

Commands show help before they load pandas. This module therefore imports no reader.
"""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """A file format. `reader`: module and function in this folder. `signs`: default sign convention."""

    reader: str
    signs: str


#: By extension.
FORMATS: dict[str, Format] = {
    ".csv": Format("csv_table:read_csv_table", "iso"),
    ".parquet": Format("parquet_table:read_parquet_table", "iso"),
    ".xlsx": Format("excel_table:read_excel_table", "iso"),
    ".mat": Format("ttc_mat:read_ttc_mat", "sae"),
    ".dat": Format("ttc_dat:read_ttc_dat", "sae"),
    ".tdx": Format("tydex:read_tydex", "iso"),
}
#: The default sign conventions, for the help text of ``--signs``.
DEFAULT_SIGNS = f"sae for {' and '.join(name for name, kind in FORMATS.items() if kind.signs == 'sae')}, iso for tables"
