"""An FMU run over the rows of a table, by fmpy.

fmpy's `simulate_fmu` looks every variable up by name at every step; a bench file has more than 100,000 rows.
This loop makes the same three calls with arrays that it fills again and again.
"""

from __future__ import annotations

import ctypes
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import numpy.typing as npt
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave

from tirefmu.symbolic.errors import FmuError

FloatArray = npt.NDArray[np.float64]


@dataclass
class Slave:
    """An instance of an FMU for Co-Simulation, whichever version, and what it said.

    Attributes
    ----------
    description : fmpy.model_description.ModelDescription
    folder : Path
        Where the FMU is unpacked.
    log : list of str
        The lines that the instance logged.
    fmu : fmpy.fmi2.FMU2Slave or fmpy.fmi3.FMU3Slave
    version_3 : bool
        FMI 3 rather than FMI 2.
    """

    description: Any
    folder: Path
    log: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        version_3 = self.description.fmiVersion.startswith("3")
        kind = FMU3Slave if version_3 else FMU2Slave
        self.fmu: Any = kind(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="check",
        )
        self.version_3 = version_3
        if version_3:
            self.fmu.instantiate(logMessage=lambda _environment, _status, _category, line: self._note(line))
        else:
            # fmpy's functions for memory, a logger of ours; fmpy keeps them as long as the instance.
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(
                lambda _environment, _name, _status, _category, line: self._note(line)
            )
            callbacks.allocateMemory = defaultCallbacks.allocateMemory
            callbacks.freeMemory = defaultCallbacks.freeMemory
            self.fmu.instantiate(callbacks=callbacks)

    def _note(self, line: bytes) -> None:
        self.log.append(line.decode("utf-8", "replace"))

    def references(self, names: Sequence[str]) -> list[int]:
        """Return the value references of variables."""
        known = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        return [known[name] for name in names]

    def begin(self, time: float) -> None:
        """Begin anew: initialize at a time."""
        self.fmu.reset()
        if self.version_3:
            self.fmu.enterInitializationMode(startTime=time)
        else:
            self.fmu.setupExperiment(startTime=time)
            self.fmu.enterInitializationMode()

    def run(
        self, rows: slice, time: FloatArray, inputs: FloatArray, known: Sequence[str], asked: Sequence[str]
    ) -> FloatArray:
        """Return the outputs that belong to each row of inputs, holding each row over the step to the next.

        The first row is there when initialization ends: what has a state begins in steady state.

        Parameters
        ----------
        rows : slice
            The rows of a table to run, from a start of their own.
        time : ndarray, shape (n_table,), s
            Never falling in these rows; those of equal time follow each other without a step.
        inputs : ndarray, shape (n_table, n_inputs)
        known, asked : sequence of str
            Names of the inputs and of the outputs.

        Returns
        -------
        ndarray, shape (n_rows, n_outputs)

        Raises
        ------
        FmuError
            If the FMU refuses a call; names the row and what the FMU logged.
        """
        fmu, instance = self.fmu, self.fmu.component
        n_in, n_out = len(known), len(asked)
        in_refs = (ctypes.c_uint * n_in)(*self.references(known))
        out_refs = (ctypes.c_uint * n_out)(*self.references(asked))
        given, found = (ctypes.c_double * n_in)(), (ctypes.c_double * n_out)()
        flags = [ctypes.byref(ctypes.c_bool()) for _ in range(3)]
        reached = ctypes.byref(ctypes.c_double())
        times = time[rows]
        steps = np.diff(times, append=times[-1:])
        outputs = np.empty((len(times), n_out))
        i = 0
        try:
            self.begin(float(times[0]))
            table = zip(times.tolist(), steps.tolist(), inputs[rows].tolist(), strict=True)
            for i, (now, step, row) in enumerate(table):
                given[:] = row
                if self.version_3:
                    fmu.fmi3SetFloat64(instance, in_refs, n_in, given, n_in)
                    if i == 0:
                        fmu.exitInitializationMode()
                    fmu.fmi3GetFloat64(instance, out_refs, n_out, found, n_out)
                    if step > 0.0:
                        fmu.fmi3DoStep(instance, now, step, True, *flags, reached)
                else:
                    fmu.fmi2SetReal(instance, in_refs, n_in, given)
                    if i == 0:
                        fmu.exitInitializationMode()
                    fmu.fmi2GetReal(instance, out_refs, n_out, found)
                    if step > 0.0:
                        fmu.fmi2DoStep(instance, now, step, True)
                outputs[i] = found
        except FMICallException as error:
            said = f": {self.log[-1]}" if self.log else ""
            raise FmuError(f"row {rows.start + i}: {str(error).rstrip('.')}{said}") from error
        return outputs


def read_description(path: str | os.PathLike[str]) -> Any:
    """Return the model description of an FMU, not validated.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    fmpy.model_description.ModelDescription

    Raises
    ------
    FmuError
        If the file is missing, is no FMU, or is not for Co-Simulation.
    """
    if not Path(path).is_file():
        raise FmuError(f"{path}: no such file")
    try:
        description = fmpy.read_model_description(str(path), validate=False)
    except Exception as error:  # fmpy lets everything through that zip and XML can meet with
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise FmuError(f"{path}: not an FMU ({reason})") from error
    if description.coSimulation is None:
        raise FmuError(f"{path}: not an FMU for Co-Simulation")
    return description


@contextmanager
def loaded(path: str | os.PathLike[str]) -> Iterator[Slave]:
    """Unpack and load an FMU, and tidy up afterwards.

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
        If the file is no FMU for Co-Simulation, or cannot be loaded here.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> from .build import export
    >>> with loaded(export(published("trento_hoosier"), "tire.fmu")) as slave:
    ...     slave.run(slice(0, 1), np.zeros(1), np.array([[0.02]]), ["alpha"], ["Fz"])
    array([[220.]])
    """
    description = read_description(path)
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as name:
        folder = Path(fmpy.extract(str(path), unzipdir=name))
        try:
            slave = Slave(description, folder)
        except Exception as error:  # no binary for this platform, an incomplete one, a wrong token
            raise FmuError(f"{path}: cannot be loaded: {error}") from error
        try:
            yield slave
        finally:
            slave.fmu.freeInstance()
