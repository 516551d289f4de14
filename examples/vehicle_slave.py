"""The vehicle as an FMU (FMI 2, by pythonfmu). Inputs: tire forces, driver controls. Outputs: slips, vehicle motion."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from math import ceil
from typing import Any

from printed_vehicle import CONTROLS, FORCES, RADIUS, SLIPS, STATES, derivatives, slips
from pythonfmu import Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real

#: s, upper limit of the integration step, independent of the communication step: the error is that of the coupling.
LONGEST_STEP = 0.0005


class Vehicle(Fmi2Slave):
    """Eleven states, integrated by the Runge-Kutta method of fourth order with constant inputs."""

    description = "two-track vehicle with roll, pitch and four wheels"

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.v_start = 15.0
        self.controls = dict.fromkeys(CONTROLS, 0.0)
        self.forces = dict.fromkeys(FORCES, 0.0)
        self.state = self._rolling()
        self._register("v_start", Fmi2Causality.parameter, vars(self))
        for names, values in ((CONTROLS, self.controls), (FORCES, self.forces)):
            for name in names:
                self._register(name, Fmi2Causality.input, values)
        for index, name in enumerate(SLIPS):
            self._output(name, lambda index=index: slips(self.state, self.controls.values())[index])
        for index, name in enumerate(STATES):
            self._output(name, lambda index=index: self.state[index])

    def exit_initialization_mode(self) -> None:
        """Set the initial state: straight ahead, with freely rolling wheels."""
        self.state = self._rolling()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the states with constant inputs."""
        n = max(1, ceil(step_size / LONGEST_STEP - 1e-9))
        h = step_size / n
        for _ in range(n):
            k1 = self._slope(self.state)
            k2 = self._slope([x + h / 2 * k for x, k in zip(self.state, k1, strict=True)])
            k3 = self._slope([x + h / 2 * k for x, k in zip(self.state, k2, strict=True)])
            k4 = self._slope([x + h * k for x, k in zip(self.state, k3, strict=True)])
            self.state = [
                x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(self.state, k1, k2, k3, k4, strict=True)
            ]
        return True

    def to_xml(self, model_options: dict[str, str] | None = None) -> ET.Element:
        """Return the model description with the initial unknowns, which pythonfmu omits."""
        root = super().to_xml(model_options or {})
        structure = root.find("ModelStructure")
        unknowns = ET.SubElement(structure, "InitialUnknowns")
        for output in structure.find("Outputs"):
            ET.SubElement(unknowns, "Unknown", dict(output.attrib))
        return root

    def _slope(self, state: list[float]) -> list[float]:
        return derivatives(state, self.controls.values(), self.forces.values())

    def _rolling(self) -> list[float]:
        return [self.v_start, *[0.0] * 6, *[self.v_start / RADIUS] * 4]

    def _register(self, name: str, causality: Fmi2Causality, values: dict[str, float]) -> None:
        parameter = causality == Fmi2Causality.parameter
        variability = Fmi2Variability.fixed if parameter else Fmi2Variability.continuous
        self.register_variable(
            Real(
                name,
                causality=causality,
                variability=variability,
                initial=Fmi2Initial.exact if parameter else None,
                getter=lambda: values[name],
                setter=lambda value: values.update({name: value}),
            )
        )

    def _output(self, name: str, getter: Any) -> None:
        self.register_variable(Real(name, causality=Fmi2Causality.output, getter=getter))
