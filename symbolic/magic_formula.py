"""What the Magic Formula models share in addition to their lines: roles, and the physical constraints on Fx and Fy."""

from __future__ import annotations

from .contract import (
    Baseline,
    PhysicalConstraint,
    Role,
    curvature,
    friction_falling,
    positive,
    stiffness_saturating,
    weighting,
)

ROLES = {
    "friction_x": Role("mu_x", ("PDX1", "PDX2")),
    "friction_y": Role("mu_y", ("PDY1", "PDY2")),
    "stiffness_x": Role("K_xkappa", ("PKX1", "PKX3")),
    "stiffness_y": Role("K_yalpha", ("PKY1", "PKY2")),
    "shift_x": Role("S_Hx", ("PHX1",)),
    "shift_y": Role("S_Hy", ("PHY1",)),
    "offset_y": Role("S_Vy", ("PVY1",), per="Fz"),
    "trail": Role("D_t", ("QDZ1", "QDZ2")),
    "trail_fall": Role("B_t", ("QBZ1",)),
    "residual_moment": Role("D_r", ("QDZ6",), per="Fz*UNLOADED_RADIUS"),
    "curvature_x": Role("E_x"),
    "curvature_y": Role("E_y"),
    "curvature_trail": Role("E_t"),
    "weighting_x": Role("G_xa"),
    "weighting_y": Role("G_yk"),
}
#: A tire without effects is fitted by peaks, shapes, stiffnesses and trail. Several starts of shape and curvature: a
#: local optimum looks like a missing effect. The spread of shapes is about twice that of published tires: coefficients
#: that a recording does not determine stay plausible.
BASELINE = Baseline(
    ("PCX1", "PDX1", "PEX1", "PKX1", "PCY1", "PDY1", "PEY1", "PKY1", "QBZ1", "QCZ1", "QDZ1"),
    starts=(
        {"PCX1": 1.6, "PEX1": 0.2, "PCY1": 1.4, "PEY1": -0.3, "QBZ1": 9.0, "QCZ1": 1.1},
        {"PCX1": 1.4, "PEX1": -1.0, "PCY1": 1.6, "PEY1": 0.3, "QBZ1": 6.0, "QCZ1": 1.3},
        {"PCX1": 1.8, "PEX1": 0.5, "PCY1": 1.25, "PEY1": -1.2, "QBZ1": 13.0, "QCZ1": 1.0},
    ),
    spread={"PCX1": 0.2, "PEX1": 1.0, "PCY1": 0.2, "PEY1": 1.0, "QBZ1": 4.0, "QCZ1": 0.2},
    refinements=({"PEX3": 0.3}, {"QEZ1": -1.0}, {"PKX3": 0.1, "PKX2": 1.0}),
)


def force_constraints(*, pressure: bool) -> dict[str, tuple[PhysicalConstraint, ...]]:
    """Return the physical constraints on Fx and Fy: the Trento report's table 1.2.5, and how they change with load.

    Floors: 0.01 of friction, 0.1 of C and of B in 1/rad, 1 of slip stiffness in N and N/rad. The
    longitudinal stiffness of published passenger car tires grows faster than load: bounded on request only.

    Parameters
    ----------
    pressure : bool
        For MF5.2 to 6.2, which read p: their weighting functions have a curvature and change with inclination and
        load, and their slip stiffnesses have a sign of their own.
    """
    constraints: dict[str, tuple[PhysicalConstraint, ...]] = {}
    p = ("p",) if pressure else ()
    for force, slip, axis, across, other, camber in (
        ("Fx", "kappa", "x", "alpha", "kappa", ()),
        ("Fy", "alpha", "y", "kappa", "alpha", ("gamma",)),
    ):
        state = "Fz", "gamma", *p
        weight = {"x": "xa", "y": "yk"}[axis]
        effect = f"combined_G{weight}"
        constraints[force] = (
            positive(f"C_{axis}", 0.1),
            positive(f"mu_{axis}", 0.01, *state),
            positive(f"B_{axis}", 0.1, *state),
            curvature(f"E_{axis}", "Fz", *camber, slip),
            positive(f"B_{axis}{across}", 0.0, other, *(("gamma",) if pressure else ()), effect=effect),
            weighting(f"G_{weight}", "kappa", "alpha", *(("gamma", "Fz") if pressure else ()), effect=effect),
            friction_falling(f"mu_{axis}", *state),
            stiffness_saturating(f"K_{axis}{slip}", "Fz", *camber, *p, on_request=axis == "x"),
        )
        if pressure:
            constraints[force] += (
                positive(f"C_{axis}{across}", 0.1, effect=effect),
                curvature(f"E_{axis}{across}", "Fz", effect=effect),
                positive(f"K_{axis}{slip}", 1.0, "Fz", *camber, *p, size=1e4),
            )
    return constraints
