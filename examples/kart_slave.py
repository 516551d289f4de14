"""The body of the kart as an FMU (FMI 2, by pythonfmu): forces of the tires in, motion of the wheel carriers out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import Any

import numpy as np
from kart_body import MOTION, WRENCH, accelerations, carriers, start
from kart_manoeuvres import MANOEUVRES
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
from scipy.spatial.transform import Rotation

NAMES = ("FL", "FR", "RL", "RR")
#: The wheels begin freely rolling at 15 m/s.
SYSTEM = replace(MANOEUVRES["brake-in-turn"], speed=15.0)
BODY = ("r_x", "r_y", "r_z", "v_x", "v_y", "v_z")


class Kart(Fmi2Slave):
    """A body that brakes in a turn, with forces that are constant over a step."""

    description = "rigid body of a kart on four tires, its driver, its brakes and its road"

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.wrench = {f"{corner}_{name}": 0.0 for corner in NAMES for name in WRENCH}
        self.r, self.turned, self.v, self.w = start(SYSTEM)
        self.shown: dict[str, float] = {}
        self._show(0.0)
        for name in self.wrench:
            self.register_variable(
                Real(
                    name,
                    causality=Fmi2Causality.input,
                    start=0.0,
                    getter=lambda name=name: self.wrench[name],
                    setter=lambda value, name=name: self.wrench.update({name: value}),
                )
            )
        for name in self.shown:
            shows = Real(name, causality=Fmi2Causality.output, getter=lambda name=name: self.shown[name])
            self.register_variable(shows)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the body."""
        h, middle = step_size, current_time + 0.5 * step_size
        wrench = np.reshape(list(self.wrench.values()), (len(NAMES), len(WRENCH)))
        a, turning = accelerations(self.inputs, wrench, SYSTEM.drive(middle), self.turned, self.w)
        self.v, self.w = self.v + h * a, self.w + h * turning
        self.r, self.turned = self.r + h * self.v, Rotation.from_rotvec(h * self.w) * self.turned
        self._show(current_time + h)
        return True

    def to_xml(self, model_options: dict[str, str] | None = None) -> ET.Element:
        """Return the model description with the initial unknowns, which pythonfmu omits."""
        root = super().to_xml(model_options or {})
        structure = root.find("ModelStructure")
        unknowns = ET.SubElement(structure, "InitialUnknowns")
        for output in structure.find("Outputs"):
            ET.SubElement(unknowns, "Unknown", dict(output.attrib))
        return root

    def _show(self, t: float) -> None:
        """Compute the outputs: motion of the carriers and road, torques, and motion of the body."""
        self.inputs = carriers(SYSTEM, t, self.r, self.turned, self.v, self.w)
        self.shown.update(zip(BODY, [*self.r, *self.v], strict=True))
        for corner, motion, drive, brake in zip(NAMES, self.inputs, SYSTEM.drive(t), SYSTEM.brake(t), strict=True):
            names = [f"{corner}_{name}" for name in (*MOTION, "T_drive", "T_brake")]
            self.shown.update(zip(names, map(float, [*motion, drive, brake]), strict=True))
