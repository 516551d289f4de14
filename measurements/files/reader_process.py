"""The process in which files are read by native code (MATLAB, HDF5, Arrow); started by path, `native.py` talks to it.

A damaged file makes such code crash, hang or fill the memory: this process dies of it, and the one that asked goes on.
It imports nothing of tirefmu, so that it starts in a fraction of a second. A request is a pickled tuple of form,
path, memory limit and largest answer; the answer a pickled pair of a word and what belongs to it.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import warnings
from typing import Any, BinaryIO


class MissingPackage(Exception):
    """The package that reads such files is not installed; what they are."""


def load_matlab(path: str) -> dict[str, Any]:
    """Return the variables of a ``.mat`` file; MATLAB's newer forms need a package of their own."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatlabOpaque

    try:
        loaded: dict[str, Any] = loadmat(path, struct_as_record=False)
    except NotImplementedError:
        return _load_newer(path, "MATLAB 7.3 (HDF5) files")
    if any(isinstance(value, MatlabOpaque) for value in loaded.values()):
        return _load_newer(path, "MATLAB tables")
    return loaded


def _load_newer(path: str, what: str) -> dict[str, Any]:
    import pandas as pd

    # Importing mat-io sets an option of pandas for the whole process: it ends with the block.
    option = "future.infer_string"
    with pd.option_context(option, pd.get_option(option)):
        try:
            from matio import load_from_mat
        except ImportError:
            raise MissingPackage(what) from None
        loaded: dict[str, Any] = load_from_mat(path, add_table_attrs=True)
    return loaded


def load_parquet(path: str) -> Any:
    """Return the table of a Parquet file."""
    import pandas as pd

    try:
        return pd.read_parquet(path)
    except ImportError:
        raise MissingPackage("Parquet") from None


LOADERS = {"matlab": load_matlab, "parquet": load_parquet}


def answer(form: str, path: str, most: int) -> bytes:
    """Return the pickled answer to a request: ("loaded", content), ("missing", what) or ("refused", reason)."""
    too_large = pickle.dumps(("refused", "it claims to hold far more than fits into a file of its size"))
    try:
        content = pickle.dumps(("loaded", LOADERS[form](path)))
        return content if len(content) <= most else too_large
    except MissingPackage as error:
        return pickle.dumps(("missing", str(error)))
    except MemoryError:
        return too_large
    except Exception as error:  # these libraries pass on whatever they meet with
        return pickle.dumps(("refused", (str(error).splitlines() or [type(error).__name__])[0]))


def _limit_memory(size: int) -> None:
    if sys.platform == "win32":
        return
    import resource

    _, most = resource.getrlimit(resource.RLIMIT_AS)
    size = size if most == resource.RLIM_INFINITY else min(size, most)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (size, most))
    except (OSError, ValueError):  # a system that knows no such limit
        return


def serve(requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests until they end."""
    while True:
        try:
            form, path, memory, most = pickle.load(requests)
        except EOFError:
            return
        _limit_memory(memory)
        answers.write(answer(form, path, most))
        answers.flush()


def _main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asked
    warnings.simplefilter("ignore")
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    _main()
