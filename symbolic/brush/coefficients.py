"""The coefficients of the brush model by .tir section.

They are the same numbers in ISO and in adapted SAE: a line reads the option `signs`.
"""

from __future__ import annotations

from ..declarations import Coefficient, Section


class Dimension(Section, title="DIMENSION", fitted=False):
    """Size of the tire."""

    UNLOADED_RADIUS = Coefficient("free radius R_0", "m", 0.01, 3.0, neutral=None, start=0.3)


class Vertical(Section, title="VERTICAL", fitted=False):
    """The load that the coefficients refer to."""

    FNOMIN = Coefficient("nominal load F_z0", "N", 1.0, 1e6, neutral=None, start=1000.0)


class Brush(Section, title="BRUSH"):
    """Stiffness, friction and contact length at nominal load, each with an exponent of the load ratio Fz / F_z0.

    With NSTIFF = 0 the slip stiffnesses are absolute; with NSTIFF = 1, the default, they are proportional to load.
    """

    CKAPPA = Coefficient(
        "longitudinal slip stiffness at nominal load", "N", 10.0, 1e7, None, 2e4, channels=("Fx", "Fy", "Mz")
    )
    CALPHA = Coefficient(
        "cornering stiffness at nominal load", "N/rad", 10.0, 1e7, None, 2e4, channels=("Fy", "Mz", "Fx")
    )
    MUX = Coefficient("friction mu_x at nominal load", "1", 0.05, 5.0, None, 1.2, channels=("Fx", "Fy", "Mz"))
    MUY = Coefficient("friction mu_y at nominal load", "1", 0.05, 5.0, None, 1.2, channels=("Fy", "Mz", "Fx"))
    PATCH = Coefficient(
        "half length of the contact patch at nominal load", "m", 0.002, 1.0, None, 0.06, channels=("Mz",)
    )
    NSTIFF = Coefficient(
        "load exponent of both slip stiffnesses: 0 absolute, 1 proportional to load", "1", 0.0, 2.0, neutral=1.0
    )
    NMU = Coefficient("load exponent of both frictions", "1", -1.0, 1.0)
    NPATCH = Coefficient("load exponent of the contact length", "1", 0.0, 1.5, neutral=0.5, channels=("Mz",))


SECTIONS = (Dimension, Vertical, Brush)
