"""A host of one instance for Model Exchange."""

from __future__ import annotations

import ctypes

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model

OK = 0


class Solver:
    """An instance for Model Exchange, called function by function; statuses instead of exceptions."""

    def __init__(self, path, folder):
        self.description = read_model_description(str(path))
        self.version = 3 if self.description.fmiVersion.startswith("3") else 2
        self.fmu = (FMU3Model if self.version == 3 else FMU2Model)(
            guid=self.description.guid,
            unzipDirectory=extract(str(path), unzipdir=str(folder)),
            modelIdentifier=self.description.modelExchange.modelIdentifier,
            instanceName="solver",
        )
        self.fmu.instantiate()
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.n_states = len(self.description.derivatives)

    def call(self, name, *arguments):
        try:
            self.result = getattr(self.fmu, name)(*arguments)
        except FMICallException as error:
            return error.status
        return OK

    def start(self):
        if self.version == 2:
            assert self.call("setupExperiment") == OK
        assert self.call("enterInitializationMode") == OK
        assert self.call("exitInitializationMode") == OK
        return self

    def update(self):
        assert self.call("updateDiscreteStates" if self.version == 3 else "newDiscreteStates") == OK
        return self.result

    def set(self, name, value):
        return self.call("setFloat64" if self.version == 3 else "setReal", [self.references[name]], [value])

    def get(self, *names):
        references = [self.references[name] for name in names]
        return np.array(self.fmu.getFloat64(references) if self.version == 3 else self.fmu.getReal(references))

    def states(self):
        return self._numbers("getContinuousStates")

    def rates(self):
        return self._numbers("getContinuousStateDerivatives" if self.version == 3 else "getDerivatives")

    def _numbers(self, function):
        values = (ctypes.c_double * self.n_states)()
        assert self.call(function, values, self.n_states) == OK
        return np.array(values)

    def set_states(self, *values):
        return self.call("setContinuousStates", (ctypes.c_double * len(values))(*values), len(values))
