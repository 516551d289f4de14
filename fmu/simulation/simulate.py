"""An FMU simulated over a table: in a process of its own where it is foreign, in this one where we have just built it.

A foreign FMU is native code: it may hang, crash, end the process or write to the terminal. The process that runs it
has a time limit, a temporary folder to work in, and no terminal; it ends with this one, and so does what it started.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.bounded_file import read_bounded
from tirefmu.symbolic.errors import FmuError
from tirefmu.symbolic.escaping import excerpt

from .archive import DESCRIPTION, unpacked
from .slave import ANSWER, ARRAYS, JOB, OUTPUTS, Refused, Slave

FloatArray = npt.NDArray[np.float64]

#: Time that a simulation may take, and what each row adds, s.
TIME_LIMIT, TIME_LIMIT_PER_ROW = 60.0, 0.005
#: The largest answer of the process, bytes.
LARGEST_ANSWER = 1_000_000


@dataclass(frozen=True)
class Simulation:
    """What an FMU gave.

    Attributes
    ----------
    outputs : ndarray, shape (n_rows, n_outputs)
        Of all runs, one after the other.
    problems : tuple of str
        What fmpy's validation found wrong with the FMU.
    """

    outputs: FloatArray
    problems: tuple[str, ...]


def simulate(
    path: str | os.PathLike[str],
    folder: Path,
    time: FloatArray,
    rows: FloatArray,
    inputs: Sequence[str],
    outputs: Sequence[str],
    runs: Sequence[slice],
    timeout: float | None = None,
) -> Simulation:
    """Run an unpacked FMU over a table in a process of its own.

    Parameters
    ----------
    path : path-like
        The FMU, for messages.
    folder : Path
        Where it is unpacked.
    time : ndarray, shape (n,), s
    rows : ndarray, shape (n, n_inputs)
    inputs, outputs : sequence of str
        Names of variables.
    runs : sequence of slice
        Rows that follow each other; each run begins anew.
    timeout : float, optional
        Time that it may take, s; `TIME_LIMIT` and `TIME_LIMIT_PER_ROW` where None.

    Returns
    -------
    Simulation

    Raises
    ------
    FmuError
        If the FMU cannot be loaded, refuses a call, crashes, ends its process, or takes longer.
    """
    limit = TIME_LIMIT + TIME_LIMIT_PER_ROW * len(time) if timeout is None else timeout
    if not (isfinite(limit) and limit > 0.0):
        raise FmuError(f"timeout = {limit:g} s is not a time that a simulation may take")
    with tempfile.TemporaryDirectory(prefix="tirefmu-", ignore_cleanup_errors=True) as name:
        scratch = Path(name)
        job = {"fmu": str(folder), "inputs": list(inputs), "outputs": list(outputs)}
        ends = [(run.start, run.stop) for run in runs]
        (scratch / JOB).write_text(json.dumps({**job, "runs": ends}), encoding="utf-8")
        np.savez(scratch / ARRAYS, time=time, rows=rows)
        ended = _run(scratch, limit)
        if ended is None:
            raise FmuError(f"{path}: the FMU does not end within {limit:g} s; --timeout SECONDS allows more")
        try:
            answer = _answer(scratch / ANSWER)
            if answer is None:
                raise FmuError(f"{path}: {_how_it_ended(ended)}")
            if "error" in answer:
                raise FmuError(f"{path}: {excerpt(str(answer['error']).replace(f'{folder}{os.sep}', ''))}")
            found = np.load(scratch / OUTPUTS, allow_pickle=False)
            if found.shape != (sum(end - start for start, end in ends), len(outputs)):
                raise ValueError(f"outputs of shape {found.shape}")
            return Simulation(found.astype(np.float64), tuple(excerpt(problem) for problem in answer["problems"]))
        except (OSError, ValueError, KeyError, TypeError, EOFError, RecursionError) as error:
            raise FmuError(f"{path}: the FMU's process left a broken answer ({excerpt(error)})") from error


def _run(scratch: Path, limit: float) -> int | None:
    """Run the process that does the job in a folder; return its exit status, None if it took too long."""
    program = Path(__file__).with_name("slave.py")
    process = subprocess.Popen(
        [sys.executable, "-P", str(program), str(scratch)],  # -P: the modules beside it are not for import by name
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # so that Ctrl-C reaches this process alone, and all that it started can be ended
        env={**os.environ, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(scratch))},
    )
    try:
        return process.wait(limit)
    except subprocess.TimeoutExpired:
        return None
    finally:
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()
        if process.stdin:
            process.stdin.close()


def _answer(path: Path) -> dict[str, Any] | None:
    """Return the answer of the process, or None if it left none."""
    if not path.is_file():
        return None
    answer = json.loads(read_bounded(path, LARGEST_ANSWER))
    if not isinstance(answer, dict):
        raise ValueError("not an object")
    return answer


def _how_it_ended(status: int) -> str:
    """Return how a process ended that left no answer."""
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        return f"the FMU crashed ({name})"
    if status >= 0x80000000:
        return f"the FMU crashed ({status:#x})"  # as Windows names it
    return f"the FMU ended its process (exit status {status})"


def read_description(path: str | os.PathLike[str], folder: Path) -> Any:
    """Return the model description of an unpacked FMU, not validated.

    Parameters
    ----------
    path : path-like
        The FMU, for messages.
    folder : Path
        Where it is unpacked.

    Returns
    -------
    fmpy.model_description.ModelDescription

    Raises
    ------
    FmuError
        If it is broken, or not for Co-Simulation by FMI 2 or 3.
    """
    try:
        description = fmpy.read_model_description(folder, validate=False)
    except Exception as error:  # fmpy lets everything through that XML can meet with
        raise FmuError(f"{path}: not an FMU ({DESCRIPTION}: {excerpt(error)})") from error
    if description.fmiVersion[:2] not in ("2.", "3."):
        raise FmuError(f"{path}: FMI {excerpt(description.fmiVersion)} is not known: known are 2 and 3")
    if description.coSimulation is None:
        raise FmuError(f"{path}: not an FMU for Co-Simulation")
    identifier = description.coSimulation.modelIdentifier
    if not isinstance(identifier, str) or not re.fullmatch(r"[A-Za-z_]\w*", identifier, re.ASCII):
        raise FmuError(f"{path}: modelIdentifier '{excerpt(identifier)}' is not a name in C")
    return description


@contextmanager
def loaded(path: str | os.PathLike[str]) -> Iterator[Slave]:
    """Unpack and load an FMU into this process, and tidy up afterwards; for FMUs of our own.

    Parameters
    ----------
    path : path-like

    Yields
    ------
    Slave
        Instantiated, not started.

    Raises
    ------
    FmuError
        If the file is no FMU for Co-Simulation, cannot be loaded here, or refuses a call.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> with loaded(export(published("trento_hoosier"), "tire.fmu")) as slave:
    ...     slave.run(slice(0, 1), np.zeros(1), np.array([[0.02]]), ["alpha"], ["Fz"])
    array([[220.]])
    """
    with unpacked(path) as folder:
        try:
            slave = Slave(read_description(path, folder), folder)
            try:
                yield slave
            finally:
                slave.fmu.freeInstance()
        except Refused as error:
            raise FmuError(f"{path}: {excerpt(error)}") from error
