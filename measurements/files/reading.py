"""Reading of recordings from files of all known formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.metadata import EntryPoint
from os import PathLike
from pathlib import Path

from ...boundary.errors import DataError, TirefmuError, nearest, path_from
from ...boundary.plugins import described, loaded, plugins
from ...tires.signs import reversed_columns
from ..checks.rows.incomplete_rows import without_incomplete_rows
from ..interpretation import Interpretation
from ..recording import Recording
from .formats import FORMATS

#: Reads a file in a sign convention, with columns named by an interpretation.
Reader = Callable[[Path, str, Interpretation], Recording]


def _function(name: str) -> Reader:
    module, _, function = name.partition(":")
    return getattr(import_module(f".{module}", __package__), function)  # type: ignore[no-any-return]


def _installed(entry: EntryPoint, path: Path, signs: str, interpretation: Interpretation) -> Recording:
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
    headers = interpretation.headers(map(str, recording.table.columns), str(path))
    return replace(recording, table=recording.table.set_axis(headers, axis=1))


#: By extension: the reader and the default sign convention of the format. Entry points of the group
#: ``tirefmu.readers`` of other packages name further ones, with ``iso`` as default; they are imported at first use.
READERS: dict[str, tuple[Reader, str]] = {
    entry.name: (partial(_installed, entry), "iso") for entry in plugins("readers")
} | {extension: (_function(declared.reader), declared.signs) for extension, declared in FORMATS.items()}


def read_recording(
    path: str | PathLike[str],
    *,
    signs: str | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Recording:
    r"""Read a recording. The extension determines the format.

    Parameters
    ----------
    path : str or path-like
        ``.csv``, ``.parquet`` or ``.xlsx`` with the contract's columns in SI (a header may declare another unit:
        ``alpha [deg]``, ``Fz [kN]``, ``p [kPa]``) or with the columns of FSAE TTC files (``ET SA IA FZ FY``...), an
        FSAE TTC file (``.mat``, ``.dat``), or TYDEX (``.tdx``).
    signs : str, optional
        The convention of the file. Default: the convention stated in the file, otherwise ``sae`` for FSAE TTC files and
        ``iso`` for tables and TYDEX.
    columns : mapping of str to str, optional
        By channel, the column that has it; ``-NAME`` reverses the sign, ``none`` omits the channel.
    units : mapping of str to str, optional
        By channel, the unit of its numbers in the file, whatever the file declares.

    Returns
    -------
    Recording
        In the sign convention of the file. Rows without an input are excluded up to a share
        (`tirefmu.measurements.checks.rows.incomplete_rows`).

    Raises
    ------
    DataError
        One line with file, line (or row) and channel: a missing or empty file, an unknown extension, a cell
        that is not a number, an unknown column that resembles a missing input, too many NaN in an input, ...
    UnknownName
        If the signs are not one of the three conventions, or a channel or a unit does not exist.

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
    interpretation = Interpretation(columns or {}, units or {})
    try:
        if not file.exists():
            raise DataError(f"{file}: no such file")
        if not (file.is_file() or file.is_dir()):  # reading a device may never end; the reader reports a folder
            raise DataError(f"{file}: neither a file nor a folder")
        recording = reader(file, chosen, interpretation)
    except UnicodeDecodeError:
        raise DataError(f"{file}: not a text file (UTF-8)") from None
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None
    recording = without_incomplete_rows(interpretation.applied(recording) if interpretation else recording)
    return recording if signs is not None else replace(recording, signs=recording.about.get("signs", chosen))
