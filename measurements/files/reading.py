"""Reading of recordings from files of all known formats."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import EntryPoint
from os import PathLike
from pathlib import Path

from ...boundary.errors import DataError, TirefmuError, nearest, path_from
from ...boundary.named_options import named
from ...boundary.plugins import described, loaded, plugins
from ...tires.signs import reversed_columns
from ..checks.rows.incomplete_rows import without_incomplete_rows
from ..interpretation import Interpretation
from ..recording import Recording
from .columns.content import Content
from .columns.frames import frame_columns
from .columns.long_tables import with_columns_of_signals
from .columns.quaternions import with_headings
from .columns.stamps import with_whole_stamps
from .encoding import encoding_of
from .formats import FORMATS, Format, format_of, is_bag
from .table_recording import recording_of

_PLUGINS: dict[str, EntryPoint] = {entry.name: entry for entry in plugins("readers") if entry.name not in FORMATS}
#: By extension: the default sign convention of the format. Entry points of the group ``tirefmu.readers`` of other
#: packages name further ones; they are imported at first use.
READERS: dict[str, str] = {extension: declared.signs for extension, declared in FORMATS.items()} | dict.fromkeys(
    _PLUGINS, "iso"
)

#: Files that are given in the place of a recording.
NO_RECORDINGS = {".tir": "a tire", ".fmu": "an FMU"}
#: Bytes of a text that is read as a whole: a TTC file has 20 MB, a VBOX log 70 MB an hour. Smallest share of bytes that
#: a file on a disk has.
LARGEST_TEXT, MIN_STORED = 1 << 28, 0.01


def read_content(path: str | PathLike[str], signs: str | None = None) -> Content:
    """Return the columns of a file as it stores them.

    `signs`: the convention that the user states, for readers of other packages. Raises `DataError` with one line for a
    file that does not exist, has an unknown extension or cannot be read.
    """
    file = path_from(path)
    if file.suffix.lower() in NO_RECORDINGS:
        raise DataError(f"{file}: {NO_RECORDINGS[file.suffix.lower()]}, not a recording")
    if file.suffix.lower() not in READERS and not is_bag(file):
        raise DataError(f"{file}: unknown kind of recording {file.suffix!r}{_hint(file)}")
    try:
        if not file.exists():
            raise DataError(f"{file}: no such file")
        if not (file.is_file() or file.is_dir()):  # reading a device may never end; the reader reports a folder
            raise DataError(f"{file}: neither a file nor a folder")
        if file.suffix.lower() in _PLUGINS:
            return _from_plugin(_PLUGINS[file.suffix.lower()], file, signs or "iso")
        declared = format_of(file)
        _check_size(file, declared)
        module, _, function = declared.reader.partition(":")
        content = getattr(import_module(f".{module}", __package__), function)(file)
        return with_headings(with_columns_of_signals(with_whole_stamps(content), str(file)))
    except MemoryError:
        raise DataError(f"{file}: reading needs more memory than there is") from None
    except UnicodeDecodeError:
        raise DataError(f"{file}: not a text file") from None
    except OSError as error:
        raise DataError(f"{file}: {error.strerror or error}") from None


def _hint(file: Path) -> str:
    """Return what to do with a file of an unknown extension."""
    try:
        text = file.is_file() and encoding_of(file)
    except (DataError, OSError):
        text = ""
    if text:
        how = "a text with a table is read under the name .csv, one of the FSAE TTC under .dat"
        return f": {how}; known are {', '.join(READERS)}"
    return nearest(file.suffix, READERS)


def _check_size(path: Path, declared: Format) -> None:
    """Raise for a file whose bytes are mostly absent, such as a part of a download, and for too long a text."""
    status = path.stat()
    stored = 512 * getattr(status, "st_blocks", 0)
    if 0 < stored < MIN_STORED * status.st_size and status.st_size > LARGEST_TEXT:
        raise DataError(f"{path}: {stored} of its {status.st_size} bytes are stored: the file is incomplete")
    if declared.whole and status.st_size > LARGEST_TEXT:
        raise DataError(f"{path}: {status.st_size} bytes: a {path.suffix} file of at most {LARGEST_TEXT} is read")


def _from_plugin(entry: EntryPoint, path: Path, signs: str) -> Content:
    """Return the content of a recording of the reader of another package, trusted code of the user's installation."""
    reader = loaded(entry)
    try:
        recording = reader(path, signs)
    except (TirefmuError, OSError):
        raise
    except Exception as error:  # code of another package
        raise DataError(f"{path}: {described(entry)} failed ({type(error).__name__}: {error})") from error
    if not isinstance(recording, Recording):
        raise DataError(f"{path}: {described(entry)} returned no Recording")
    return Content(tuple(frame_columns(recording.table)), signs=recording.signs, about=recording.about)


@named()
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
        FSAE TTC file (``.mat``, ``.dat``), TYDEX (``.tdx``), or another format of docs/files.md.
    signs : str, optional
        The convention of the file. Default: the convention stated in the file, otherwise ``sae`` for FSAE TTC files and
        ``iso`` for tables and TYDEX.
    columns : mapping of str to str, optional
        By channel, the column that has it, ``NAME`` or ``NAME [unit]``; ``-NAME`` reverses the sign, ``none`` omits the
        channel.
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
    if signs is not None:
        reversed_columns(signs, "iso")  # an unknown convention is an error before a long file is read
    interpretation = Interpretation(columns or {}, units or {})
    content = read_content(file, signs)
    return without_incomplete_rows(recording_of(content, str(file), file.name, signs, interpretation))
