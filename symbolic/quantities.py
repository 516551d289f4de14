"""Inputs and outputs that the models share: names of the public tables, units, meaning."""

from __future__ import annotations

from .notation import Quantity

KAPPA = Quantity("kappa", "1", "longitudinal slip (omega R_e - V_x)/|V_x|; positive drives", typical=0.1)
ALPHA = Quantity("alpha", "rad", "side slip angle", typical=0.1)
GAMMA = Quantity("gamma", "rad", "inclination (camber) angle", typical=0.05)
FZ = Quantity("Fz", "N", "vertical load; positive presses the tire to the ground", "FNOMIN", 1000.0)

FX = Quantity("Fx", "N", "longitudinal force", typical=1000.0)
FY = Quantity("Fy", "N", "side force", typical=1000.0)
MZ = Quantity("Mz", "N m", "aligning moment", typical=30.0)
