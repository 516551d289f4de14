"""A tire of physics in place of a formula: brushes on a contact patch, with the same places for effects.

Pacejka, Tire and Vehicle Dynamics (2012), sections 3.2 and 3.3: a parabolic pressure, bristles of different stiffness
along and across, which slide where their stress exceeds friction. Friction falls with the load and in sliding. Adapted
SAE (Fy > 0 for alpha > 0).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .formulas import Effect, FloatArray, Inputs, changed
from .tires import Specimen

#: Powers of the load: friction, slip stiffnesses along and across, length of the contact patch.
OF_LOAD = {"friction": -0.12, "along": 0.9, "across": 0.72, "length": 0.5}
#: Share of friction that is lost in sliding, and the slip at which half of it is.
LOST, AT_SLIP = 0.15, 0.2


def forces(tire: Specimen, x: Inputs, effects: Sequence[Effect] = ()) -> dict[str, FloatArray]:
    """Return Fx, Fy and Mz of a brush tire; parameters as of `formulas.forces`."""
    change, load = changed(tire, x, effects), x["Fz"] / tire.load
    slip_x = x["kappa"] / (1.0 + x["kappa"])
    slip_y = (np.tan(x["alpha"]) + change.shift) / (1.0 + x["kappa"])
    squared = slip_x**2 + slip_y**2
    friction = load ** OF_LOAD["friction"] * (1.0 - LOST * squared / (squared + AT_SLIP**2))
    stress_x, stress_y = (
        tire.values[stiffness] * tire.load * load ** OF_LOAD[way] * of_effects * slip
        for stiffness, way, of_effects, slip in (
            ("PKX1", "along", change.stiffness_x, slip_x), ("PKY1", "across", change.stiffness_y, slip_y),
        )
    )  # fmt: skip
    limit_x = tire.values["PDX1"] * friction * change.friction_x * x["Fz"]
    limit_y = tire.values["PDY1"] * friction * change.friction_y * x["Fz"]
    demand = np.maximum(np.hypot(stress_x / limit_x, stress_y / limit_y), 1e-6)
    sliding = np.minimum(demand / 3.0, 1.0)  # the share of the patch in which bristles slide
    used = (1.0 - (1.0 - sliding) ** 3) / demand
    of_slip = stress_y * used
    trail = tire.values["QDZ1"] * tire.radius * load ** OF_LOAD["length"] * change.trail
    trail = trail * (1.0 - sliding) ** 3 / (1.0 - sliding + sliding**2 / 3.0)
    vertical = change.camber_thrust + change.side_force + change.kappa_side_force
    return {"Fx": stress_x * used, "Fy": of_slip + vertical, "Mz": -trail * of_slip + change.torque}
