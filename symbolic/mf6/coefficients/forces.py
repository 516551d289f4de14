"""Coefficients of Fx and Fy, pure and combined."""

from __future__ import annotations

from ...declarations import Coefficient, Section


class Longitudinal(Section, title="LONGITUDINAL_COEFFICIENTS", channels=("Fx",)):
    """Fx, pure and combined."""

    PCX1 = Coefficient("shape factor C_x", "1", 1.0, 2.5, None, 1.6, assumed=1.65)
    PDX1 = Coefficient("friction mu_x at nominal load", "1", 0.1, 5.0, None, 1.2, assumed=1.3)
    PDX2 = Coefficient("friction mu_x, change with load", "1", -2.0, 1.0, assumed=-0.15)
    PDX3 = Coefficient("friction mu_x, change with inclination squared", "1/rad^2", -100.0, 100.0)
    PEX1 = Coefficient("curvature E_x at nominal load", "1", -20.0, 1.0, None, -0.5, assumed=0.0)
    PEX2 = Coefficient("curvature E_x, change with load", "1", -10.0, 10.0)
    PEX3 = Coefficient("curvature E_x, change with load squared", "1", -10.0, 10.0)
    PEX4 = Coefficient("curvature E_x, drive against brake", "1", -5.0, 5.0)
    PKX1 = Coefficient("slip stiffness K_xkappa per load at nominal load", "1", 1.0, 200.0, None, 25.0, assumed=20.0,
                       channels=("Fx", "Mz"))  # fmt: skip
    PKX2 = Coefficient("slip stiffness K_xkappa, change with load", "1", -100.0, 100.0)
    PKX3 = Coefficient("slip stiffness K_xkappa, exponent of load", "1", -2.0, 2.0)
    PHX1 = Coefficient("horizontal shift S_Hx at nominal load", "1", -0.1, 0.1)
    PHX2 = Coefficient("horizontal shift S_Hx, change with load", "1", -0.1, 0.1)
    PVX1 = Coefficient("vertical shift S_Vx per load at nominal load", "1", -0.5, 0.5)
    PVX2 = Coefficient("vertical shift S_Vx per load, change with load", "1", -0.5, 0.5)
    PPX1 = Coefficient("slip stiffness K_xkappa, change with pressure", "1", -5.0, 5.0)
    PPX2 = Coefficient("slip stiffness K_xkappa, change with pressure squared", "1", -10.0, 10.0)
    PPX3 = Coefficient("friction mu_x, change with pressure", "1", -5.0, 5.0)
    PPX4 = Coefficient("friction mu_x, change with pressure squared", "1", -10.0, 10.0)
    PTX1 = Coefficient("MF5.2: relaxation length sigma_x per R_0 at nominal load", "1", 0.0, 20.0)
    PTX2 = Coefficient("MF5.2: relaxation length sigma_x, change with load", "1", -20.0, 20.0)
    PTX3 = Coefficient("MF5.2: relaxation length sigma_x, exponent of load", "1", -5.0, 5.0)
    RBX1 = Coefficient("combined stiffness B_xalpha", "1/rad", 0.0, 100.0, 0.0, 10.0, assumed=20.0)
    RBX2 = Coefficient("combined stiffness B_xalpha, fall with kappa", "1", -100.0, 100.0, 0.0, 8.0, assumed=15.0)
    RBX3 = Coefficient("combined stiffness B_xalpha, change with inclination squared", "1/rad^3", -1000.0, 1000.0)
    RCX1 = Coefficient("combined shape C_xalpha", "1", 0.1, 1.5, 1.0, assumed=1.0)
    REX1 = Coefficient("combined curvature E_xalpha at nominal load", "1", -20.0, 1.0)
    REX2 = Coefficient("combined curvature E_xalpha, change with load", "1", -10.0, 10.0)
    RHX1 = Coefficient("combined shift S_Hxalpha", "rad", -0.1, 0.1, sided=True)


class Lateral(Section, title="LATERAL_COEFFICIENTS", channels=("Fy", "Mz")):
    """Fy, pure and combined."""

    PCY1 = Coefficient("shape factor C_y", "1", 1.0, 2.5, None, 1.3, assumed=1.3)
    PDY1 = Coefficient("friction mu_y at nominal load", "1", 0.1, 5.0, None, 1.2, assumed=1.1)
    PDY2 = Coefficient("friction mu_y, change with load", "1", -2.0, 1.0, assumed=-0.15)
    PDY3 = Coefficient("friction mu_y, change with inclination squared", "1/rad^2", -100.0, 100.0)
    PEY1 = Coefficient("curvature E_y at nominal load", "1", -20.0, 1.0, None, -0.5, assumed=0.0)
    PEY2 = Coefficient("curvature E_y, change with load", "1", -10.0, 10.0)
    PEY3 = Coefficient("curvature E_y, positive against negative slip", "1", -5.0, 5.0, sided=True)
    PEY4 = Coefficient("curvature E_y, the same with inclination", "1/rad", -100.0, 100.0)
    PEY5 = Coefficient("curvature E_y, change with inclination squared", "1/rad^2", -500.0, 500.0)
    PKY1 = Coefficient(
        "cornering stiffness K_yalpha per nominal load, at its top", "1/rad", 1.0, 500.0, None, 25.0, True, -20.0
    )
    PKY2 = Coefficient("load of the highest K_yalpha, in nominal loads", "1", 0.1, 50.0, 1e6, 2.0, assumed=1.0)
    PKY3 = Coefficient("cornering stiffness, change with inclination", "1/rad", -20.0, 20.0)
    PKY4 = Coefficient("cornering stiffness, shape over load", "1", 0.5, 4.0, 2.0, assumed=2.0)
    PKY5 = Coefficient("load of the highest K_yalpha, change with inclination squared", "1/rad^2", -200.0, 200.0)
    PKY6 = Coefficient("camber stiffness K_ygamma0 per load", "1/rad", -20.0, 20.0, flips=True, assumed=-1.0)
    PKY7 = Coefficient("camber stiffness K_ygamma0 per load, change with load", "1/rad", -20.0, 20.0, flips=True)
    PHY1 = Coefficient("horizontal shift S_Hy at nominal load", "rad", -0.1, 0.1, sided=True)
    PHY2 = Coefficient("horizontal shift S_Hy, change with load", "rad", -0.1, 0.1, sided=True)
    PHY3 = Coefficient("MF5.2: horizontal shift S_Hy, change with inclination", "1", -1.0, 1.0)
    PVY1 = Coefficient("vertical shift S_Vy per load at nominal load", "1", -0.5, 0.5, flips=True, sided=True)
    PVY2 = Coefficient("vertical shift S_Vy per load, change with load", "1", -0.5, 0.5, flips=True, sided=True)
    PVY3 = Coefficient("vertical shift S_Vygamma per load and inclination", "1/rad", -10.0, 10.0, flips=True)
    PVY4 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)
    PPY1 = Coefficient("cornering stiffness K_yalpha, change with pressure", "1", -5.0, 5.0)
    PPY2 = Coefficient("load of the highest K_yalpha, change with pressure", "1", -5.0, 5.0)
    PPY3 = Coefficient("friction mu_y, change with pressure", "1", -5.0, 5.0)
    PPY4 = Coefficient("friction mu_y, change with pressure squared", "1", -10.0, 10.0)
    PPY5 = Coefficient("camber stiffness K_ygamma0, change with pressure", "1", -5.0, 5.0)
    PTY1 = Coefficient("MF5.2: relaxation length sigma_y per R_0 at its top", "1", 0.0, 20.0)
    PTY2 = Coefficient("MF5.2: load of the longest sigma_y, in nominal loads", "1", 0.1, 50.0, None, 2.0, assumed=2.0)
    RBY1 = Coefficient("combined stiffness B_ykappa", "1", 0.0, 100.0, 0.0, 10.0, assumed=10.0)
    RBY2 = Coefficient("combined stiffness B_ykappa, fall with alpha", "1/rad", -100.0, 100.0, 0.0, 8.0, assumed=10.0)
    RBY3 = Coefficient("alpha of the highest B_ykappa", "rad", -0.2, 0.2, sided=True)
    RBY4 = Coefficient("combined stiffness B_ykappa, change with inclination squared", "1/rad^2", -1e4, 1e4)
    RCY1 = Coefficient("combined shape C_ykappa", "1", 0.1, 1.5, 1.0, assumed=1.0)
    REY1 = Coefficient("combined curvature E_ykappa at nominal load", "1", -20.0, 1.0)
    REY2 = Coefficient("combined curvature E_ykappa, change with load", "1", -10.0, 10.0)
    RHY1 = Coefficient("combined shift S_Hykappa at nominal load", "1", -0.1, 0.1)
    RHY2 = Coefficient("combined shift S_Hykappa, change with load", "1", -0.1, 0.1)
    RVY1 = Coefficient("side force made by kappa, per mu_y Fz", "1", -1.0, 1.0, flips=True, sided=True)
    RVY2 = Coefficient("the same, change with load", "1", -1.0, 1.0, flips=True, sided=True)
    RVY3 = Coefficient("the same, change with inclination", "1/rad", -20.0, 20.0, flips=True)
    RVY4 = Coefficient("the same, fall with alpha", "1/rad", -100.0, 100.0, 0.0, 10.0, assumed=20.0)
    RVY5 = Coefficient("the same, shape over kappa", "1", -5.0, 5.0, 0.0, 1.5, assumed=2.0)
    RVY6 = Coefficient("the same, stiffness over kappa", "1", -100.0, 100.0, 0.0, 15.0, assumed=10.0)
