"""The tire of a pythonfmu FMU: this file lies in the FMU's resources and may be changed there.

It needs NumPy and pythonfmu only. Beside it lie `variables.json` (the variables in the order of their value
references) and the model's generated NumPy code.
"""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from math import atan, exp, expm1, inf, isfinite, nan, tan
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

#: Below this relaxation length a slip acts at once, m.
AT_ONCE = 1e-6
#: The locals of a tire with relaxation, last of all.
LAGGED = ("kappa_lagged", "alpha_lagged")


class TireSlave(Fmi2Slave):
    """One tire: an array of values by value reference, as in the native FMU.

    Outputs are computed when they are read. A value that is not finite or outside its limits is not taken over:
    the host is told, and the next step discarded. An exception would be fatal for the host: none is raised.

    Parameters
    ----------
    **kwargs
        What pythonfmu hands over: the instance's name and the folder of the resources.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(self.resources)
        told = json.loads((folder / "variables.json").read_text(encoding="utf-8"))
        self.variables = told["variables"]
        self.code = _load(folder / f"{told['model']}.py")
        self.names = [variable["name"] for variable in self.variables]
        self.values = [variable["start"] for variable in self.variables]
        self.first_output = 1 + len(self.code.INPUTS)
        self.first_parameter = self.first_output + len(self.code.FORCES)
        self.first_local = self.first_parameter + len(self.code.PARAMETERS)
        self.lags = LAGGED[0] in self.names
        self.lagging: list[float] = []  # kappa and tan(alpha) since the end of initialization
        self.outputs_known = False
        self.refused = False

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Take over the time at which the simulation starts."""
        self.values[0] = start_time

    def exit_initialization_mode(self) -> None:
        """Let slips lag from here on, beginning in steady state."""
        self.lagging = self._given_slips()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Roll on with the inputs held: the exact solution of d x/dt = |V| / sigma (u - x)."""
        if self.refused:
            self._tell("no step is made with values that were refused: set others")
            return False
        if not (isfinite(current_time) and isfinite(step_size) and step_size > 0.0):
            self._tell(f"a step size has to be positive and finite, not {step_size:g}")
            return False
        rolled = abs(self._input("V")) * step_size if "V" in self.code.INPUTS else 0.0
        if self.lags:
            lengths = self._lengths()
            for i, (given, length) in enumerate(zip(self._given_slips(), lengths, strict=True)):
                share = rolled / length if length > AT_ONCE else inf
                self.lagging[i] = exp(-share) * self.lagging[i] - expm1(-share) * given
        if "distance" in self.code.INPUTS:
            place = self.names.index("distance")
            if self.variables[place]["causality"] != "input":
                self.values[place] += rolled
        self.values[0] = current_time + step_size
        self.outputs_known = False
        return True

    def get_real(self, vrs: Sequence[int]) -> list[float]:
        """Return values, outputs being those of the inputs as they are set; NaN where there is no variable."""
        for reference in vrs:
            if self._causality(reference) == "hidden":
                self._tell(f"there is no value reference {reference}")
            elif self._causality(reference) in ("output", "local"):
                self._compute_outputs()
        return [nan if self._causality(r) == "hidden" else float(self.values[r]) for r in vrs]

    def set_real(self, vrs: Sequence[int], values: Sequence[float]) -> None:
        """Set all of the values, or none of them."""
        given = list(zip(vrs, values, strict=True))
        wrong = [sentence for reference, value in given if (sentence := self._objection(reference, value))]
        self.refused = bool(wrong)
        if wrong:
            self._tell(wrong[0])
            return
        for reference, value in given:
            self.values[reference] = value
        self.outputs_known = False

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"values": list(self.values), "lagging": list(self.lagging)}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self.values, self.lagging = list(state["values"]), list(state["lagging"])
        self.outputs_known = False

    def _compute_outputs(self) -> None:
        if self.outputs_known:
            return
        inputs = self.values[1 : self.first_output]
        if self.lags:
            slips = self._given_slips()
            if self.lagging:
                lengths = self._lengths()
                slips = [
                    state if length > AT_ONCE else slip
                    for slip, state, length in zip(slips, self.lagging, lengths, strict=True)
                ]
            acting = [slips[0], atan(slips[1])]
            for name, slip in zip(self.code.SLIPS, acting, strict=True):
                inputs[self.code.INPUTS.index(name)] = slip
            self.values[self.first_local :] = acting
        with np.errstate(all="ignore"):
            forces = self.code.forces(inputs, self._parameters())
        self.values[self.first_output : self.first_parameter] = map(float, forces)
        self.outputs_known = True

    def _input(self, name: str) -> float:
        return float(self.values[1 + self.code.INPUTS.index(name)])

    def _parameters(self) -> list[float]:
        return self.values[self.first_parameter : self.first_local]

    def _given_slips(self) -> list[float]:
        return [self._input("kappa"), tan(self._input("alpha"))]

    def _lengths(self) -> list[float]:
        with np.errstate(all="ignore"):
            return [float(x) for x in self.code.relaxation(self.values[1 : self.first_output], self._parameters())]

    def _causality(self, reference: int) -> str:
        known = 0 <= reference < len(self.variables)
        return str(self.variables[reference]["causality"]) if known else "hidden"

    def _objection(self, reference: int, value: float) -> str:
        """Return why a value is not taken over; empty if it is."""
        if self._causality(reference) == "hidden":
            return f"there is no value reference {reference}"
        variable = self.variables[reference]
        if variable["causality"] not in ("input", "parameter"):
            return f"{variable['name']} cannot be set"
        if not isfinite(value):
            return f"{variable['name']} has to be finite, not {value:g}"
        if not variable.get("min", -inf) <= value <= variable.get("max", inf):
            return f"{variable['name']} = {value:g} is outside its limits"
        return ""

    def _tell(self, sentence: str) -> None:
        self.log(sentence, Fmi2Status.error)


def _load(path: Path) -> ModuleType:
    """Return a module from a file, under no name that another FMU in this process could have taken."""
    spec = importlib.util.spec_from_file_location(f"{path.stem}_of_tire", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
