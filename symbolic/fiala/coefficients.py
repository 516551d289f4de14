"""The coefficients of the Fiala tire by the sections of Adams' property file.

They are the same in both sign conventions: a line has the sense of the side force. Adams' samples write the relaxation
lengths as RELAX_LENGTH_X and RELAX_LENGTH_Y.
"""

from __future__ import annotations

from ..declarations import Coefficient, Section


class Dimension(Section, title="DIMENSION", fitted=False):
    """Size of the tire."""

    UNLOADED_RADIUS = Coefficient("free radius R_0", "m", 0.01, 3.0, neutral=None, start=0.3)
    WIDTH = Coefficient(
        "tire width, by which the aligning moment scales", "m", 0.0, 1.5, None, 0.2, channels=("Mz",), fitted=True
    )


class Vertical(Section, title="VERTICAL", fitted=False):
    """The default load; Adams' file has no key for it."""

    FNOMIN = Coefficient("nominal load F_z0", "N", 1.0, 1e6, None, 4000.0, assumed=4000.0)


class Parameter(Section, title="PARAMETER"):
    """The parameters of the tire, as named in the file."""

    VERTICAL_STIFFNESS = Coefficient("vertical stiffness", "N/m", 1e3, 1e8, None, 2e5, fitted=False)
    VERTICAL_DAMPING = Coefficient("vertical damping; no force at given load", "N s/m", 0.0, 1e6, fitted=False)
    CSLIP = Coefficient(
        "longitudinal slip stiffness dFx/dkappa at zero slip", "N", 10.0, 1e7, None, 5e4, channels=("Fx",)
    )
    CALPHA = Coefficient(
        "cornering stiffness |dFy/dalpha| at zero slip", "N/rad", 10.0, 1e7, None, 5e4, channels=("Fy", "Mz")
    )
    CGAMMA = Coefficient("camber stiffness; no force of this model", "N/rad", -1e6, 1e6, fitted=False)
    UMIN = Coefficient("friction at comprehensive slip 1 and above", "1", 0.0, 5.0, neutral=None, start=0.8)
    UMAX = Coefficient("friction at zero slip", "1", 0.1, 5.0, neutral=None, start=1.0)
    ROLLING_RESISTANCE = Coefficient("rolling resistance moment per load", "m", -0.1, 0.1, channels=("My",))
    REL_LEN_LON = Coefficient("relaxation length of kappa", "m", 0.0, 2.0, channels=("Fx",), fitted=False)
    REL_LEN_LAT = Coefficient("relaxation length of tan(alpha)", "m", 0.0, 2.0, channels=("Fy", "Mz"), fitted=False)


SECTIONS = (Dimension, Vertical, Parameter)
