"""MF5.2, MF6.1 and MF6.2: one set of lines; the three models differ only in marked terms (`only`).

What the industry's solvers compute: Pacejka, Tire and Vehicle Dynamics (2012), section 4.E [4.E..]; Besselink,
Schmeitz, Pacejka, An improved Magic Formula/Swift tyre model that can handle inflation pressure changes (2010)
[P ..]; the MF-Tyre manual [M]; and what is known only from the behaviour of MFeval 4.3, which follows TNO's
solver [MFeval].
"""

from __future__ import annotations

from ..contract import FitDeclaration, Motion, PropertyFile, Role, curvature, positive, with_extrapolation
from ..magic_formula import BASELINE, force_constraints
from ..magic_formula import ROLES as COMMON_ROLES
from ..model import Model, Source
from ..quantities import ALPHA, FX, FY, FZ, GAMMA, KAPPA, MX, MY, MZ, PHIT, P, V
from .coefficients import SECTIONS

CHAPTERS = (
    "inputs",
    "normalized",
    "rolling_radius",
    "turn_slip",
    "longitudinal_force",
    "side_force",
    "combined_slip",
    "aligning_moment",
    "other_moments",
    "deflection",
    "contact_patch",
    "relaxation",
    "transient",
)

ROLES = COMMON_ROLES | {
    "curvature_combined_x": Role("E_xalpha"),
    "curvature_combined_y": Role("E_ykappa"),
    "relaxation_x": Role("sigma_kappa"),
    "relaxation_y": Role("sigma_alpha"),
    "rolling_radius": Role("R_e"),
    "loaded_radius": Role("R_l"),
    "turning_torque": Role("M_zphi_inf"),
    "wheel_speed": Role("omega"),
}
CONSTRAINTS = with_extrapolation(
    force_constraints(pressure=True)
    | {
        "Mz": (
            positive("C_t", 0.1),
            positive("B_t", 0.1, "Fz", "gamma"),
            positive("D_t", 0.0, "Fz", "gamma", "p", size=0.01),
            curvature("E_t", "Fz", "gamma", "alpha"),
        )
    }
)
#: LFZ0 is LFZO with a digit. PAC2002 (Adams/Tire) has other names of the pressure terms; its equations with them are
#: those of MF-Tyre.
ALIASES = {
    "LFZ0": "LFZO",
    "IP": "INFLPRES",
    "IP_NOM": "NOMPRES",
    "QPX1": "PPMX1",
    "QPZ1": "PPZ1",
    "QPZ2": "PPZ2",
    "LKYG": "LKYC",
}


#: Values of FITTYP without one meaning in use.
DISPUTED = {
    5: "MF-Tyre wrote it for MF5.1, MFeval reads it as MF6.1",
    51: "MFeval reads it as MF6.1",
    52: "MFeval reads it as MF6.1",
}


def _file(fittyp: tuple[int, ...], formats: tuple[str, ...], differs_from: str) -> PropertyFile:
    shared = ("USER", "MF-SWIFT", "SWIFT")
    disputed = {number: DISPUTED[number] for number in fittyp if number in DISPUTED}
    return PropertyFile(fittyp, formats, shared, differs_from, aliases=ALIASES, disputed=disputed)


def _model(name: str, title: str, file: PropertyFile, carcass: tuple[str, ...] = ()) -> Model:
    return Model(
        name=name,
        title=title,
        inputs=(KAPPA, ALPHA, GAMMA, FZ, P, V, PHIT),
        outputs=(FX, FY, MZ, MX, MY),
        sections=SECTIONS,
        source=Source(CHAPTERS, folder=__name__),
        results=(
            "R_e",
            "omega",
            "R_l",
            "rho",
            "c_z",
            "a",
            "b",
            "c_x",
            "c_y",
            "sigma_x",
            "sigma_y",
            "sigma_kappa",
            "sigma_alpha",
        ),
        on_demand=(("turn_slip", "phit"),),
        roles=ROLES,
        property_file=file,
        fit=FitDeclaration(CONSTRAINTS, recipe="progressive"),
        baseline=BASELINE,
        motion=Motion(
            relaxation=("SIGX", "SIGY", "SIGC", "SIGK"),
            own_relaxation=("SIGK", *carcass),
            low_speed="VXLOW",
            reverses=True,
            friction_scales=("LMUX", "LMUY"),
        ),
    )


# FITTYP 5 occurs in MF-Tyre 5.0 to 5.2 sets, 6 and 21 in MF-Tyre 5.2 sets. MFeval takes 5, 51, 52 for MF6.1, whose
# lines do without PHY3, the camber shift of such sets.
MF52 = _model("mf52", "Magic Formula 5.2", _file((6, 5, 21, 51, 52), ("PAC2002", "MF_05", "MF-TYRE", "MF52"), "mf61"))
# MF5.2 has coefficients of the relaxation lengths; later models derive the lengths from stiffnesses.
CARCASS = ("LONGITUDINAL_STIFFNESS", "LATERAL_STIFFNESS")
MF61 = _model("mf61", "Magic Formula 6.1", _file((61, 60), ("MF61",), "mf52"), CARCASS)
MF62 = _model("mf62", "Magic Formula 6.2", _file((62,), ("MF62",), "mf61"), CARCASS)
MODELS = (MF52, MF61, MF62)
