"""Reading of recordings from files of all known formats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.metadata import EntryPoint
from os import PathLike
from pathlib import Path

from tirefmu.boundary.errors import DataError, TirefmuError, nearest, path_from
from tirefmu.boundary.plugins import described, loaded, plugins
from tirefmu.tires.signs import reversed_columns

from ..quality.incomplete_rows import without_incomplete_rows
from ..recording import Recording
from .formats import FORMATS


def _function(name: str) -> Callable[[Path, str], Recording]:
    module, _, function = name.partition(":")
    return getattr(import_module(f".{module}", __package__), function)  # type: ignore[no-any-return]


def _installed(entry: EntryPoint, path: Path, signs: str) -> Recording:
    """Read a recording with the reader of another package, which is trusted code of the user's installation."""
    reader = loaded(entry)
    try:
        recording = reader(path, signs)
    except (TirefmuError, OSError):
        raise
    except Exception as error:  # code of another package
        raise DataError(f"{path}: {described(entry)} failed ({type(error).__name__}: {error})") from error
    if not isinstance(recording, Recording):
        raise DataError(f"{path}: {described(entry)} returned no Recording")
    return recording


#: By extension: the reader and the default sign convention of the format. Entry points of the group
#: ``tirefmu.readers`` of other packages name further ones, with ``iso`` as default; they are imported at first use.
READERS: dict[str, tuple[Callable[[Path, str], Recording], str]] = {
    entry.name: (partial(_installed, entry), "iso") for entry in plugins("readers")
} | {extension: (_function(declared.reader), declared.signs) for extension, declared in FORMATS.items()}


def read_recording(path: str | PathLike[str], *, signs: str | None = None) -> Recording:
    r"""Read a recording. The extension determines the format.

    Parameters
    ----------
    path : str or path-like
        ``.csv`` or ``.parquet`` with the contract's columns in SI (a header may declare another unit:
        ``alpha [deg]``, ``Fz [kN]``, ``p [kPa]``), an FSAE TTC file (``.mat``, ``.dat``), or TYDEX
        (``.tdx``).
    signs : str, optional
        The convention of the file. Default: the convention stated in the file, otherwise ``sae`` for FSAE TTC files and
        ``iso`` for tables and TYDEX.

    Returns
    -------
    Recording
        In the sign convention of the file. Rows without an input are excluded up to a share
        (`tirefmu.measurements.quality.incomplete_rows`).

    Raises
    ------
    DataError
        One line with file, line (or row) and channel: a missing or empty file, an unknown extension, a cell
        that is not a number, an unknown column that resembles a missing input, too many NaN in an input, ...
    UnknownName
        If the signs are not one of the three conventions.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "sweep.csv"
    ...     _ = file.write_text("alpha [deg],Fz [kN],Fy\n2.0,1.5,-900\n")
    ...     recording = read_recording(file)
    >>> recording.signs, recording.table.round(4).iloc[0].to_dict()
    ('iso', {'alpha': 0.0349, 'Fz': 1500.0, 'Fy': -900.0})
    """
    file = path_from(path)
    if file.suffix.lower() not in READERS:
        raise DataError(f"{file}: unknown kind of recording {file.suffix!r}{nearest(file.suffix, READERS)}")
    reader, default_signs = READERS[file.suffix.lower()]
    chosen = default_signs if signs is None else signs
    reversed_columns(chosen, "iso")  # an unknown convention is an error before a long file is read
    try:
        if not file.exists():
            raise DataError(f"{file}: no such file")
        if not (file.is_file() or file.is_dir()):  # reading a device may never end; the reader reports a folder
            raise DataError(f"{file}: neither a file nor a folder")
        recording = reader(file, chosen)
    except UnicodeDecodeError:
        raise DataError(f"{file}: not a text file (UTF-8)") from None
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None
    recording = without_incomplete_rows(recording)
    return recording if signs is not None else replace(recording, signs=recording.about.get("signs", chosen))
