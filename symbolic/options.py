"""The conventions that can be chosen when a tire is evaluated, by their public names.

The chapters have the terms in which an option acts (``option.either(default, other)``).
"""

from __future__ import annotations

from .declarations import Option

convention = Option(
    "convention",
    ("tno", "book"),
    "tno: as the industry's solvers compute (TNO MF-Tyre, MFeval); book: as Pacejka (2012), section 4.E, prints",
)
slip_angle = Option(
    "slip_angle",
    ("tan", "angle"),
    "tan: alpha* = tan(alpha) sgn(V) and gamma* = sin(gamma), eqs. (4.E3), (4.E4); angle: alpha and gamma themselves",
)
limits = Option(
    "limits",
    ("off", "on"),
    "on: inputs are limited to the tire's ranges, slips fade out below VXLOW, curvature factors are 1 at most",
)
signs = Option(
    "signs",
    ("iso", "adapted-sae"),
    "how the coefficients are written; read by lines whose sign depends on the convention while no coefficient does",
)

#: Every option by its public name, in the order of the parameter vector.
OPTIONS: dict[str, Option] = {option.name: option for option in (convention, slip_angle, limits, signs)}
