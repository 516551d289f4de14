"""The tire of a pythonfmu FMU. This file is in the FMU's resources and may be edited there.

It needs NumPy and pythonfmu only. The same folder has `variables.json` (the variables in the order of their value
references), the model's generated NumPy code and `state_laws.py`, the laws by which states change.
"""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from math import atan, inf, isfinite, nan, pi, tan
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

#: Below this relaxation length a slip has no lag, m.
SHORTEST_LENGTH = 1e-6
#: The local variables of a tire with relaxation, last in the list.
LAGGED = ("kappa_lagged", "alpha_lagged")


class TireSlave(Fmi2Slave):
    """One tire: an array of values by value reference, as in the native FMU.

    Outputs are computed when they are read. A value that is not finite or outside its limits is rejected: an error is
    logged, and the next step is discarded. So it is after a force that is not finite. No exception is raised, as it
    would be fatal for the host.

    `**kwargs`: the arguments of pythonfmu: the instance's name and the folder of the resources.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(self.resources)
        content = json.loads((folder / "variables.json").read_text(encoding="utf-8"))
        self.variables = content["variables"]
        self.code = _load(folder / f"{content['model']}.py")
        self.laws = _load(folder / "state_laws.py")
        self.names = [variable["name"] for variable in self.variables]
        self.values = [variable["start"] for variable in self.variables]
        self.first_output = 1 + len(self.code.INPUTS)
        self.first_parameter = self.first_output + len(self.code.FORCES)
        self.first_local = self.first_parameter + len(self.code.PARAMETERS)
        self.lags = LAGGED[0] in self.names
        self.lagging: list[float] = []  # kappa and tan(alpha) since the end of initialization
        self.outputs_known = False
        self.rejected = False

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        """Set the start time of the simulation; pythonfmu before 0.7 passes nothing else."""
        self.values[0] = start_time

    def exit_initialization_mode(self) -> None:
        """Start the lagged slips in steady state."""
        self.lagging = self._given_slips()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Integrate with constant inputs: the exact solution of d x/dt = |V| / sigma (u - x)."""
        if self.rejected:
            self._log_error("the step is discarded because values were rejected: set valid values")
            return False
        if not (isfinite(current_time) and isfinite(step_size) and step_size >= 0.0):
            self._log_error(f"the step size must be positive and finite, not {step_size:g}")
            return False
        speed = abs(self._input("V")) if "V" in self.code.INPUTS else 0.0
        if self.lags:
            lengths = self._lengths()
            for i, (given, length) in enumerate(zip(self._given_slips(), lengths, strict=True)):
                share = speed * step_size / length if length > SHORTEST_LENGTH else inf
                self.lagging[i] = float(self.laws.lag(self.lagging[i], given, given, share))
        if "distance" in self.code.INPUTS:
            index = self.names.index("distance")
            if self.variables[index]["causality"] != "input":
                self.values[index] = self.laws.sum_linear(self.values[index], speed, speed, step_size)
        self.values[0] = current_time + step_size
        self.outputs_known = False
        return True

    def get_real(self, vrs: Sequence[int]) -> list[float]:
        """Return values; outputs belong to the present inputs. NaN for an unknown value reference."""
        for reference in vrs:
            if self._causality(reference) == "hidden":
                self._log_error(f"there is no value reference {reference}")
            elif self._causality(reference) in ("output", "local"):
                self._compute_outputs()
        return [nan if self._causality(r) == "hidden" else float(self.values[r]) for r in vrs]

    def set_real(self, vrs: Sequence[int], values: Sequence[float]) -> None:
        """Set all values, or none if one is invalid."""
        given = list(zip(vrs, values, strict=True))
        wrong = [sentence for reference, value in given if (sentence := self._objection(reference, value))]
        self.rejected = bool(wrong)
        if wrong:
            self._log_error(wrong[0])
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
                    state if length > SHORTEST_LENGTH else slip
                    for slip, state, length in zip(slips, self.lagging, lengths, strict=True)
                ]
            acting = [slips[0], atan(slips[1])]
            for name, slip in zip(("kappa", "alpha"), acting, strict=True):
                inputs[self.code.INPUTS.index(name)] = slip
            self.values[self.first_local :] = acting
        with np.errstate(all="ignore"):
            forces = self.code.forces(inputs, self._parameters())
        self.values[self.first_output : self.first_parameter] = map(float, forces)
        self.outputs_known = True
        if not all(isfinite(value) for value in self.values[self.first_output : self.first_parameter]):
            self.rejected = True  # get_real cannot return a status
            self._log_error("a force is not finite: the inputs or parameters are not those of a tire")

    def _input(self, name: str) -> float:
        return float(self.values[1 + self.code.INPUTS.index(name)])

    def _parameters(self) -> list[float]:
        return self.values[self.first_parameter : self.first_local]

    def _given_slips(self) -> list[float]:
        alpha = self._input("alpha")  # beyond 90 deg the lateral slip is that of the supplement, as in the formula
        return [self._input("kappa"), -tan(alpha) if abs(alpha) > pi / 2 else tan(alpha)]

    def _lengths(self) -> list[float]:
        with np.errstate(all="ignore"):
            return [float(x) for x in self.code.relaxation(self.values[1 : self.first_output], self._parameters())]

    def _causality(self, reference: int) -> str:
        exists = 0 <= reference < len(self.variables)
        return str(self.variables[reference]["causality"]) if exists else "hidden"

    def _objection(self, reference: int, value: float) -> str:
        """Return why a value is rejected; empty if it is accepted."""
        if self._causality(reference) == "hidden":
            return f"there is no value reference {reference}"
        variable = self.variables[reference]
        if variable["causality"] not in ("input", "parameter"):
            return f"{variable['name']} cannot be set"
        if not isfinite(value):
            return f"{variable['name']} must be finite, not {value:g}"
        if not variable.get("min", -inf) <= value <= variable.get("max", inf):
            return f"{variable['name']} = {value:g} is outside its limits"
        return ""

    def _log_error(self, sentence: str) -> None:
        self.log(sentence, Fmi2Status.error)


def _load(path: Path) -> ModuleType:
    """Return a module from a file, under a name that does not collide with other FMUs in this process."""
    spec = importlib.util.spec_from_file_location(f"{path.stem}_of_tire", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
