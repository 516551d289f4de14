"""The coefficients of MF96 by .tir section.

Bounds and starts are in adapted SAE signs (Fy > 0 for alpha > 0).
Names follow the keys of the Trento parameter set in upper case, which are the .tir names except for a few scaling
factors (LFZ0, LKXK, LKA, LXA, LYK, LVYK, LT, LMR, LGAMMAY).
"""

from __future__ import annotations

from ..declarations import Coefficient, Section


class Dimension(Section, title="DIMENSION", fitted=False):
    """Size of the tire."""

    UNLOADED_RADIUS = Coefficient("free radius R_0", "m", 0.01, 3.0, neutral=None, start=0.3)


class Vertical(Section, title="VERTICAL", fitted=False):
    """The load that the coefficients refer to."""

    FNOMIN = Coefficient("nominal load F_z0", "N", 1.0, 1e6, neutral=None, start=1000.0)


class Scaling(Section, title="SCALING_COEFFICIENTS", fitted=False):
    """The book's lambda: scale a tire to another road surface or to a similar tire."""

    LFZ0 = Coefficient("scale of the nominal load", lower=0.1, upper=10.0, neutral=1.0)
    LCX = Coefficient("scale of the Fx shape factor", lower=0.1, upper=10.0, neutral=1.0)
    LMUX = Coefficient("scale of the Fx peak friction", lower=0.1, upper=10.0, neutral=1.0)
    LEX = Coefficient("scale of the Fx curvature", lower=-10.0, upper=10.0, neutral=1.0)
    LKXK = Coefficient("scale of the longitudinal slip stiffness", lower=0.1, upper=10.0, neutral=1.0)
    LHX = Coefficient("scale of the Fx horizontal shift", lower=-10.0, upper=10.0, neutral=1.0)
    LVX = Coefficient("scale of the Fx vertical shift", lower=-10.0, upper=10.0, neutral=1.0)
    LCY = Coefficient("scale of the Fy shape factor", lower=0.1, upper=10.0, neutral=1.0)
    LMUY = Coefficient("scale of the Fy peak friction", lower=0.1, upper=10.0, neutral=1.0)
    LEY = Coefficient("scale of the Fy curvature", lower=-10.0, upper=10.0, neutral=1.0)
    LKA = Coefficient("scale of the cornering stiffness", lower=0.1, upper=10.0, neutral=1.0)
    LHY = Coefficient("scale of the Fy horizontal shift", lower=-10.0, upper=10.0, neutral=1.0)
    LVY = Coefficient("scale of the Fy vertical shift", lower=-10.0, upper=10.0, neutral=1.0)
    LGAMMAY = Coefficient("scale of the inclination angle", lower=-10.0, upper=10.0, neutral=1.0)
    LKY = Coefficient("scale of the slip stiffness in the aligning moment", lower=0.1, upper=10.0, neutral=1.0)
    LT = Coefficient("scale of the pneumatic trail", lower=-10.0, upper=10.0, neutral=1.0)
    LMR = Coefficient("scale of the residual moment", lower=-10.0, upper=10.0, neutral=1.0)
    LXA = Coefficient("scale of alpha's influence on Fx", lower=0.1, upper=10.0, neutral=1.0)
    LYK = Coefficient("scale of kappa's influence on Fy", lower=0.1, upper=10.0, neutral=1.0)
    LVYK = Coefficient("scale of the side force that kappa makes", lower=-10.0, upper=10.0, neutral=1.0)
    LS = Coefficient("scale of the moment arm of Fx", lower=-10.0, upper=10.0, neutral=1.0)


class Longitudinal(Section, title="LONGITUDINAL_COEFFICIENTS", channels=("Fx",)):
    """Fx, pure and combined."""

    PCX1 = Coefficient("shape factor C_x", lower=1.0, upper=2.5, neutral=None, start=1.6)
    PDX1 = Coefficient("friction mu_x at nominal load", lower=0.1, upper=5.0, neutral=None, start=1.5)
    PDX2 = Coefficient("friction mu_x, change with load", lower=-2.0, upper=1.0)
    PDX3 = Coefficient("friction mu_x, change with inclination squared", "1/rad^2", -100.0, 100.0)
    PEX1 = Coefficient("curvature E_x at nominal load", lower=-20.0, upper=1.0, neutral=None, start=-0.5)
    PEX2 = Coefficient("curvature E_x, change with load", lower=-10.0, upper=10.0)
    PEX3 = Coefficient("curvature E_x, change with load squared", lower=-10.0, upper=10.0)
    PEX4 = Coefficient("curvature E_x, drive against brake", lower=-1.0, upper=1.0)
    PKX1 = Coefficient(
        "slip stiffness K_xkappa per load at nominal load", lower=1.0, upper=200.0, neutral=None, start=30.0,
        channels=("Fx", "Mz"),
    )  # fmt: skip
    PKX2 = Coefficient("slip stiffness K_xkappa, change with load", lower=-100.0, upper=100.0)
    PKX3 = Coefficient("slip stiffness K_xkappa, exponent of load", lower=-2.0, upper=2.0)
    PHX1 = Coefficient("horizontal shift S_Hx at nominal load", lower=-0.1, upper=0.1)
    PHX2 = Coefficient("horizontal shift S_Hx, change with load", lower=-0.1, upper=0.1)
    PVX1 = Coefficient("vertical shift S_Vx per load at nominal load", lower=-0.5, upper=0.5)
    PVX2 = Coefficient("vertical shift S_Vx per load, change with load", lower=-0.5, upper=0.5)
    RBX1 = Coefficient("combined stiffness B_xalpha", lower=0.0, upper=100.0, start=10.0)
    RBX2 = Coefficient("combined stiffness B_xalpha, fall with kappa", lower=-100.0, upper=100.0, start=8.0)
    RCX1 = Coefficient("combined shape C_xalpha", lower=0.1, upper=1.5, neutral=1.0)
    RHX1 = Coefficient("combined shift S_Hxalpha", "rad", -0.1, 0.1, sided=True)


class Lateral(Section, title="LATERAL_COEFFICIENTS", channels=("Fy", "Mz")):
    """Fy, pure and combined."""

    PCY1 = Coefficient("shape factor C_y", lower=1.0, upper=2.5, neutral=None, start=1.3)
    PDY1 = Coefficient("friction mu_y at nominal load", lower=0.1, upper=5.0, neutral=None, start=1.5)
    PDY2 = Coefficient("friction mu_y, change with load", lower=-2.0, upper=1.0)
    PDY3 = Coefficient("friction mu_y, change with inclination squared", "1/rad^2", -100.0, 100.0)
    PEY1 = Coefficient("curvature E_y at nominal load", lower=-20.0, upper=1.0, neutral=None, start=-0.5)
    PEY2 = Coefficient("curvature E_y, change with load", lower=-10.0, upper=10.0)
    PEY3 = Coefficient("curvature E_y, positive against negative slip", lower=-5.0, upper=5.0, sided=True)
    PEY4 = Coefficient("curvature E_y, the same with inclination", "1/rad", -100.0, 100.0)
    PKY1 = Coefficient(
        "cornering stiffness K_yalpha per nominal load, at its top",
        "1/rad",
        1.0,
        500.0,
        None,
        30.0,
        flips=True,
    )
    PKY2 = Coefficient("load of the highest K_yalpha, in nominal loads", lower=0.1, upper=50.0, neutral=1e6, start=2.0)
    PKY3 = Coefficient("cornering stiffness, change with the side of inclination", lower=-0.9, upper=0.9, sided=True)
    PHY1 = Coefficient("horizontal shift S_Hy at nominal load", "rad", -0.1, 0.1, sided=True)
    PHY2 = Coefficient("horizontal shift S_Hy, change with load", "rad", -0.1, 0.1, sided=True)
    PHY3 = Coefficient("horizontal shift S_Hy, change with inclination", lower=-1.0, upper=1.0)
    PVY1 = Coefficient("vertical shift S_Vy per load at nominal load", lower=-0.5, upper=0.5, flips=True, sided=True)
    PVY2 = Coefficient("vertical shift S_Vy per load, change with load", lower=-0.5, upper=0.5, flips=True, sided=True)
    PVY3 = Coefficient("vertical shift S_Vy per load and inclination", "1/rad", -10.0, 10.0, flips=True)
    PVY4 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)
    RBY1 = Coefficient("combined stiffness B_ykappa", lower=0.0, upper=100.0, start=10.0)
    RBY2 = Coefficient("combined stiffness B_ykappa, fall with alpha", lower=-100.0, upper=100.0, start=8.0)
    RBY3 = Coefficient("alpha of the highest B_ykappa", "rad", -0.2, 0.2, sided=True)
    RCY1 = Coefficient("combined shape C_ykappa", lower=0.1, upper=1.5, neutral=1.0)
    RHY1 = Coefficient("combined shift S_Hykappa", lower=-0.1, upper=0.1)
    RVY1 = Coefficient("side force made by kappa, per mu_y Fz", lower=-1.0, upper=1.0, flips=True, sided=True)
    RVY2 = Coefficient("the same, change with load", lower=-1.0, upper=1.0, flips=True, sided=True)
    RVY3 = Coefficient("the same, change with inclination", "1/rad", -20.0, 20.0, flips=True)
    RVY4 = Coefficient("the same, fall with alpha", "1/rad", -100.0, 100.0, start=10.0)
    RVY5 = Coefficient("the same, shape over kappa", lower=0.0, upper=5.0, start=1.5)
    RVY6 = Coefficient("the same, stiffness over kappa", lower=0.0, upper=100.0, start=15.0)


class Aligning(Section, title="ALIGNING_COEFFICIENTS", channels=("Mz",)):
    """Mz: pneumatic trail, residual moment, moment arm of Fx."""

    QBZ1 = Coefficient("trail stiffness B_t at nominal load", lower=0.1, upper=50.0, neutral=None, start=6.0)
    QBZ2 = Coefficient("trail stiffness B_t, change with load", lower=-20.0, upper=20.0)
    QBZ3 = Coefficient("trail stiffness B_t, change with load squared", lower=-20.0, upper=20.0)
    QBZ4 = Coefficient("trail stiffness B_t, change with inclination", "1/rad", -20.0, 20.0, sided=True)
    QBZ5 = Coefficient("trail stiffness B_t, change with the side of inclination", lower=-0.9, upper=0.9, sided=True)
    QBZ9 = Coefficient("residual moment stiffness B_r", lower=-200.0, upper=200.0, neutral=10.0, flips=False)
    QBZ10 = Coefficient("residual moment stiffness B_r per B_y C_y", lower=-10.0, upper=10.0, flips=True)
    QCZ1 = Coefficient("trail shape C_t", lower=0.1, upper=5.0, neutral=None, start=1.1)
    QDZ1 = Coefficient("trail D_t per R_0 at nominal load", lower=-1.0, upper=1.0, neutral=None, start=0.1)
    QDZ2 = Coefficient("trail D_t, change with load", lower=-1.0, upper=1.0)
    QDZ3 = Coefficient("trail D_t, change with inclination", "1/rad", -20.0, 20.0, sided=True)
    QDZ4 = Coefficient("trail D_t, change with inclination squared", "1/rad^2", -100.0, 100.0)
    QDZ6 = Coefficient("residual moment D_r per R_0 Fz at nominal load", lower=-1.0, upper=1.0, flips=True, sided=True)
    QDZ7 = Coefficient("residual moment D_r, change with load", lower=-1.0, upper=1.0, flips=True, sided=True)
    QDZ8 = Coefficient("residual moment D_r per inclination", "1/rad", -10.0, 10.0, flips=True)
    QDZ9 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)
    QEZ1 = Coefficient("trail curvature E_t at nominal load", lower=-20.0, upper=1.0, start=-1.0)
    QEZ2 = Coefficient("trail curvature E_t, change with load", lower=-20.0, upper=20.0)
    QEZ3 = Coefficient("trail curvature E_t, change with load squared", lower=-20.0, upper=20.0)
    QEZ4 = Coefficient("trail curvature E_t, positive against negative slip", lower=-5.0, upper=5.0, sided=True)
    QEZ5 = Coefficient("the same, change with inclination", "1/rad", -100.0, 100.0)
    QHZ1 = Coefficient("trail shift S_Ht at nominal load", "rad", -0.2, 0.2, sided=True)
    QHZ2 = Coefficient("trail shift S_Ht, change with load", "rad", -0.2, 0.2, sided=True)
    QHZ3 = Coefficient("trail shift S_Ht per inclination", lower=-5.0, upper=5.0)
    QHZ4 = Coefficient("the same, change with load", lower=-5.0, upper=5.0)
    SSZ1 = Coefficient("moment arm of Fx per R_0", lower=-1.0, upper=1.0, flips=True, sided=True)
    SSZ2 = Coefficient("moment arm of Fx per R_0 and Fy / F_z0", lower=-1.0, upper=1.0)
    SSZ3 = Coefficient("moment arm of Fx per R_0 and inclination", "1/rad", -10.0, 10.0, flips=True)
    SSZ4 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)


SECTIONS = (Dimension, Vertical, Scaling, Longitudinal, Lateral, Aligning)
