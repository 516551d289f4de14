"""Program that reads files by native code (MATLAB, HDF5, Arrow); `native_reader.py` starts it as a process.

A damaged file can make such code crash, hang or fill the memory. Only this process ends then. It imports no module of
tirefmu, so that it starts in a fraction of a second. A request is a pickled tuple of what to load, path, limits of
memory and of processor time, largest size of the answer and further arguments. The answer is a pickled pair of a status
and the content, the package or the reason.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import runpy
import signal
import sys
import warnings
from collections.abc import Callable
from typing import Any, BinaryIO


class MissingPackage(Exception):
    """The package that reads a kind of file is not installed; the argument is the kind."""


def load_matlab(path: str) -> dict[str, Any]:
    """Return the variables of a ``.mat`` file; newer MATLAB formats need a separate package."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatlabOpaque

    try:
        loaded: dict[str, Any] = loadmat(path, struct_as_record=False)
    except NotImplementedError:
        return _load_newer(path, "MATLAB 7.3 (HDF5) files")
    if any(isinstance(value, MatlabOpaque) for value in loaded.values()):
        return _load_newer(path, "MATLAB tables")
    return loaded


def _load_newer(path: str, kind: str) -> dict[str, Any]:
    import pandas as pd

    # Importing mat-io sets an option of pandas for the whole process. The block restores it.
    option = "future.infer_string"
    with pd.option_context(option, pd.get_option(option)):
        try:
            from matio import load_from_mat
        except ImportError:
            raise MissingPackage(kind) from None
        loaded: dict[str, Any] = load_from_mat(path, add_table_attrs=True)
    return loaded


def load_log(path: str, format_name: str) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Return the channels of a log by the loader of its format; see `loaders`."""
    loader = runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "loaders", f"{format_name}.py"))
    try:
        return loader["load"](path)  # type: ignore[no-any-return]
    except ImportError:
        raise MissingPackage(format_name) from None


def load_parquet(path: str) -> tuple[Any, dict[str, str]]:
    """Return the table of a Parquet file, and the units in the metadata of its fields."""
    import pandas as pd

    try:
        return pd.read_parquet(path), _units(_parquet_file(path).schema_arrow)
    except ImportError:
        raise MissingPackage("Parquet") from None


def _units(schema: Any) -> dict[str, str]:
    """Return the units of fields by name."""
    units = {}
    for field in schema:
        for key in (b"unit", b"units"):
            if field.metadata and key in field.metadata:
                units[str(field.name)] = field.metadata[key].decode("utf-8", "replace")
    return units


def load_excel(path: str) -> list[tuple[str, bool, list[tuple[int, list[Any]]]]]:
    """Return name, visibility, and numbers and cells of the rows that are not blank, of each sheet of a workbook."""
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise MissingPackage("Excel") from None
    sheets = []
    for sheet in load_workbook(path, read_only=True, data_only=True).worksheets:
        rows = []
        for number, row in enumerate(sheet.iter_rows(values_only=True), start=1):
            if any(cell is not None and cell != "" for cell in row):
                rows.append((number, list(row)))
        width = max((len(cells) for _, cells in rows), default=0)
        for _, cells in rows:
            cells.extend([None] * (width - len(cells)))
        sheets.append((sheet.title, sheet.sheet_state == "visible", rows))
    return sheets


def _declared_size(path: str) -> int:
    """Return the bytes of the numbers that a Parquet file declares: constant columns are compressed without limit."""
    metadata = _parquet_file(path).metadata
    return 8 * int(metadata.num_rows) * int(metadata.num_columns)


def _parquet_file(path: str) -> Any:
    try:
        from pyarrow.parquet import ParquetFile
    except ImportError:
        raise MissingPackage("Parquet") from None
    return ParquetFile(path)


LOADERS: dict[str, Callable[..., Any]] = {
    "excel": load_excel,
    "matlab": load_matlab,
    "log": load_log,
    "parquet": load_parquet,
}


def answer(wanted: str, path: str, largest: int, arguments: tuple[Any, ...] = ()) -> bytes:
    """Return the pickled answer to a request: ("loaded", content), ("missing", kind) or ("refused", reason)."""
    too_large = pickle.dumps(("refused", "its content is far larger than a file of its size can contain"))
    try:
        if wanted == "parquet" and _declared_size(path) > largest:
            return too_large
        content = pickle.dumps(("loaded", LOADERS[wanted](path, *arguments)))
        return content if len(content) <= largest else too_large
    except MissingPackage as error:
        return pickle.dumps(("missing", str(error)))
    except MemoryError:
        return too_large
    except Exception as error:  # these libraries raise exceptions of any type
        return pickle.dumps(("refused", (str(error).splitlines() or [type(error).__name__])[0]))


def _limit(memory: int, seconds: float) -> None:
    """Limit the memory, and the processor time from now on; late work gets a `TimeoutError`."""
    if sys.platform == "win32":
        return
    import resource

    signal.signal(signal.SIGXCPU, _late)
    used = resource.getrusage(resource.RUSAGE_SELF)
    until = math.ceil(used.ru_utime + used.ru_stime + seconds)
    for kind, limit in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, until)):
        _, largest = resource.getrlimit(kind)
        with contextlib.suppress(OSError, ValueError):  # the system has no such limit
            resource.setrlimit(kind, (limit if largest == resource.RLIM_INFINITY else min(limit, largest), largest))


def _late(*_: object) -> None:
    raise TimeoutError("reading takes too long")


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests until they end."""
    while True:
        try:
            wanted, path, memory, seconds, largest, arguments = pickle.load(requests)
        except EOFError:
            return
        _limit(memory, seconds)
        answers.write(answer(wanted, path, largest, arguments))
        answers.flush()


def _main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the parent process
    warnings.simplefilter("ignore")
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # output of a library must not be mixed with the answers
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    _main()
