"""Instances of an FMU that a master steps together, in this process."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from fmpy.fmi1 import FMICallException

from .slave import Rejected, Slave

FloatArray = npt.NDArray[np.float64]


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
