"""The tire as a body: size, nominal conditions, radii, stiffness, contact patch, and the ranges of its inputs."""

from __future__ import annotations

from ...declarations import Coefficient, Section


class Model(Section, title="MODEL", fitted=False):
    """Speeds that the lines refer to."""

    LONGVL = Coefficient("nominal speed V_0", "m/s", 0.1, 200.0, None, 16.7, assumed=16.7)
    VXLOW = Coefficient("speed below which slips are scaled down", "m/s", 1e-3, 20.0, None, 1.0, assumed=1.0)


class Dimension(Section, title="DIMENSION", fitted=False):
    """Size of the tire."""

    UNLOADED_RADIUS = Coefficient("free radius R_0", "m", 0.01, 3.0, None, 0.3135)
    WIDTH = Coefficient("section width", "m", 0.01, 1.5, None, 0.205, assumed=0.205)
    ASPECT_RATIO = Coefficient("section height per width", "1", 0.05, 1.5, None, 0.6, assumed=0.6)
    RIM_RADIUS = Coefficient("rim radius", "m", 0.005, 2.5, None, 0.1905, assumed=0.1905)


class Operating(Section, title="OPERATING_CONDITIONS", fitted=False):
    """Inflation pressure."""

    INFLPRES = Coefficient("inflation pressure where the input p is absent", "Pa", 1e4, 2e6, None, 2.2e5, assumed=2.2e5)
    NOMPRES = Coefficient("nominal inflation pressure p_0", "Pa", 1e4, 2e6, None, 2.2e5, assumed=2.2e5)


class Vertical(Section, title="VERTICAL", fitted=False):
    """Load, effective and loaded radius, deflection."""

    FNOMIN = Coefficient("nominal load F_z0", "N", 1.0, 1e6, None, 4000.0)
    VERTICAL_STIFFNESS = Coefficient("vertical stiffness c_z0", "N/m", 1e3, 1e8, None, 2e5, assumed=2e5)
    BREFF = Coefficient("effective radius, stiffness at low load", "1", 0.0, 100.0, 0.0, 8.4, assumed=8.4)
    DREFF = Coefficient("effective radius, peak", "1", -5.0, 5.0, 0.0, 0.27, assumed=0.27)
    FREFF = Coefficient("effective radius, stiffness at high load", "1", -5.0, 5.0, 0.0, 0.07, assumed=0.07)
    Q_RE0 = Coefficient("free radius in motion per R_0", "1", 0.8, 1.2, 1.0, 1.0, assumed=1.0)
    Q_V1 = Coefficient("growth of the free radius with speed", "1", -0.1, 0.1)
    Q_V2 = Coefficient("growth of the vertical stiffness with speed", "1", -1.0, 1.0)
    Q_FZ2 = Coefficient("vertical stiffness, growth with deflection", "1", -500.0, 500.0, 0.0, assumed=1e-4)
    Q_FCX = Coefficient("vertical stiffness, fall with Fx", "1", -5.0, 5.0)
    Q_FCY = Coefficient("vertical stiffness, fall with Fy", "1", -5.0, 5.0)
    Q_FCY2 = Coefficient("fall with Fy, exponent of deflection", "1", -5.0, 5.0)
    Q_CAM1 = Coefficient("camber deflection, linear in loaded radius", "1/m", -1e4, 1e4)
    Q_CAM2 = Coefficient("camber deflection, quadratic in loaded radius", "1/m^2", -1e5, 1e5)
    Q_CAM3 = Coefficient("camber deflection, reduction with deflection", "1/rad", -100.0, 100.0)
    Q_FYS1 = Coefficient("side force of inclination in the deflection", "N/rad", -1e6, 1e6, flips=True)
    Q_FYS2 = Coefficient("the same, linear in loaded radius", "N/rad", -1e6, 1e6, flips=True)
    Q_FYS3 = Coefficient("the same, quadratic in loaded radius", "N/rad", -1e6, 1e6, flips=True)
    PFZ1 = Coefficient("vertical stiffness, change with pressure", "1", -5.0, 5.0)
    BOTTOM_OFFST = Coefficient("distance to the rim at which the tire bottoms", "m", 0.0, 0.5, 0.0, 0.01, assumed=0.01)


class Structural(Section, title="STRUCTURAL", fitted=False):
    """Stiffness of the standing tire against the rim."""

    LONGITUDINAL_STIFFNESS = Coefficient("longitudinal stiffness c_x0", "N/m", 1e3, 1e8, None, 3e5, assumed=3e5)
    LATERAL_STIFFNESS = Coefficient("lateral stiffness c_y0", "N/m", 1e3, 1e8, None, 1e5, assumed=1e5)
    PCFX1 = Coefficient("longitudinal stiffness, change with load", "1", -5.0, 5.0)
    PCFX2 = Coefficient("longitudinal stiffness, change with load squared", "1", -5.0, 5.0)
    PCFX3 = Coefficient("longitudinal stiffness, change with pressure", "1", -5.0, 5.0)
    PCFY1 = Coefficient("lateral stiffness, change with load", "1", -5.0, 5.0)
    PCFY2 = Coefficient("lateral stiffness, change with load squared", "1", -5.0, 5.0)
    PCFY3 = Coefficient("lateral stiffness, change with pressure", "1", -5.0, 5.0)


class Patch(Section, title="CONTACT_PATCH", fitted=False):
    """Length and width of the contact patch."""

    Q_RA1 = Coefficient("half length, square root of deflection", "1", -10.0, 10.0, 0.0, 0.5, assumed=0.5)
    Q_RA2 = Coefficient("half length, linear in deflection", "1", -10.0, 10.0, 0.0, 1.0, assumed=1.0)
    Q_RB1 = Coefficient("half width, cube root of deflection", "1", -10.0, 10.0, 0.0, 1.0, assumed=1.0)
    Q_RB2 = Coefficient("half width, linear in deflection", "1", -10.0, 10.0, 0.0, -1.0, assumed=-1.0)
    Q_A1 = Coefficient("MF5.2: half length, square root of load (0 with Q_A2: from the stiffness)", "1", -10.0, 10.0)
    Q_A2 = Coefficient("MF5.2: half length, linear in load", "1", -10.0, 10.0)


class PressureRange(Section, title="INFLATION_PRESSURE_RANGE", fitted=False):
    """Pressures for which the tire is known."""

    PRESMIN = Coefficient("lowest pressure", "Pa", 0.0, 2e6, None, 1e4, assumed=1e4)
    PRESMAX = Coefficient("highest pressure", "Pa", 0.0, 5e6, None, 1e6, assumed=1e6)


class LoadRange(Section, title="VERTICAL_FORCE_RANGE", fitted=False):
    """Loads for which the tire is known; below FZMIN M_x and M_y fade out."""

    FZMIN = Coefficient("lowest load", "N", 0.0, 1e6, None, 100.0, assumed=100.0)
    FZMAX = Coefficient("highest load", "N", 0.0, 1e7, None, 1e4, assumed=1e4)


class LongSlipRange(Section, title="LONG_SLIP_RANGE", fitted=False):
    """Longitudinal slips for which the tire is known."""

    KPUMIN = Coefficient("lowest longitudinal slip", "1", -10.0, 0.0, None, -1.5, assumed=-1.5)
    KPUMAX = Coefficient("highest longitudinal slip", "1", 0.0, 100.0, None, 1.5, assumed=1.5)


class SlipAngleRange(Section, title="SLIP_ANGLE_RANGE", fitted=False):
    """Slip angles for which the tire is known."""

    ALPMIN = Coefficient("lowest slip angle", "rad", -1.6, 0.0, None, -1.5, assumed=-1.5)
    ALPMAX = Coefficient("highest slip angle", "rad", 0.0, 1.6, None, 1.5, assumed=1.5)


class InclinationRange(Section, title="INCLINATION_ANGLE_RANGE", fitted=False):
    """Inclinations for which the tire is known."""

    CAMMIN = Coefficient("lowest inclination", "rad", -1.6, 0.0, None, -0.175, assumed=-0.175)
    CAMMAX = Coefficient("highest inclination", "rad", 0.0, 1.6, None, 0.175, assumed=0.175)


class Transient(Section, title="TIREFMU_TRANSIENT", fitted=False):
    """Relaxation lengths beyond the Magic Formula's own; no field of other readers."""

    SIGX = Coefficient("relaxation length of kappa", "m", 0.0, 10.0, 0.0, 0.3, channels=("Fx",))
    SIGY = Coefficient("relaxation length of tan(alpha)", "m", 0.0, 10.0, 0.0, 0.5, channels=("Fy", "Mz"))
    SIGC = Coefficient("relaxation length of tan(alpha), change with load", "1", -2.0, 5.0, channels=("Fy", "Mz"))
    SIGK = Coefficient("share of the Magic Formula's own relaxation lengths", "1", 0.0, 2.0, 0.0, 1.0)
