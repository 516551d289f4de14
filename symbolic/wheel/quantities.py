"""Quantities of the hub interface: motion of the wheel carrier, the road, and what follows from them at the wheel.

Global axes are fixed and right-handed with z up. Carrier axes have their origin in the wheel centre: y is the spin axis
and points to the left, x forward. W axes are those of ISO 8855 and TYDEX.
"""

from __future__ import annotations

from ..declarations import Quantity
from ..quantities import FX, FY, FZ, MX, MY, MZ

#: Axes of a vector.
AXES = ("x", "y", "z")

POSITION = tuple(Quantity(f"r_{a}", "m", f"position of the wheel centre, global {a}") for a in AXES)
ROTATION = tuple(
    Quantity(f"R_{i}{j}", "1", f"orientation of the carrier: global {AXES[i - 1]} component of its {AXES[j - 1]} axis")
    for i in (1, 2, 3)
    for j in (1, 2, 3)
)
VELOCITY = tuple(
    Quantity(f"v_{a}", "m/s", f"velocity of the wheel centre, global {a}", typical=15.0 if a == "x" else 1.0)
    for a in AXES
)
TURNING = tuple(Quantity(f"w_{a}", "rad/s", f"angular velocity of the carrier, global {a}") for a in AXES)
SPIN = Quantity("omega", "rad/s", "spin of the wheel relative to the carrier, about its y axis", typical=50.0)
HEIGHT = Quantity("road_z", "m", "height of the road plane at the horizontal position of the wheel centre")
NORMAL = tuple(Quantity(f"road_n{a}", "1", f"normal of the road plane, global {a}; of any length") for a in AXES)
ROAD_VELOCITY = tuple(Quantity(f"road_v{a}", "m/s", f"velocity of the road surface, global {a}") for a in AXES)
FRICTION = Quantity("road_mu", "1", "friction of the road relative to that of the tire's coefficients")

#: The quantities that determine the motion of the wheel, in the order of the generated functions' arguments.
CARRIER = (*POSITION, *ROTATION, *VELOCITY, *TURNING)
ROAD = (HEIGHT, *NORMAL, *ROAD_VELOCITY)

#: The motion of the wheel at its contact point, in W axes.
MOTION = (
    Quantity("V_x", "m/s", "velocity of the contact point relative to the road, W x axis", typical=15.0),
    Quantity("V_y", "m/s", "velocity of the contact point relative to the road, W y axis", typical=1.0),
    Quantity("wheel_speed", "rad/s", "angular speed of the wheel about its axis, relative to the W axes", typical=50.0),
    Quantity("psi_dot", "rad/s", "yaw rate of the wheel about the normal of the road", typical=1.0),
    Quantity("gamma", "rad", "inclination (camber) angle", typical=0.05),
)
LOADED_RADIUS = Quantity("R_l", "m", "distance of the wheel centre from the contact point", typical=0.3)
RADIUS_RATE = Quantity("R_l_rate", "m/s", "rate of the loaded radius", typical=1.0)
CONTACT_POINT = tuple(Quantity(f"c_{a}", "m", f"position of the contact point, global {a}") for a in AXES)

#: Forces and moments at the contact point, in W axes.
CONTACT_FORCES = (FX, FY, FZ, MX, MY, MZ)
#: Forces and moments on the wheel at its centre.
WRENCH = (
    *(Quantity(f"F_{a}", "N", f"force on the wheel, carrier {a} axis", typical=1000.0) for a in AXES),
    *(
        Quantity(f"M_{a}", "N m", f"moment on the wheel about its centre, carrier {a} axis", typical=100.0)
        for a in AXES
    ),
)
GLOBAL_WRENCH = (
    *(Quantity(f"F_{a}_global", "N", f"force on the wheel, global {a}", typical=1000.0) for a in AXES),
    *(
        Quantity(f"M_{a}_global", "N m", f"moment on the wheel about its centre, global {a}", typical=100.0)
        for a in AXES
    ),
)
