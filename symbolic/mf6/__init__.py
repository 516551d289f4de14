"""MF5.2, MF6.1 and MF6.2: one set of lines, in which the three differ where a line says so (`only`).

What the industry's solvers compute: Pacejka, Tire and Vehicle Dynamics (2012), section 4.E [4.E..]; Besselink,
Schmeitz, Pacejka, An improved Magic Formula/Swift tyre model that can handle inflation pressure changes (2010)
[P ..]; the MF-Tyre manual [M]; and what is known only from the behaviour of MFeval 4.3, which follows TNO's
solver [MFeval].
"""

from __future__ import annotations

from ..model import Model
from ..quantities import ALPHA, FX, FY, FZ, GAMMA, KAPPA, MX, MY, MZ, PHIT, P, V
from . import (
    aligning_moment,
    combined_slip,
    contact_patch,
    deflection,
    inputs,
    longitudinal_force,
    normalized,
    other_moments,
    relaxation,
    rolling_radius,
    side_force,
    transient,
    turn_slip,
)
from .coefficients import SECTIONS

CHAPTERS = tuple(
    chapter.eq
    for chapter in (
        inputs,
        normalized,
        rolling_radius,
        turn_slip,
        longitudinal_force,
        side_force,
        combined_slip,
        aligning_moment,
        other_moments,
        deflection,
        contact_patch,
        relaxation,
        transient,
    )
)


def _model(name: str, title: str) -> Model:
    return Model(
        name=name,
        title=title,
        inputs=(KAPPA, ALPHA, GAMMA, FZ, P, V, PHIT),
        outputs=(FX, FY, MZ, MX, MY),
        sections=SECTIONS,
        chapters=CHAPTERS,
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
    )


MF52 = _model("mf52", "Magic Formula 5.2")
MF61 = _model("mf61", "Magic Formula 6.1")
MF62 = _model("mf62", "Magic Formula 6.2")
