"""An instance of an FMU for Co-Simulation and its simulation over the rows of a table; also a program.

fmpy's `simulate_fmu` looks up every variable by name at every step, and a bench file has more than 100,000 rows. This
loop makes the same three calls with reused arrays.

`simulate.py` starts this file as a program, so that an FMU that crashes does not end the calling process. The file
imports nothing of this package: such an import takes ten times as long as a typical check.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import numpy.typing as npt
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave

FloatArray = npt.NDArray[np.float64]

#: Largest number of log lines that are stored, and of characters per line.
MAX_LINES, LONGEST_LINE = 1000, 500
#: Largest number of validation problems that are reported.
MAX_PROBLEMS = 100
#: The files of a job: the task, its arrays, the outputs, and the answer, which is written last.
JOB, ARRAYS, OUTPUTS, ANSWER = "job.json", "arrays.npz", "outputs.npy", "answer.json"


class Rejected(Exception):
    """The FMU cannot be loaded, or rejects a call; one sentence."""


@dataclass
class Slave:
    """An instance of an FMU for Co-Simulation, of either FMI version, and its log.

    - `folder`: the unpacked FMU.
    - `log`: the lines that the instance logged.
    - `version_3`: true for FMI 3, False for FMI 2.

    Raises `Rejected` if there is no binary for this platform, if it is incomplete, or if it creates no instance.
    """

    description: Any
    folder: Path
    log: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.version_3 = self.description.fmiVersion.startswith("3")
        try:
            self._instantiate()
        except Exception as error:  # fmpy has no exception type of its own
            raise Rejected(f"cannot be loaded: {error}") from error

    def _instantiate(self) -> None:
        kind = FMU3Slave if self.version_3 else FMU2Slave
        self.fmu: Any = kind(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="check",
        )
        if self.version_3:
            self.fmu.instantiate(
                loggingOn=True, logMessage=lambda _environment, _status, _category, line: self._note(line)
            )
        else:
            # fmpy's memory functions and this module's logger; fmpy holds a reference to them.
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(
                lambda _environment, _name, _status, _category, line: self._note(line)
            )
            callbacks.allocateMemory = defaultCallbacks.allocateMemory
            callbacks.freeMemory = defaultCallbacks.freeMemory
            self.fmu.instantiate(callbacks=callbacks, loggingOn=True)

    def _note(self, line: bytes | None) -> None:
        if len(self.log) == MAX_LINES:
            del self.log[0]
        self.log.append((line or b"")[:LONGEST_LINE].decode("utf-8", "replace"))

    def references(self, names: Sequence[str]) -> list[int]:
        """Return the value references of variables."""
        references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        return [references[name] for name in names]

    def set_reals(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Set real variables."""
        (self.fmu.setFloat64 if self.version_3 else self.fmu.setReal)(references, values)

    def get_reals(self, references: Sequence[int]) -> list[float]:
        """Return the values of real variables."""
        return list((self.fmu.getFloat64 if self.version_3 else self.fmu.getReal)(references))

    def begin(self, time: float, starts: Mapping[str, float] | None = None) -> None:
        """Reset the instance, set start values of real variables, and initialize it at a time."""
        self.fmu.reset()
        if starts:
            self.set_reals(self.references(list(starts)), list(starts.values()))
        if self.version_3:
            self.fmu.enterInitializationMode(startTime=time)
        else:
            self.fmu.setupExperiment(startTime=time)
            self.fmu.enterInitializationMode()

    def run(
        self, rows: slice, time: FloatArray, inputs: FloatArray, input_names: Sequence[str],
        output_names: Sequence[str], starts: Mapping[str, float] | None = None,
    ) -> FloatArray:  # fmt: skip
        """Return the outputs of each row of inputs; inputs are constant over the step to the next row.

        The first row is set during initialization: states start in steady state.

        `rows`: the rows of a table to simulate, after a new initialization. `time`, shape (n_table,): not decreasing in
        these rows; there is no step between rows of equal time. `inputs`, shape (n_table, n_inputs). `starts`: start
        values of other variables. Returns shape (n_rows, n_outputs). Raises `Rejected` if the FMU rejects a call; the
        message has the row and the last log line.
        """
        fmu, instance = self.fmu, self.fmu.component
        n_in, n_out = len(input_names), len(output_names)
        in_refs = (ctypes.c_uint * n_in)(*self.references(input_names))
        out_refs = (ctypes.c_uint * n_out)(*self.references(output_names))
        given, results = (ctypes.c_double * n_in)(), (ctypes.c_double * n_out)()
        flags = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        reached = ctypes.byref(ctypes.c_double())
        times = time[rows]
        steps = np.diff(times, append=times[-1:])
        outputs = np.empty((len(times), n_out))
        i = 0
        try:
            self.begin(float(times[0]), starts)
            table = zip(times.tolist(), steps.tolist(), inputs[rows].tolist(), strict=True)
            for i, (now, step, row) in enumerate(table):
                given[:] = row
                if self.version_3:
                    fmu.fmi3SetFloat64(instance, in_refs, n_in, given, n_in)
                    if i == 0:
                        fmu.exitInitializationMode()
                    fmu.fmi3GetFloat64(instance, out_refs, n_out, results, n_out)
                    if step > 0.0:
                        fmu.fmi3DoStep(instance, now, step, True, *flags, reached)
                else:
                    fmu.fmi2SetReal(instance, in_refs, n_in, given)
                    if i == 0:
                        fmu.exitInitializationMode()
                    fmu.fmi2GetReal(instance, out_refs, n_out, results)
                    if step > 0.0:
                        fmu.fmi2DoStep(instance, now, step, True)
                outputs[i] = results
        except FMICallException as error:
            logged = f": {self.log[-1]}" if self.log else ""
            raise Rejected(f"row {rows.start + i}: {str(error).rstrip('.')}{logged}") from error
        return outputs


def main(folder: Path) -> None:
    """Run the job in a folder and write the answer there: outputs by row and problems, or the error."""
    _end_with_parent()
    os.chdir(folder)  # files that the FMU writes without a path are deleted with the job
    job = json.loads((folder / JOB).read_text(encoding="utf-8"))
    try:
        answer = _run(job, folder)
    except Rejected as error:
        answer = {"error": str(error)}
    except Exception as error:  # any exception of fmpy
        answer = {"error": f"{type(error).__name__}: {error}"}
    (folder / "unfinished").write_text(json.dumps(answer), encoding="utf-8")
    os.replace(folder / "unfinished", folder / ANSWER)
    os._exit(0)  # no exit handler of the FMU runs


def _run(job: dict[str, Any], folder: Path) -> dict[str, Any]:
    from fmpy.validation import validate_fmu

    problems = validate_fmu(job["fmu"])[:MAX_PROBLEMS]
    with np.load(folder / ARRAYS) as arrays:
        time, rows = arrays["time"], arrays["rows"]
    slave = Slave(fmpy.read_model_description(job["fmu"], validate=False), Path(job["fmu"]))
    starts = job["starts"] or [None] * len(job["runs"])
    runs = [
        slave.run(slice(*ends), time, rows, job["inputs"], job["outputs"], start)
        for ends, start in zip(job["runs"], starts, strict=True)
    ]
    slave.fmu.freeInstance()
    np.save(folder / OUTPUTS, np.vstack(runs), allow_pickle=False)
    return {"problems": problems}


def _end_with_parent() -> None:
    """End this process when its parent ends, which closes the standard input."""

    def watch() -> None:
        os.read(0, 1)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    try:
        import resource
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a crash writes no core file


if __name__ == "__main__":
    main(Path(sys.argv[1]))
