"""Inputs and outputs that the models share: names of the public tables, units, meaning."""

from __future__ import annotations

from dataclasses import replace

from .declarations import Quantity

KAPPA = Quantity("kappa", "1", "longitudinal slip (omega R_e - V_x)/|V_x|; positive drives", typical=0.1)
ALPHA = Quantity("alpha", "rad", "side slip angle", typical=0.1)
#: What the lines read in place of alpha.
ALPHA_FOLDED = Quantity("alpha_folded", "rad", "slip angle, beyond 90 deg its supplement")
GAMMA = Quantity("gamma", "rad", "inclination (camber) angle", typical=0.05)
FZ = Quantity("Fz", "N", "vertical load; positive presses the tire to the ground", "FNOMIN", 1000.0, lower=0.0)
P = Quantity("p", "Pa", "inflation pressure", "INFLPRES", 2e5, lower=0.0)
V = Quantity("V", "m/s", "forward speed V_x of the contact point", "LONGVL", 15.0, lower=0.0)
PHIT = Quantity("phit", "1/m", "turn slip: curvature of the path that the contact point turns along", typical=0.1)
#: States of a tire with relaxation.
KAPPA_LAGGED = Quantity("kappa_lagged", "1", "lagged longitudinal slip", typical=0.1)
TAN_ALPHA_LAGGED = Quantity(
    "tan_alpha_lagged", "1", "lagged tangent of the side slip angle, used by the force formulas", typical=0.1
)
#: Below this relaxation length a slip acts without lag, m.
AT_ONCE = 1e-6
#: Inputs that are read only by added effects.
TEMPERATURE = Quantity("T", "degC", "temperature of the tread", "TREF", 50.0)
DISTANCE = Quantity("distance", "m", "distance rolled since the recording began", 0.0, 1000.0, lower=0.0)
#: The speed, for effects with states in a model that does not read it.
OWN_SPEED = replace(V, nominal=V.typical)
AMBIENT = Quantity("T_ambient", "K", "temperature of the air around the tire", 293.15, 300.0)
ROAD = Quantity("T_road", "K", "temperature of the surface of the road", 293.15, 300.0)
BEYOND = {quantity.name: quantity for quantity in (TEMPERATURE, DISTANCE, AMBIENT, ROAD)}
#: Inputs on which added effects may act; the pressure is one of the model's own, or has no influence.
ACTED_ON = {**BEYOND, "p": replace(P, nominal=P.typical)}

FX = Quantity("Fx", "N", "longitudinal force", typical=1000.0)
FY = Quantity("Fy", "N", "side force", typical=1000.0)
MZ = Quantity("Mz", "N m", "aligning moment", typical=30.0)
MX = Quantity("Mx", "N m", "overturning moment", typical=100.0)
MY = Quantity("My", "N m", "rolling resistance moment", typical=10.0)
