"""Coefficients of Mx, My, Mz and of turn slip."""

from __future__ import annotations

from ...declarations import Coefficient, Section


class Overturning(Section, title="OVERTURNING_COEFFICIENTS", channels=("Mx",)):
    """Mx."""

    QSX1 = Coefficient("vertical shift", "1", -1.0, 1.0, sided=True)
    QSX2 = Coefficient("change with inclination", "1/rad", -10.0, 10.0)
    QSX3 = Coefficient("change with Fy", "1", -5.0, 5.0, flips=True)
    QSX4 = Coefficient("hump over load and Fy", "1", -50.0, 50.0, assumed=5.0)
    QSX5 = Coefficient("the same, shape over load", "1", -10.0, 10.0, assumed=1.0)
    QSX6 = Coefficient("the same, stiffness over load", "1", -20.0, 20.0, assumed=10.0)
    QSX7 = Coefficient("the same, change with inclination", "1/rad", -20.0, 20.0)
    QSX8 = Coefficient("the same, shape over Fy", "1", -10.0, 10.0)
    # atan(QSX9 Fy/Fz0) is complete at a side force of a few Fz0/|QSX9|. The contact moves with the carcass, by Fy over
    # its lateral stiffness, and cannot move by half its width under less than about the nominal load: |QSX9| <= 1.
    # Larger values make a step of Mx at Fy = 0.
    QSX9 = Coefficient("the same, stiffness over Fy", "1", -1.0, 1.0, flips=True, assumed=0.4)
    QSX10 = Coefficient("inclination and load, size", "1/rad", -10.0, 10.0)
    QSX11 = Coefficient("inclination and load, stiffness over load", "1", -20.0, 20.0, assumed=5.0)
    QSX12 = Coefficient("inclination squared", "1/rad^2", -20.0, 20.0)
    QSX13 = Coefficient("lateral arm of Fy per R_0", "1", -1.0, 1.0, flips=True)
    QSX14 = Coefficient("the same, change with inclination", "1/rad", -10.0, 10.0, flips=True)
    PPMX1 = Coefficient("change of the camber term with pressure", "1", -5.0, 5.0)


class Rolling(Section, title="ROLLING_COEFFICIENTS", channels=("My",)):
    """My."""

    QSY1 = Coefficient("rolling resistance coefficient", "1", -0.2, 0.2, flips=True, assumed=0.01)
    QSY2 = Coefficient("the same, change with Fx", "1", -2.0, 2.0, flips=True)
    QSY3 = Coefficient("the same, change with speed", "1", -0.1, 0.1, flips=True, assumed=4e-4)
    QSY4 = Coefficient("the same, change with speed to the fourth", "1", -0.1, 0.1, flips=True, assumed=4e-5)
    QSY5 = Coefficient("the same, change with inclination squared", "1/rad^2", -10.0, 10.0, flips=True)
    QSY6 = Coefficient("the same, change with inclination squared and load", "1/rad^2", -10.0, 10.0, flips=True)
    QSY7 = Coefficient("exponent of load", "1", 0.0, 3.0, 1.0, assumed=0.85)
    QSY8 = Coefficient("exponent of pressure", "1", -3.0, 3.0, 0.0, assumed=-0.4)


class Aligning(Section, title="ALIGNING_COEFFICIENTS", channels=("Mz",)):
    """Mz: pneumatic trail, residual moment, moment arm of Fx."""

    QBZ1 = Coefficient("trail stiffness B_t at nominal load", "1/rad", 0.1, 50.0, None, 8.0, assumed=10.0)
    QBZ2 = Coefficient("trail stiffness B_t, change with load", "1/rad", -20.0, 20.0)
    QBZ3 = Coefficient("trail stiffness B_t, change with load squared", "1/rad", -20.0, 20.0)
    QBZ4 = Coefficient(
        "trail stiffness B_t, change with inclination (convention tno)", "1/rad", -20.0, 20.0, sided=True
    )
    QBZ5 = Coefficient("trail stiffness B_t, change with the size of inclination", "1/rad", -20.0, 20.0)
    QBZ6 = Coefficient("trail stiffness B_t, change with inclination squared (convention book)", "1/rad^2", -50.0, 50.0)
    QBZ9 = Coefficient("residual moment stiffness B_r", "1/rad", -200.0, 200.0, 10.0, assumed=10.0)
    QBZ10 = Coefficient("residual moment stiffness B_r per B_y C_y", "1", -50.0, 50.0, flips=True)
    QCZ1 = Coefficient("trail shape C_t", "1", 0.1, 5.0, None, 1.1, assumed=1.1)
    QDZ1 = Coefficient("trail D_t per R_0 at nominal load", "1", -1.0, 1.0, None, 0.1, assumed=0.12)
    QDZ2 = Coefficient("trail D_t, change with load", "1", -1.0, 1.0)
    QDZ3 = Coefficient("trail D_t, change with inclination", "1/rad", -20.0, 20.0, sided=True)
    QDZ4 = Coefficient("trail D_t, change with inclination squared", "1/rad^2", -100.0, 100.0)
    QDZ6 = Coefficient("residual moment D_r per R_0 Fz at nominal load", "1", -1.0, 1.0, flips=True, sided=True)
    QDZ7 = Coefficient("residual moment D_r, change with load", "1", -1.0, 1.0, flips=True, sided=True)
    QDZ8 = Coefficient("residual moment D_r per inclination", "1/rad", -10.0, 10.0, flips=True, assumed=-0.05)
    QDZ9 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)
    QDZ10 = Coefficient("residual moment D_r per inclination squared", "1/rad^2", -50.0, 50.0, flips=True)
    QDZ11 = Coefficient("the same, change with load", "1/rad^2", -50.0, 50.0, flips=True)
    QEZ1 = Coefficient("trail curvature E_t at nominal load", "1", -20.0, 1.0, 0.0, -1.0)
    QEZ2 = Coefficient("trail curvature E_t, change with load", "1", -20.0, 20.0)
    QEZ3 = Coefficient("trail curvature E_t, change with load squared", "1", -20.0, 20.0)
    QEZ4 = Coefficient("trail curvature E_t, positive against negative slip", "1", -5.0, 5.0, sided=True)
    QEZ5 = Coefficient("the same, change with inclination", "1/rad", -100.0, 100.0)
    QHZ1 = Coefficient("trail shift S_Ht at nominal load", "rad", -0.2, 0.2, sided=True)
    QHZ2 = Coefficient("trail shift S_Ht, change with load", "rad", -0.2, 0.2, sided=True)
    QHZ3 = Coefficient("trail shift S_Ht per inclination", "1", -5.0, 5.0)
    QHZ4 = Coefficient("the same, change with load", "1", -5.0, 5.0)
    PPZ1 = Coefficient("trail D_t, fall with pressure", "1", -5.0, 5.0)
    PPZ2 = Coefficient("residual moment per inclination, change with pressure", "1", -5.0, 5.0)
    SSZ1 = Coefficient("moment arm of Fx per R_0", "1", -1.0, 1.0, flips=True, sided=True)
    SSZ2 = Coefficient("moment arm of Fx per R_0 and Fy / F_z0", "1", -1.0, 1.0)
    SSZ3 = Coefficient("moment arm of Fx per R_0 and inclination", "1/rad", -10.0, 10.0, flips=True)
    SSZ4 = Coefficient("the same, change with load", "1/rad", -10.0, 10.0, flips=True)


class TurnSlip(Section, title="TURNSLIP_COEFFICIENTS"):
    """Path curvature and spin."""

    PDXP1 = Coefficient("peak of Fx, fall with spin", "1", -10.0, 10.0, assumed=0.4)
    PDXP2 = Coefficient("the same, change with load", "1", -10.0, 10.0)
    PDXP3 = Coefficient("the same, fall with kappa", "1", -50.0, 50.0)
    PKYP1 = Coefficient("cornering stiffness, fall with spin", "1", -10.0, 10.0, assumed=1.0)
    PDYP1 = Coefficient("peak of Fy, fall with spin", "1", -10.0, 10.0, assumed=0.4)
    PDYP2 = Coefficient("the same, change with load", "1", -10.0, 10.0)
    PDYP3 = Coefficient("the same, fall with alpha", "1/rad", -50.0, 50.0)
    PDYP4 = Coefficient("the same, square root of spin", "1", -10.0, 10.0)
    PHYP1 = Coefficient("shift by spin, shape", "1", 0.1, 3.0, 1.0, assumed=1.0)
    PHYP2 = Coefficient("shift by spin, size", "rad", -1.0, 1.0, assumed=0.15)
    PHYP3 = Coefficient("shift by spin, change of size with load", "rad", -1.0, 1.0)
    PHYP4 = Coefficient("shift by spin, curvature", "1", -20.0, 1.0, assumed=-4.0)
    PECP1 = Coefficient("equivalent spin of camber, eps_gamma", "1", -2.0, 0.99, assumed=0.5)
    PECP2 = Coefficient("the same, change with load", "1", -2.0, 2.0)
    QDTP1 = Coefficient("trail, fall with spin", "1", -50.0, 50.0, assumed=10.0, channels=("Mz",))
    QCRP1 = Coefficient("moment of turning on the spot", "1", 0.0, 5.0, assumed=0.2, channels=("Mz",))
    QCRP2 = Coefficient(
        "the same, stiffness over spin at 90 deg of slip", "1", -50.0, 50.0, assumed=0.1, channels=("Mz",)
    )
    QBRP1 = Coefficient("residual moment stiffness, fall with spin", "1", -50.0, 50.0, assumed=0.1, channels=("Mz",))
    QDRP1 = Coefficient("moment by spin, shape", "1", 0.1, 1.9, 1.0, assumed=1.0, channels=("Mz",))
