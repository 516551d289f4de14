"""The formats of recordings and logs: one declaration each, from which the readers and the help texts follow.

Commands show help before they load pandas. This module therefore imports no reader.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Format(NamedTuple):
    """A file format.

    - `reader`: module and function in this folder. `signs`: default sign convention.
    - `whole`: whether it is a text that is read as a whole.
    """

    reader: str
    signs: str = "iso"
    whole: bool = False


_TYDEX = Format("tydex:read_tydex", whole=True)
_ROS = Format("loggers.logger:read_rosbag")
#: By extension.
FORMATS: dict[str, Format] = {
    ".csv": Format("csv_table:read_csv"),
    ".parquet": Format("parquet_table:read_parquet"),
    ".xlsx": Format("excel_table:read_excel"),
    ".mat": Format("ttc_mat:read_mat", "sae"),
    ".dat": Format("ttc_dat:read_ttc_dat", "sae", whole=True),
    ".tdx": _TYDEX,
    ".tda": _TYDEX,
    ".tdb": _TYDEX,
    ".tyd": _TYDEX,
    ".mf4": Format("loggers.logger:read_mdf"),
    ".mdf": Format("loggers.logger:read_mdf"),
    ".tdms": Format("loggers.logger:read_tdms"),
    ".ulg": Format("loggers.logger:read_ulog"),
    ".bag": _ROS,
    ".db3": _ROS,
    ".mcap": _ROS,
    ".vbo": Format("loggers.vbo:read_vbo", whole=True),
}
#: Formats that their first bytes show, whatever the extension is.
MAGIC: dict[bytes, Format] = {b"MDF     ": FORMATS[".mf4"], b"UnFinMF ": FORMATS[".mf4"]}
#: The file that makes a folder a bag of ROS 2.
BAG = "metadata.yaml"
#: The default sign conventions, for the help text of ``--signs``.
DEFAULT_SIGNS = f"sae for {' and '.join(name for name, kind in FORMATS.items() if kind.signs == 'sae')}, iso for tables"


def is_bag(path: Path) -> bool:
    """Return whether a path is a folder with a bag of ROS 2."""
    return path.is_dir() and (path / BAG).is_file()


def format_of(path: Path) -> Format:
    """Return the format of a file by its first bytes, otherwise by its extension, which has to be known.

    That of a folder is the one of a bag of ROS 2.
    """
    if is_bag(path):
        return _ROS
    with path.open("rb") as file:
        start = file.read(max(map(len, MAGIC)))
    shown = next((declared for magic, declared in MAGIC.items() if start.startswith(magic)), None)
    return shown or FORMATS[path.suffix.lower()]
