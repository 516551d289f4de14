"""Simulation of an FMU over a table: a third-party FMU runs in a separate process, a self-built FMU in this process.

A third-party FMU is native code: it may hang, crash, end the process or write to the terminal. Its process has a time
limit, a temporary working folder and no terminal. It and the processes that it started end with this process.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import numpy.typing as npt
from fmpy.fmi1 import FMICallException

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FmuError
from ...boundary.escaping import excerpt
from .archive import DESCRIPTION, unpacked
from .slave import ANSWER, ARRAYS, JOB, OUTPUTS, Rejected, Slave

FloatArray = npt.NDArray[np.float64]

#: Time limit of a simulation, and its increase per row, s.
TIME_LIMIT, TIME_LIMIT_PER_ROW = 60.0, 0.005
#: The largest answer of the process, bytes.
LARGEST_ANSWER = 1_000_000


@dataclass(frozen=True)
class Simulation:
    """The result of a simulation.

    - `outputs`, shape (n_rows, n_outputs): the rows of all runs in sequence.
    - `problems`: problems found by fmpy's validation.
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
    starts: Sequence[Mapping[str, float]] = (),
) -> Simulation:
    """Simulate an unpacked FMU over a table in a separate process.

    `path`: the FMU, for messages. `folder`: the unpacked FMU. `time`, shape (n,). `rows`, shape (n, n_inputs).
    `inputs`, `outputs`: names of variables. `runs`: rows of each run, which starts with a new initialization. Runs may
    have the same rows. `timeout`: time limit, s; None for `TIME_LIMIT` and `TIME_LIMIT_PER_ROW`. `starts`: start values
    of real variables for each run; default: those of the FMU. Raises `FmuError` if the FMU cannot be loaded, rejects a
    call, crashes, ends its process, or exceeds the time limit.
    """
    simulated = sum(run.stop - run.start for run in runs)
    limit = TIME_LIMIT + TIME_LIMIT_PER_ROW * simulated if timeout is None else timeout
    if not (isfinite(limit) and limit > 0.0):
        raise FmuError(f"timeout = {limit:g} s is not a positive finite time")
    with tempfile.TemporaryDirectory(prefix="tirefmu-", ignore_cleanup_errors=True) as name:
        scratch = Path(name)
        job: dict[str, Any] = {"fmu": str(folder), "inputs": list(inputs), "outputs": list(outputs)}
        ends = [(run.start, run.stop) for run in runs]
        job |= {"runs": ends, "starts": [dict(values) for values in starts]}
        (scratch / JOB).write_text(json.dumps(job), encoding="utf-8")
        np.savez(scratch / ARRAYS, time=time, rows=rows)
        ended = _run(scratch, limit)
        if ended is None:
            raise FmuError(f"{path}: the FMU does not end within {limit:g} s; --timeout SECONDS sets the limit")
        try:
            answer = _answer(scratch / ANSWER)
            if answer is None:
                raise FmuError(f"{path}: {_how_it_ended(ended)}")
            if "error" in answer:
                raise FmuError(f"{path}: {excerpt(str(answer['error']).replace(f'{folder}{os.sep}', ''))}")
            numbers = np.load(scratch / OUTPUTS, allow_pickle=False)
            if numbers.shape != (simulated, len(outputs)):
                raise ValueError(f"outputs of shape {numbers.shape}")
            return Simulation(numbers.astype(np.float64), tuple(excerpt(problem) for problem in answer["problems"]))
        except (OSError, ValueError, KeyError, TypeError, EOFError, RecursionError) as error:
            raise FmuError(f"{path}: the FMU's process wrote an invalid answer ({excerpt(error)})") from error


def _run(scratch: Path, limit: float) -> int | None:
    """Run the job in a folder in a separate process; return its exit code, None after the time limit."""
    program = Path(__file__).with_name("slave.py")
    process = subprocess.Popen(
        [sys.executable, "-P", str(program), str(scratch)],  # -P: modules of the same folder cannot be imported by name
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C reaches this process only, and all child processes can be ended
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
    """Return the answer of the process, or None if there is none."""
    if not path.is_file():
        return None
    answer = json.loads(read_bounded(path, LARGEST_ANSWER))
    if not isinstance(answer, dict):
        raise ValueError("not an object")
    return answer


def _how_it_ended(status: int) -> str:
    """Return how a process without an answer ended."""
    if status < 0:
        try:
            name = signal.Signals(-status).name
        except ValueError:
            name = f"signal {-status}"
        return f"the FMU crashed ({name})"
    if status >= 0x80000000:
        return f"the FMU crashed ({status:#x})"  # as shown by Windows
    return f"the FMU ended its process (exit code {status})"


def read_description(path: str | os.PathLike[str], folder: Path) -> Any:
    """Return the model description of an unpacked FMU, without validation.

    `path`: the FMU, for messages. `folder`: the unpacked FMU. Raises `FmuError` if it is invalid, or the FMU does not
    support Co-Simulation of FMI 2 or 3.
    """
    try:
        description = fmpy.read_model_description(str(folder), validate=False)
    except Exception as error:  # fmpy raises many types for invalid XML
        raise FmuError(f"{path}: not an FMU ({DESCRIPTION}: {excerpt(error)})") from error
    if description.fmiVersion[:2] not in ("2.", "3."):
        raise FmuError(f"{path}: FMI {excerpt(description.fmiVersion)} is not supported: supported are 2 and 3")
    if description.coSimulation is None:
        raise FmuError(f"{path}: the FMU does not support Co-Simulation")
    identifier = description.coSimulation.modelIdentifier
    if not isinstance(identifier, str) or not re.fullmatch(r"[A-Za-z_]\w*", identifier, re.ASCII):
        raise FmuError(f"{path}: modelIdentifier '{excerpt(identifier)}' is not a C identifier")
    return description


@contextmanager
def loaded(path: str | os.PathLike[str]) -> Iterator[Slave]:
    """Unpack an FMU and load it into this process, and clean up afterwards; for trusted FMUs only.

    Yields: instantiated, not initialized. Raises `FmuError` if the file is not an FMU for Co-Simulation, cannot be
    loaded on this platform, or rejects a call.

    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> with loaded(export(published("trento_hoosier"), "tire.fmu")) as slave:
    ...     slave.run(slice(0, 1), np.zeros(1), np.array([[0.02]]), ["alpha"], ["Fz"])
    array([[220.]])
    """
    with instances(path, 1) as (slave,):
        yield slave


@contextmanager
def instances(path: str | os.PathLike[str], n: int) -> Iterator[list[Slave]]:
    """Unpack an FMU and create `n` instances of it in this process, as `loaded` does."""
    with unpacked(path) as folder:
        description = read_description(path, folder)
        slaves: list[Slave] = []
        try:
            for _ in range(n):
                slaves.append(Slave(description, folder))
            yield slaves
        except Rejected as error:
            raise FmuError(f"{path}: {excerpt(error)}") from error
        finally:
            for slave in slaves:
                slave.fmu.freeInstance()


class Coupled:
    """Instances of one FMU that start together, at 0 s. `inputs`, `outputs`: names of real variables."""

    def __init__(self, slaves: Sequence[Slave], inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self.slaves, self.inputs, self.outputs = slaves, inputs, outputs
        self._inputs, self._outputs = (slaves[0].references(names) for names in (inputs, outputs))
        self._time, self._starting = 0.0, True

    def exchange(self, rows: FloatArray, step: float = 0.0) -> FloatArray:
        """Return the outputs, shape (n, n_outputs), for inputs, shape (n, n_inputs); then step with these inputs.

        The first inputs are set during initialization: states start in steady state. No step if `step` is 0. Inputs
        that are not finite are not set, and their outputs are NaN. Raises `Rejected` if an instance rejects a call.
        """
        outputs = np.full((len(self.slaves), len(self.outputs)), np.nan)
        for i in np.flatnonzero(np.isfinite(rows).all(axis=1)).tolist():
            slave = self.slaves[i]
            try:
                if self._starting:
                    slave.begin(0.0)
                slave.set_reals(self._inputs, rows[i].tolist())
                if self._starting:
                    slave.fmu.exitInitializationMode()
                outputs[i] = slave.get_reals(self._outputs)
                if step > 0.0:
                    slave.fmu.doStep(self._time, step)
            except FMICallException as error:
                logged = f": {slave.log[-1]}" if slave.log else ""
                raise Rejected(f"{self._time:g} s: {str(error).rstrip('.')}{logged}") from error
        self._starting = False
        self._time += step
        return outputs
