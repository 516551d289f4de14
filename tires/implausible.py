"""Implausible values and behaviour of a tire, and the probable mistake.

A coefficient is compared with its declared bounds and with the size of the tire, which follows from its declared unit.
Named quantities are compared with those of tires over the tire's own range of loads and slips.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..numerics.ties import graded
from ..symbolic.declarations import Coefficient
from . import Tire
from .definition import RANGES
from .evaluation import forces, quantities
from .property_file.names import not_given

FloatArray = npt.NDArray[np.float64]

#: Largest plausible magnitude of the ends of an input's range, and the probable unit of a larger number. They replace
#: the bounds in the declarations of the coefficients.
FAR_ENDS = {
    "kappa": (10.0, "in percent?"),
    "alpha": (1.6, "in degrees?"),
    "gamma": (1.6, "in degrees?"),
    "p": (5e6, "in another unit?"),
}
#: Other units in which a value may be written, by SI unit: name and factor, the more frequent first.
OTHER_UNITS = {
    "m": (("mm", 1e-3), ("inches", 0.0254), ("cm", 1e-2)),
    "N": (("kN", 1e3), ("lbf", 4.448)),
    "Pa": (("bar", 1e5), ("kPa", 1e3), ("psi", 6894.8), ("MPa", 1e6)),
    "N/m": (("N/mm", 1e3), ("lbf/in", 175.13)),
    "N/rad": (("N/deg", 57.296), ("kN/rad", 1e3)),
    "rad": (("degrees", 0.017453),),
    "1/rad": (("1/deg", 57.296),),
    "m/s": (("mm/s", 1e3), ("km/h", 1.0 / 3.6)),
}
#: Plausible magnitudes by SI unit, relative to the size of the tire: its radius, nominal load, and nominal load per
#: radius. Published tires for 60 N to 10 kN are well inside. Judgement.
PLAUSIBLE = {"m": (0.0, 6.0), "N": (0.5, 500.0), "N/rad": (0.5, 500.0), "N/m": (1.0, 1000.0)}
#: Plausible sizes of a tire, m and N, and pressures, Pa: a kart tire has 0.5 bar, a bicycle tire 10 bar.
SIZES = {"UNLOADED_RADIUS": (0.03, 2.0), "FNOMIN": (5.0, 2e5)}
PRESSURES = (4e4, 1.2e6)
#: Share of the largest plausible value from which a unit is a probable one, if 0 is plausible, too.
LEAST_SHARE = 0.01
#: Plausible speeds, m/s: slower than walking, or faster than benches measure slips, they are in another unit.
SPEEDS = {"LONGVL": (0.5, 45.0)}
#: Plausible lengths within the radius of the tire, as shares of it.
CONTAINED = {"RIM_RADIUS": (0.2, 1.0)}
#: Plausible named quantities at zero slip by role: from, to, relative to powers of the load and the unloaded radius.
QUANTITIES = {
    "friction_x": (0.05, 5.0, 0, 0),
    "friction_y": (0.05, 5.0, 0, 0),
    "trail": (-0.02, 0.6, 0, 1),
    "shift_x": (-0.05, 0.05, 0, 0),
    "shift_y": (-0.1, 0.1, 0, 0),
    "offset_y": (-0.4, 0.4, 1, 0),
    "residual_moment": (-0.2, 0.2, 1, 1),
    "relaxation_x": (0.0, 6.0, 0, 1),
    "relaxation_y": (0.0, 6.0, 0, 1),
    "rolling_radius": (0.8, 1.1, 0, 1),
    "loaded_radius": (0.5, 1.1, 0, 1),
}
#: Slip stiffness per friction force: the reciprocal is the slip at which a linear force reaches the friction.
STEEPNESS = (1.0, 200.0)
#: Largest plausible forces, and moments per free radius, as shares of the load: at zero slip, for each rad of camber in
#: addition, and over both slips. Rolling resistance may be this much negative, by the error of a bench.
FORCES = {
    "Fx": (0.2, 0.0, 5.0), "Fy": (0.4, 1.5, 5.0), "Mz": (0.2, 2.0, 0.8), "Mx": (0.2, 2.0, 1.5), "My": (0.1, 0.0, 1.0),
}  # fmt: skip
LEAST_RESISTANCE = -0.005
#: Share of the load that the side force of a longitudinal slip may have, without slip angle.
SIDE_FORCE_OF_KAPPA = 0.6
#: Largest plausible resultant in combined slip, as a multiple of the ellipse of both peaks; a square has 1.41.
ELLIPSE = 1.25
#: Camber of a tire without a range, rad.
CAMBER = 0.1
#: Steps of a slip over the range of the tire.
STEPS = 61


@dataclass(frozen=True)
class Doubt:
    """An implausible value.

    - `name`: the coefficient, input or quantity.
    - `reason`: the problem, and the probable mistake.
    - `serious`: whether no tire has this value, in contrast to a shape that measured tires may have.

    >>> print(Doubt("INFLPRES", 2.2, "outside 10000 .. 2e+06: in bar?"))
    INFLPRES = 2.2: outside 10000 .. 2e+06: in bar?
    """

    name: str
    value: float
    reason: str
    serious: bool = True

    def __str__(self) -> str:
        return f"{self.name} = {self.value:g}: {self.reason}"


def implausible(tire: Tire) -> list[Doubt]:
    """Return the implausible values of a tire.

    Returns: given coefficients outside their declared bounds (in adapted SAE, unless neutral) or of another size than
    radius and nominal load suggest, implausible ranges, and over the range of loads and slips: friction that is not
    positive or increases with load, slip stiffness of wrong or changing sign, also at the ends of camber and pressure;
    quantities, forces and moments of a size that no tire has; forces far outside the friction ellipse; curvature
    factors and weighting functions above the bounds that a fit enforces.

    >>> from tirefmu.tires import published
    >>> [doubt.name for doubt in implausible(published("trento_hoosier"))]
    ['E_t']
    """
    plain = tire.in_signs("adapted-sae")
    with np.errstate(all="ignore"):  # what is no number is a doubt
        behaviour = [*_behaviour(plain), *_quantities(plain), *_forces(plain), *_constraints(plain)]
    return [*_coefficients(tire), *_ranges(tire), *behaviour]


def loads(tire: Tire) -> FloatArray:
    """Return nine loads, N, shape (9,), over the valid range of a tire, or around its nominal load."""
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.2 * nominal, 2.0 * nominal))
    return np.linspace(max(low, 0.05 * high), high, 9) if high > 0 else np.full(9, nominal)


def _coefficients(tire: Tire) -> Iterator[Doubt]:
    plain = tire.in_signs("adapted-sae").values
    others = {key for keys in RANGES.values() for key in keys} | set(not_given(tire))
    for name, declared in tire.symbolic_model.coefficients.items():
        value = plain[name]
        if name in others or value == declared.neutral:
            continue
        low, high = _plausible(tire, declared)
        within = declared.lower <= value <= declared.upper
        if within and low <= abs(value) <= high:
            continue
        hints = [
            f"in {unit}?"
            for unit, factor in OTHER_UNITS.get(declared.unit, ())
            if (low or LEAST_SHARE * high) <= abs(value) * factor <= high
        ]
        hints = hints[:1] + (["wrong sign?"] if declared.lower <= -value <= declared.upper and not within else [])
        shown = (
            f"{low:.3g} .. {high:.3g}, the {'speeds of benches' if name in SPEEDS else 'sizes of such a tire'}"
            if within
            else f"{declared.lower:g} .. {declared.upper:g}"
        )
        converted = "" if value == tire.values[name] else " with the sign of adapted SAE"
        serious = within or bool(hints) or name in SIZES
        yield Doubt(name, tire.values[name], ": ".join([f"outside {shown}{converted}", *hints]), serious)


def _plausible(tire: Tire, declared: Coefficient) -> tuple[float, float]:
    """Return the magnitudes that a coefficient of a tire of this size may have."""
    radius, load = tire.values["UNLOADED_RADIUS"], tire.values["FNOMIN"]
    sizes = {"m": radius, "N": load, "N/rad": load, "N/m": load / radius if radius else 0.0}
    if declared.name in SIZES:
        return SIZES[declared.name]
    if declared.unit == "Pa":
        return PRESSURES
    if declared.name in SPEEDS:
        return SPEEDS[declared.name]
    least = max(0.0, declared.lower)
    if not sizes.get(declared.unit, 0.0) > 0.0:
        return least, max(abs(declared.lower), abs(declared.upper))
    if declared.name in CONTAINED:
        low, high = CONTAINED[declared.name]
        return low * radius, high * radius
    low, high = PLAUSIBLE[declared.unit]
    return (low * sizes[declared.unit] if declared.lower > 0.0 else 0.0), high * sizes[declared.unit]


def _ranges(tire: Tire) -> Iterator[Doubt]:
    for name, (end, hint) in FAR_ENDS.items():
        for key, value in zip(RANGES[name], tire.ranges.get(name, ()), strict=False):
            if abs(value) > end:
                yield Doubt(key, value, f"the range of {name} exceeds {end:g}: {hint}")
    nominal = tire.values["FNOMIN"]
    low, high = tire.ranges.get("Fz", (0.0, np.inf))
    if not low <= nominal <= high:
        yield Doubt("FNOMIN", nominal, f"outside the range of Fz, {low:g} .. {high:g} N")
    low, high = tire.ranges.get("p", (0.0, np.inf))
    if 0.0 < high < PRESSURES[0]:
        hints = [f": in {unit}?" for unit, factor in OTHER_UNITS["Pa"] if PRESSURES[0] <= high * factor <= PRESSURES[1]]
        yield Doubt(RANGES["p"][1], high, f"the range of p ends below the pressure of any tire{''.join(hints[:1])}")


def _behaviour(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about the signs of friction and slip stiffness over the range of loads, in adapted SAE."""
    load, model = loads(tire), tire.symbolic_model
    names = [model.quantity(f"{role}_{axis}") for axis in "xy" for role in ("friction", "stiffness")]
    named = set[str]()
    for held in ({}, *_ends_of_other_inputs(tire)):
        computed = quantities(tire, {"Fz": load, **held})
        doubts = [doubt for name in names if name and name not in named for doubt in _sign(name, computed[name], load)]
        at = "".join(f", {name} = {value:.4g}" for name, value in held.items())
        yield from (replace(doubt, reason=doubt.reason + at) for doubt in doubts)
        named |= {doubt.name for doubt in doubts}
    computed = quantities(tire, {"Fz": load})
    for axis in ("x", "y"):
        friction = model.quantity(f"friction_{axis}")
        first, last = computed[friction][0], computed[friction][-1]
        if computed[friction].min() > 0 and last > first * (1 + 1e-9):
            yield Doubt(friction, float(last), f"increases with load, from {first:.3g} at {load[0]:g} N", False)


def _ends_of_other_inputs(tire: Tire) -> list[dict[str, float]]:
    """Return the ends of the ranges of camber and pressure, one input at a time."""
    camber = _end(tire, "gamma", CAMBER, most=FAR_ENDS["gamma"][0])
    ends = {"gamma": (-camber, camber), "p": tire.ranges.get("p", ())}
    return [
        {name: value}
        for name, values in ends.items()
        for value in values
        if name in tire.inputs and (name == "gamma" or PRESSURES[0] <= value <= PRESSURES[1])
    ]


def _sign(name: str, values: FloatArray, load: FloatArray) -> Iterator[Doubt]:
    """Yield a doubt if a quantity is not positive everywhere."""
    bad = np.flatnonzero(~(values > 0))
    if bad.size == 0:
        return
    row = bad[0]
    reason = "is not a number" if np.isnan(values[row]) else "is not positive"
    if len(bad) < len(values) and not np.isnan(values[row]):
        reason = "changes sign within the range of loads"
    yield Doubt(name, float(values[row]), f"{reason} (adapted SAE), Fz = {load[row]:.4g} N")


def _quantities(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about the size of named quantities at zero slip, over the range of loads, in adapted SAE."""
    load, radius, model = loads(tire), tire.values["UNLOADED_RADIUS"], tire.symbolic_model
    computed = quantities(tire, {"Fz": load})
    for role, (low, high, of_load, of_radius) in QUANTITIES.items():
        if name := model.quantity(role):
            yield from _outside(name, computed[name], load, (low, high), load**of_load * radius**of_radius)
    for axis in "xy":
        friction, stiffness = model.quantity(f"friction_{axis}"), model.quantity(f"stiffness_{axis}")
        if stiffness and np.all(computed[friction] > 0.0) and np.all(computed[stiffness] > 0.0):
            yield from _outside(stiffness, computed[stiffness], load, STEEPNESS, computed[friction] * load)


def _forces(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about the size of forces and moments over loads, slips and camber, in adapted SAE."""
    load, radius = loads(tire), tire.values["UNLOADED_RADIUS"]
    straight = [{}, *(held for held in _ends_of_other_inputs(tire) if "gamma" in held)]
    doubts: dict[str, Doubt] = {}
    for held in straight:
        computed = forces(tire, {"Fz": load, **held})
        for name in computed:
            size = load * (radius if name.startswith("M") else 1.0)
            most, per_camber, _ = FORCES[name]
            most += per_camber * abs(held.get("gamma", 0.0))
            low = LEAST_RESISTANCE if name == "My" else -most
            at = "".join(f", {other} = {value:.3g}" for other, value in held.items())
            for doubt in _outside(name, computed[name], load, (low, most), size):
                doubts.setdefault(name, replace(doubt, reason=f"{doubt.reason}{at}, without slip"))
    slips, shape = _slips(tire), (-1, 1, 1)
    inputs = {"Fz": load.reshape(shape), "kappa": slips["kappa"][:, None], "alpha": slips["alpha"]}
    computed = forces(tire, inputs)
    for name in computed:
        size = load * (radius if name.startswith("M") else 1.0)
        largest = np.abs(computed[name]).max(axis=(1, 2))
        for doubt in _outside(name, largest, load, (0.0, FORCES[name][2]), size):
            doubts.setdefault(name, replace(doubt, reason=f"{doubt.reason}, over both slips"))
    middle = len(slips["alpha"]) // 2
    of_kappa = np.abs(computed["Fy"][:, :, middle]).max(axis=1)
    for doubt in _outside("Fy", of_kappa, load, (0.0, SIDE_FORCE_OF_KAPPA), load):
        doubts.setdefault("Fy", replace(doubt, reason=f"{doubt.reason}, by kappa alone"))
    yield from doubts.values()
    if not doubts and tire.symbolic_model.quantity("weighting_y"):
        yield from _ellipse(tire, computed["Fx"], computed["Fy"], slips)


def _ellipse(tire: Tire, fx: FloatArray, fy: FloatArray, slips: dict[str, FloatArray]) -> Iterator[Doubt]:
    """Yield a doubt if both forces together are far outside the ellipse of their peaks, at the median of the loads."""
    row, column = (len(slips[name]) // 2 for name in ("kappa", "alpha"))
    peaks = [np.abs(part).max(axis=1)[:, None, None] for part in (fx[:, :, column], fy[:, row, :])]
    share = np.hypot(fx / peaks[0], fy / peaks[1])
    if not np.isfinite(share).all():
        return
    largest = share.max(axis=(1, 2))
    middle = int(np.argsort(graded(largest), kind="stable")[len(largest) // 2])
    if largest[middle] > ELLIPSE:
        i, j = np.unravel_index(graded(share[middle]).argmax(), share[middle].shape)
        at = f"kappa = {slips['kappa'][i]:.3g}, alpha = {slips['alpha'][j]:.3g}"
        reason = f"Fx and Fy together reach this multiple of the friction ellipse at {at}"
        name = f"{tire.symbolic_model.quantity('weighting_x')}, {tire.symbolic_model.quantity('weighting_y')}"
        yield Doubt(name, float(largest[middle]), reason, False)


def _slips(tire: Tire) -> dict[str, FloatArray]:
    """Return steps of both slips over the range of a tire; the middle one is 0."""
    share = np.linspace(-1.0, 1.0, STEPS)
    return {name: share * _end(tire, name, 0.2) for name in ("kappa", "alpha")}


def _outside(
    name: str, values: FloatArray, load: FloatArray, ends: tuple[float, float], size: FloatArray
) -> Iterator[Doubt]:
    """Yield a doubt at the load at which a quantity is furthest outside its plausible range."""
    low, high = ends
    size = np.broadcast_to(size, load.shape)
    excess = np.nan_to_num(np.maximum(low - values / size, values / size - high), nan=-np.inf)
    row = int(np.argmax(graded(excess)))
    if excess[row] > 0.0:
        ends_there = f"{low * size[row]:.3g} .. {high * size[row]:.3g}"
        yield Doubt(name, float(values[row]), f"outside {ends_there}, those of tires, at Fz = {load[row]:.4g} N")


def _constraints(tire: Tire) -> Iterator[Doubt]:
    """Yield doubts about quantities above the bound that a fit enforces, over loads and slips, in adapted SAE."""
    model, swept = tire.symbolic_model, _slips(tire)
    slips = [*((kappa, 0.0) for kappa in swept["kappa"]), *((0.0, alpha) for alpha in swept["alpha"])]
    points = np.array([(load, *slip) for load in loads(tire) for slip in slips]).T
    inputs = dict(zip(("Fz", "kappa", "alpha"), points, strict=True))
    computed = quantities(tire, inputs)
    for bound in (bound for bounds in model.fit.constraints.values() for bound in bounds):
        present = not bound.effect or bound.effect in tire.has
        if bound.measure != "value" or bound.upper == np.inf or bound.kind == "extrapolation" or not present:
            continue
        values = np.nan_to_num(computed[bound.quantity], nan=-np.inf)
        row = int(graded(values).argmax())
        if values[row] > bound.upper:
            at = ", ".join(f"{key} = {given[row]:.3g}" for key, given in inputs.items())
            yield Doubt(bound.quantity, float(values[row]), f"above {bound.upper:g} at {at}", False)


def _end(tire: Tire, name: str, default: float, most: float = 1.0) -> float:
    """Return the largest magnitude in the range of an input if plausible, else `default`."""
    ends = [abs(end) for end in tire.ranges.get(name, ())]
    return max(ends) if ends and 0 < max(ends) <= most else default
