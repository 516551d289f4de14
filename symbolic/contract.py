"""Declarations of a model in addition to its lines: roles, property file, physical constraints, fit.

`tirefmu.symbolic.model.Model` holds these declarations; `tirefmu.symbolic.model.verification` checks them. All other
packages read these declarations. They contain no name of a model or of a coefficient.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf

from ..boundary.errors import UnknownName
from .declarations import Quantity

#: The roles that a quantity can have for the other packages, with its symbol. A model declares which of its named
#: quantities has which role. The model lacks a role without a quantity.
ROLES: dict[str, Quantity] = {
    "friction_x": Quantity("mu_x", "1", "largest |Fx| per load"),
    "friction_y": Quantity("mu_y", "1", "largest |Fy| per load"),
    "stiffness_x": Quantity("K_xkappa", "N", "longitudinal slip stiffness dFx/dkappa at zero slip"),
    "stiffness_y": Quantity("K_yalpha", "N/rad", "cornering stiffness dFy/dalpha at zero slip"),
    "shift_x": Quantity("S_Hx", "1", "what is added to kappa: horizontal shift of Fx"),
    "shift_y": Quantity("S_Hy", "rad", "what is added to alpha: horizontal shift of Fy"),
    "offset_y": Quantity("S_Vy", "N", "side force at zero slip: vertical shift of Fy"),
    "trail": Quantity("D_t", "m", "pneumatic trail at zero slip"),
    "trail_fall": Quantity("B_t", "1/rad", "stiffness factor by which the trail falls with alpha"),
    "residual_moment": Quantity("D_r", "N m", "aligning moment that no side force explains"),
    "curvature_x": Quantity("E_x", "1", "curvature factor of Fx, 1 at most"),
    "curvature_y": Quantity("E_y", "1", "curvature factor of Fy, 1 at most"),
    "curvature_trail": Quantity("E_t", "1", "curvature factor of the trail, 1 at most"),
    "curvature_combined_x": Quantity("E_xalpha", "1", "curvature factor of the weighting of Fx, 1 at most"),
    "curvature_combined_y": Quantity("E_ykappa", "1", "curvature factor of the weighting of Fy, 1 at most"),
    "weighting_x": Quantity("G_xa", "1", "share of Fx that remains with side slip"),
    "weighting_y": Quantity("G_yk", "1", "share of Fy that remains with longitudinal slip"),
    "slope_x": Quantity("F_x0_slope", "N", "slope of the pure Fx curve at the given slip"),
    "slope_y": Quantity("F_y0_slope", "N/rad", "slope of the pure Fy curve at the given slip"),
    "relaxation_x": Quantity("sigma_kappa", "m", "relaxation length that acts on kappa"),
    "relaxation_y": Quantity("sigma_alpha", "m", "relaxation length that acts on tan(alpha)"),
    "rolling_radius": Quantity("R_e", "m", "effective rolling radius"),
    "loaded_radius": Quantity("R_l", "m", "distance of the wheel centre from the road"),
    "turning_torque": Quantity("M_zphi_inf", "N m", "friction torque of a wheel that turns on the spot"),
    "wheel_speed": Quantity("omega", "rad/s", "speed at which the wheel turns"),
}


@dataclass(frozen=True)
class Role:
    """The quantity of a model that has one of the `ROLES`.

    Attributes
    ----------
    quantity : str
        A named quantity of the model.
    coefficients : tuple of str
        The coefficients that are read from the data through it before a fit. The first is the leading one: the
        quantity is proportional to it, or a shift or an offset has it as a term.
    per : str
        The factor of the leading coefficient in an offset, by which other terms of the same quantity are scaled:
        Such as "Fz".

    Examples
    --------
    >>> Role("mu_x", ("PDX1", "PDX2")).leading
    'PDX1'
    """

    quantity: str
    coefficients: tuple[str, ...] = ()
    per: str = ""

    @property
    def leading(self) -> str:
        """The first coefficient, or ''."""
        return next(iter(self.coefficients), "")


@dataclass(frozen=True)
class PropertyFile:
    """How a property file (.tir) of a model is recognized and written.

    Attributes
    ----------
    fittyp : tuple of int
        Values of FITTYP, the written one first; none if the format has no such key.
    formats : tuple of str
        Values of PROPERTY_FILE_FORMAT of this model alone; blanks, `-`, `_` and `.` do not count.
    shared_formats : tuple of str
        Values that several models share: the coefficients in the file decide.
    differs_from : str
        The model of the same formats from which this one is distinguished by coefficients that the other one lacks.
    written_format : str
        The written PROPERTY_FILE_FORMAT.
    header : mapping of str to str
        Further lines of [MODEL] that the format requires, as written; a file's own values replace them.
    aliases : mapping of str to str
        Other spellings of coefficients.
    per_angle : bool
        Whether ANGLE of [UNITS] applies to radians within another unit, such as N/rad. The radians of the Magic
        Formula's coefficients are part of the formula and never change.
    in_si : tuple of str
        Keys, coefficients or aliases, whose values are in SI whatever [UNITS] declares.
    disputed : mapping of int to str
        Values of FITTYP that other programs read as another model, and which.
    strict : bool
        Whether a key that resembles a coefficient is an error. Files of other programs contain further keys: there it
        is a remark.
    """

    fittyp: tuple[int, ...] = ()
    formats: tuple[str, ...] = ()
    shared_formats: tuple[str, ...] = ()
    differs_from: str = ""
    written_format: str = "USER"
    header: Mapping[str, str] = field(default_factory=dict)
    aliases: Mapping[str, str] = field(default_factory=dict)
    per_angle: bool = False
    in_si: tuple[str, ...] = ()
    disputed: Mapping[int, str] = field(default_factory=dict)
    strict: bool = False


#: The kinds of constraints, by which a fit selects them, with what of each it enforces on request only. Each has a
#: function below.
CONSTRAINT_KINDS = {
    "signs": "",
    "curvature": "",
    "friction_falling": "",
    "stiffness_saturating": "also K_xkappa",
    "extrapolation": "signs and E up to 1.5 times the range",
}
#: What of a quantity q a constraint can bound, as in `tirefmu.fitting.constraints.constraint_functions`.
MEASURES = {"value": "q", "growth": "Fz dq/dFz", "excess": "Fz dq/dFz - q, by which it grows faster than load"}


@dataclass(frozen=True)
class PhysicalConstraint:
    """A named quantity, or how it changes with load, that stays within bounds.

    - `quantity`: named quantity of the model, such as "E_x".
    - `lower`, `upper`: in the quantity's unit, in adapted SAE signs.
    - `varied`: the inputs that are varied, all on which the quantity depends; the others are nominal.
    - `size`: a typical value, for the solver.
    - `kind`: one of `CONSTRAINT_KINDS`.
    - `measure`: one of `MEASURES`: what is bounded.
    - `effect`: without this effect the quantity has no meaning; empty if it always has a meaning.
    - `on_request`: whether a fit enforces it only on request.
    """

    quantity: str
    lower: float
    upper: float
    varied: tuple[str, ...]
    size: float = 1.0
    kind: str = "signs"
    measure: str = "value"
    effect: str = ""
    on_request: bool = False

    def __post_init__(self) -> None:
        if self.kind not in CONSTRAINT_KINDS:
            raise UnknownName("kind of constraint", self.kind, CONSTRAINT_KINDS)
        if self.measure not in MEASURES:
            raise UnknownName("measure of a constraint", self.measure, MEASURES)


@dataclass(frozen=True)
class FitDeclaration:
    """How a model is fitted.

    - `constraints`: what a fit enforces, by the output that it belongs to.
    - `recipe`: the default fit recipe: one of the package's, or of its own.
    - `recipes`: its own recipes: ``<name>.toml`` in its folder.
    """

    constraints: Mapping[str, tuple[PhysicalConstraint, ...]] = field(default_factory=dict)
    recipe: str = "joint"
    recipes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Baseline:
    """The baseline model, with which a diagnosis begins.

    - `coefficients`: those that a tire without effects is fitted by.
    - `starts`: several starts in adapted SAE, against local optima; others start at generic values.
    - `spread`: standard deviation among tires of coefficients that a recording may leave undetermined.
    - `refinements`: refinements that a diagnosis tries: coefficients and sizes to probe with, in adapted SAE.
    """

    coefficients: tuple[str, ...] = ()
    starts: tuple[Mapping[str, float], ...] = ({},)
    spread: Mapping[str, float] = field(default_factory=dict)
    refinements: tuple[Mapping[str, float], ...] = ()


@dataclass(frozen=True)
class Motion:
    """What a simulation of a moving wheel needs of a model.

    - `relaxation`: the coefficients of its relaxation lengths, which act through time only.
    - `own_relaxation`: the coefficient that scales relaxation lengths which follow from other coefficients, then those
      that must be known for it. An FMU with wheel inputs uses these lengths if the tire has no relaxation.
    - `low_speed`: the coefficient below whose speed, m/s, slips are those of a standing wheel, if it has one.
    - `reverses`: whether its forces at a given kappa change their direction with the sign of V: kappa is then positive
      where it drives the wheel in its direction of travel. The equations of other models are those of a wheel that
      rolls forward: an FMU that computes slips mirrors their forces where the wheel rolls backward.
    - `friction_scales`: the coefficients to which friction is proportional: a road with another friction multiplies
      each of them.
    """

    relaxation: tuple[str, ...] = ()
    own_relaxation: tuple[str, ...] = ()
    low_speed: str = ""
    reverses: bool = False
    friction_scales: tuple[str, ...] = ()


def positive(quantity: str, floor: float, *varied: str, size: float = 1.0, effect: str = "") -> PhysicalConstraint:
    """Return the constraint that a quantity stays above a floor, which is small compared with plausible values.

    Examples
    --------
    >>> positive("mu", 0.01, "Fz").lower
    0.01
    """
    return PhysicalConstraint(quantity, floor, inf, varied, size, effect=effect)


def curvature(quantity: str, *varied: str, effect: str = "") -> PhysicalConstraint:
    """Return the constraint that a curvature factor is at most 1."""
    return PhysicalConstraint(quantity, -inf, 1.0, varied, kind="curvature", effect=effect)


def weighting(quantity: str, *varied: str, effect: str = "") -> PhysicalConstraint:
    """Return the constraint that a weighting function is a share: positive, and at most 1 but for a shift of the slip.

    It is 1 at zero slip. With a shift its highest value is elsewhere: 1.01 at most in published tires.
    """
    return PhysicalConstraint(quantity, 0.01, 1.05, varied, effect=effect)


def friction_falling(quantity: str, *varied: str) -> PhysicalConstraint:
    """Return the constraint that friction does not grow with load."""
    return PhysicalConstraint(quantity, -inf, 0.0, varied, 1.0, "friction_falling", "growth", "load_friction")


def stiffness_saturating(quantity: str, *varied: str, on_request: bool = False) -> PhysicalConstraint:
    """Return the constraint that a slip stiffness grows no faster than load."""
    kind = "stiffness_saturating"
    return PhysicalConstraint(quantity, -inf, 0.0, varied, 1e4, kind, "excess", "load_stiffness", on_request)


def with_extrapolation(
    constraints: Mapping[str, tuple[PhysicalConstraint, ...]],
) -> dict[str, tuple[PhysicalConstraint, ...]]:
    """Return constraints and copies of those over load and slip, which apply outside the measured range on request.

    Examples
    --------
    >>> [each.kind for each in with_extrapolation({"Fx": (positive("mu", 0.01, "Fz"),)})["Fx"]]
    ['signs', 'extrapolation']
    """
    far = {
        output: tuple(
            replace(constraint, kind="extrapolation", on_request=True)
            for constraint in near
            if constraint.measure == "value" and {"Fz", "kappa", "alpha"} & set(constraint.varied)
        )
        for output, near in constraints.items()
    }
    return {output: near + far[output] for output, near in constraints.items()}
