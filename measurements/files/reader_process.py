"""Program that reads files by native code (MATLAB, HDF5, Arrow); `native_reader.py` starts it as a process.

A damaged file can make such code crash, hang or fill the memory. Only this process ends then. It imports no module of
tirefmu, so that it starts in a fraction of a second. A request is a pickled tuple of what to load, path, memory limit,
largest size of the answer and further arguments. The answer is a pickled pair of a status and the content, the package
or the reason.
"""

from __future__ import annotations

import os
import pickle
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


def load_mdf(path: str) -> list[tuple[str, str, Any, Any]]:
    """Return name, unit, times and samples of each channel of numbers of an MDF file."""
    try:
        from asammdf import MDF
    except ImportError:
        raise MissingPackage("MDF") from None
    with MDF(path) as file:
        return [
            (str(signal.name), str(signal.unit or ""), signal.timestamps, signal.samples.astype(float))
            for signal in file.iter_channels()
            if signal.samples.ndim == 1 and signal.samples.dtype.kind in "fiu"
        ]


def load_parquet(path: str) -> Any:
    """Return the table of a Parquet file."""
    import pandas as pd

    try:
        return pd.read_parquet(path)
    except ImportError:
        raise MissingPackage("Parquet") from None


def load_excel(path: str) -> Any:
    """Return the first sheet of an Excel workbook without columns that have neither header nor cells."""
    import pandas as pd

    try:
        table = pd.read_excel(path, sheet_name=0, engine="openpyxl")
    except ImportError:
        raise MissingPackage("Excel") from None
    named = [not str(name).startswith("Unnamed: ") or table[name].notna().any() for name in table]
    return table.loc[:, named]


def _declared_size(path: str) -> int:
    """Return the bytes of the numbers that a Parquet file declares: constant columns are compressed without limit."""
    try:
        from pyarrow.parquet import ParquetFile
    except ImportError:
        raise MissingPackage("Parquet") from None
    metadata = ParquetFile(path).metadata
    return 8 * int(metadata.num_rows) * int(metadata.num_columns)


LOADERS: dict[str, Callable[..., Any]] = {
    "excel": load_excel,
    "matlab": load_matlab,
    "mdf": load_mdf,
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


def _limit_memory(size: int) -> None:
    if sys.platform == "win32":
        return
    import resource

    _, largest = resource.getrlimit(resource.RLIMIT_AS)
    size = size if largest == resource.RLIM_INFINITY else min(size, largest)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (size, largest))
    except (OSError, ValueError):  # the system has no such limit
        return


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests until they end."""
    while True:
        try:
            wanted, path, memory, largest, arguments = pickle.load(requests)
        except EOFError:
            return
        _limit_memory(memory)
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
