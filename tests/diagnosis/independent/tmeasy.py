"""A tire of three points of each force curve in place of a formula, in the manner of TMeasy.

Rill, Road Vehicle Dynamics (2012), chapter 3: stiffness, peak and sliding force over a slip, each a parabola of the
load; one curve in the direction of a combined slip whose parts are normalized; a trail that changes its sign and ends.
A cubic joins peak and sliding. Adapted SAE (Fy > 0 for alpha > 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from .formulas import Effect, FloatArray, Inputs, changed
from .tires import Specimen

#: Change with the load, beyond proportional: slip stiffness, peak; slip of the peak.
OF_LOAD = {"stiffness": -0.17, "peak": -0.1, "slip": 0.12}
#: For each axis: slip of the peak of a tire whose stiffness is `STIFFNESS` of its load, slip of sliding over it, and
#: sliding force over the peak.
ALONG, ACROSS, STIFFNESS = (0.11, 4.0, 0.82), (0.2, 3.5, 0.9), 20.0
#: Slips at which the trail changes its sign and ends, over the slip of a peak; its largest negative share.
NO_TRAIL, END_OF_TRAIL, NEGATIVE = 1.9, 4.3, 0.06


@dataclass(frozen=True)
class Points:
    """The points of a force curve: slip stiffness, force and slip of the peak, force and slip of sliding."""

    stiffness: FloatArray
    peak: FloatArray
    at_peak: FloatArray
    sliding: FloatArray
    at_sliding: FloatArray

    def force(self, slip: FloatArray) -> FloatArray:
        """Return the force at a slip that is not negative."""
        share = slip / self.at_peak
        before = self.stiffness * slip / (1.0 + share * (share + self.stiffness * self.at_peak / self.peak - 2.0))
        step = np.clip((slip - self.at_peak) / (self.at_sliding - self.at_peak), 0.0, 1.0)
        after = self.peak - (self.peak - self.sliding) * step**2 * (3.0 - 2.0 * step)
        return np.where(slip < self.at_peak, before, after)


def points(
    shape: tuple[float, float, float], stiffness: float, peak: float, load: FloatArray,
    change: tuple[FloatArray | float, FloatArray | float],
) -> Points:  # fmt: skip
    """Return a curve of the nominal load, with changes of friction and stiffness, per nominal load."""
    of_friction, of_stiffness = change
    slope = stiffness * load * (1.0 + OF_LOAD["stiffness"] * (load - 1.0)) * of_stiffness
    top = peak * load * (1.0 + OF_LOAD["peak"] * (load - 1.0)) * of_friction
    slip, further, least = shape
    at_top = slip * (STIFFNESS / stiffness) ** 0.7 * (1.0 + OF_LOAD["slip"] * (load - 1.0)) * of_friction / of_stiffness
    at_top = np.maximum(at_top, 1.35 * top / slope)  # the curve bends one way
    return Points(slope, top, at_top, least * top, further * at_top)


def forces(tire: Specimen, x: Inputs, effects: Sequence[Effect] = ()) -> dict[str, FloatArray]:
    """Return Fx, Fy and Mz of such a tire; parameters as of `formulas.forces`."""
    change, load, of = changed(tire, x, effects), x["Fz"] / tire.load, tire.values
    along = points(ALONG, of["PKX1"], of["PDX1"], load, (change.friction_x, change.stiffness_x))
    across = points(ACROSS, of["PKY1"], of["PDY1"], load, (change.friction_y, change.stiffness_y))
    lateral = np.tan(x["alpha"]) + change.shift
    unit_x, unit_y = (
        one.at_peak / (along.at_peak + across.at_peak)
        + one.peak / one.stiffness / (along.peak / along.stiffness + across.peak / across.stiffness)
        for one in (along, across)
    )
    part_x, part_y = x["kappa"] / unit_x, lateral / unit_y
    slip = np.maximum(np.hypot(part_x, part_y), 1e-9)
    cosine = np.where(slip > 1e-9, part_x / slip, 1.0)
    sine = np.where(slip > 1e-9, part_y / slip, 0.0)
    scales = ((unit_x, unit_y), (1.0, 1.0), (1.0 / unit_x, 1.0 / unit_y), (1.0, 1.0), (1.0 / unit_x, 1.0 / unit_y))
    combined = Points(*(
        np.hypot(one * scale[0] * cosine, other * scale[1] * sine)
        for one, other, scale in zip(astuple(along), astuple(across), scales, strict=True)
    ))  # fmt: skip
    force = combined.force(slip) * tire.load
    vertical = change.camber_thrust + change.side_force + change.kappa_side_force
    trail = of["QDZ1"] * tire.radius * np.sqrt(load) * change.trail * _trail(np.abs(lateral) / across.at_peak)
    return {"Fx": force * cosine, "Fy": force * sine + vertical, "Mz": -trail * force * sine + change.torque}


def _trail(slip: FloatArray) -> FloatArray:
    """Return the trail over a slip relative to the peak's, relative to that at no slip."""
    share = slip / NO_TRAIL
    negative = np.sin(np.pi * np.clip((slip - NO_TRAIL) / (END_OF_TRAIL - NO_TRAIL), 0.0, 1.0)) ** 2
    return np.where(share < 1.0, (1.0 - share) * (1.0 - 0.6 * share**2), -NEGATIVE * negative)
