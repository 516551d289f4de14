"""An effect of the library that the tires of a drive lack: its side forces over the estimated motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...diagnosis.diagnose import with_library
from ...diagnosis.probing.candidates import candidates_for, counts_from_neutral
from ...symbolic.detection import Form
from ...tires import Tire
from ...tires.evaluation import forces_over_time
from ...tires.states.transient import rolled_distance
from .dynamics.lagging import wheel_motion
from .estimate import Estimate
from .inputs.car import Car, loads_of
from .inputs.grid import Grid
from .inputs.unknowns import AXLES, FACTORS, Unknowns
from .interval import OUTPUTS
from .linear_solution import LARGEST

FloatArray = npt.NDArray[np.float64]

#: What a drive has of the inputs of an effect.
INPUTS = frozenset({"kappa", "alpha", "Fz", "V", "t", "Fy", "distance"})
#: Prior standard deviation of the logarithm of a coefficient without a declared spread.
SCALE_SPREAD = 0.7
#: Share by which the iterations of a state change its largest value last.
TOLERANCE = 1e-5
#: Smallest change of a force, per static load, that is a change: that of rounding is none.
MIN_CHANGE = 1e-5


@dataclass(frozen=True)
class Motion:
    """What the forces of the tires follow from.

    - `t`, shape (n,), s.
    - `inputs`: kappa, alpha, gamma, Fz and V, shape (4, n) each: of the corners, ISO-W signs. `loads`: of the axles, N.
    """

    t: FloatArray
    inputs: Mapping[str, FloatArray]
    loads: tuple[float, float]

    @cached_property
    def wheels(self) -> list[dict[str, FloatArray]]:
        """The inputs of each axle: rows of its left wheel, then of its right wheel."""
        inputs = {**self.inputs, "distance": np.stack([rolled_distance(self.t, V) for V in self.inputs["V"]])}
        return [{name: values[2 * i : 2 * i + 2].ravel() for name, values in inputs.items()} for i in range(len(AXLES))]

    @property
    def times(self) -> FloatArray:
        """The times of these rows."""
        return np.tile(self.t, 2)

    def moved(self, name: str, by: FloatArray) -> Motion:
        """Return the motion with an input that is larger at the corners, shape (4,)."""
        return replace(self, inputs={**self.inputs, name: self.inputs[name] + by[:, None]})

    def side_forces(self, tires: Mapping[str, Tire]) -> FloatArray:
        """Return the side force of each axle per static load, shape (n, 2)."""
        forces = []
        for axle, wheels in zip(AXLES, self.wheels, strict=True):
            tire = tires[axle].in_signs("iso")
            Fy = forces_over_time(tire, self.times, wheels, TOLERANCE)[tire.outputs.index("Fy")]
            forces.append(Fy.reshape(2, -1).sum(axis=0))
        return np.stack(forces, axis=1) / self.loads


def motion_of(grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car) -> Motion:
    """Return the motion of the wheels in the middle of the intervals."""
    p = unknowns.car_values(car, estimate.z)
    inputs = dict(zip(("alpha", "V", "Fz", "gamma"), wheel_motion(grid, estimate.states, car, p), strict=True))
    inputs["alpha"] = np.arcsin(np.sin(inputs["alpha"]))  # the slip of a wheel that rolls backward is V_y/|V_x|
    kappa = np.stack([estimate.outputs[:, OUTPUTS.index(f"kappa_{axle}")] for axle in AXLES])
    return Motion(grid.t, {"kappa": kappa.repeat(2, axis=0), **inputs}, loads_of(p))


@dataclass(frozen=True)
class Missing:
    """An effect that both tires lack, with coefficients from standardized deviations u.

    - `tires`: with the library, switched off. `name`: of the effect.
    - `center`, `spread`: of each coefficient; `logarithmic`: those whose logarithm has the spread.
    """

    name: str
    tires: Mapping[str, Tire]
    center: Mapping[str, float]
    spread: Mapping[str, float]
    logarithmic: frozenset[str]

    def values(self, u: FloatArray) -> dict[str, float]:
        """Return the coefficients, within their bounds, from the first deviations."""
        declared, values = self.tires["front"].symbolic_model.coefficients, dict[str, float]()
        for (name, center), deviation in zip(self.center.items(), u, strict=False):
            step = self.spread[name] * deviation
            value = center * np.exp(step) if name in self.logarithmic else center + step
            values[name] = float(np.clip(value, declared[name].lower, declared[name].upper))
        return values

    def limits(self, n: int) -> FloatArray:
        """Return the deviations at the bounds of the first n coefficients, shape (2, n)."""
        declared = self.tires["front"].symbolic_model.coefficients
        result = np.empty((2, n))
        for i, (name, center) in zip(range(n), self.center.items(), strict=False):
            bounds = np.array([declared[name].lower, declared[name].upper])
            with np.errstate(divide="ignore"):
                away = np.log(np.maximum(bounds / center, 0.0)) if name in self.logarithmic else bounds - center
            result[:, i] = np.clip(away / self.spread[name], -LARGEST, LARGEST)
        return result

    def on(self, u: FloatArray, factors: Mapping[str, Mapping[str, float]]) -> dict[str, Tire]:
        """Return the tires with the effect and with scaling factors by axle and name."""
        return {axle: scaled(tire, factors[axle], **self.values(u)) for axle, tire in self._active.items()}

    @cached_property
    def _active(self) -> dict[str, Tire]:
        """The tires with the effect, whose coefficients are those of the tires without."""
        return {axle: replace(tire, effects=tire.has | {self.name}) for axle, tire in self.tires.items()}

    def off(self, factors: Mapping[str, Mapping[str, float]]) -> dict[str, Tire]:
        """Return the tires without the effect, with scaling factors by axle and name."""
        return {axle: scaled(tire, factors[axle]) for axle, tire in self.tires.items()}

    def delivered(self, u: FloatArray) -> dict[str, Tire]:
        """Return the tires with the effect and nothing else of the library, ISO-W signs."""
        result = {}
        for axle, tire in self.on(u, {axle: {} for axle in AXLES}).items():
            unused = [effect for effect in tire.added if effect.name not in tire.has]
            names = {declaration.name for effect in unused for declaration in effect.declarations}
            names -= {
                declaration.name for effect in tire.added if effect not in unused for declaration in effect.declarations
            }
            values = {name: value for name, value in tire.values.items() if name not in names}
            added = tuple(effect for effect in tire.added if effect not in unused)
            result[axle] = replace(tire, added=added, values=values).in_signs("iso")
        return result


def scaled(tire: Tire, factors: Mapping[str, float], **values: float) -> Tire:
    """Return a tire with its scaling coefficients multiplied by factors, and with values of other coefficients."""
    return tire.with_values(**values, **{name: tire.values[name] * value for name, value in factors.items()})


def factor_values(unknowns: Unknowns, z: FloatArray) -> dict[str, dict[str, float]]:
    """Return the factors by axle and name."""
    places = {axle: {name: unknowns.factor(axle, name) for name in FACTORS} for axle in AXLES}
    return {
        axle: {name: float(np.exp(unknowns.spread[i] * z[i])) for name, i in row.items()}
        for axle, row in places.items()
    }


def effect_columns(
    motion: Motion, tires: Mapping[str, Tire], factors: Mapping[str, Mapping[str, float]]
) -> list[tuple[Missing, FloatArray, FloatArray]]:
    """Return the effects that a drive can show, each with a typical size and its side force there, shape (n, 2).

    An effect occurs once for each form and probe.
    """
    library = {axle: with_library(tire) for axle, tire in tires.items()}
    without = motion.side_forces({axle: scaled(tire, factors[axle]) for axle, tire in library.items()})
    columns = []
    idle = frozenset.intersection(*(_idle(tire) for tire in library.values()))
    candidates = candidates_for(replace(library["front"], effects=library["front"].has - idle))
    for name, candidate in candidates.items():
        # Where the simpler effect is a candidate, the more general one is a refinement of it.
        simpler, slow = candidate.contains in candidates, candidate.rate > 1.0 / np.median(np.diff(motion.t))
        if simpler or slow or "Fy" not in candidate.channels or not set(candidate.requires) <= INPUTS:
            continue
        for missing, size in (pair for form in candidate.forms for pair in _of_form(name, form, library)):
            added = motion.side_forces(missing.on(size, factors)) - without
            if np.isfinite(added).all() and np.abs(added).max() > MIN_CHANGE:
                columns.append((missing, size, added))
    return columns


def _idle(tire: Tire) -> frozenset[str]:
    """Return the effects of a tire that do not act on its side force: it lacks them as if it did not have them."""
    declared = tire.symbolic_model.coefficients
    acting = {name for name, entry in declared.items() if entry.neutral not in (None, tire.values[name])}
    of_side_force = {name for name, entry in declared.items() if "Fy" in (entry.channels or ("Fy",))}
    owned = {name: tire.symbolic_model.owned(name) & of_side_force for name in tire.has}
    return frozenset(name for name, keys in owned.items() if keys and not keys & acting)


def _of_form(name: str, form: Form, library: Mapping[str, Tire]) -> list[tuple[Missing, FloatArray]]:
    """Return an effect with the coefficients of a form that change the side force, and u at each typical size."""
    model = library["front"].symbolic_model
    result = []
    for probe in form.probes:
        center, spread, logarithmic, u = dict[str, float](), dict[str, float](), set[str](), dict[str, float]()
        for key in form.free:
            declared, declared_spread = model.coefficients[key], model.prior_spread.get(key)
            if declared.channels and "Fy" not in declared.channels:
                continue
            u[key] = 0.0
            if key in form.grid:
                center[key], spread[key] = float(np.median(form.grid[key])), float(np.std(np.log(form.grid[key])))
                logarithmic.add(key)
            elif form.scalable:
                neutral = declared.neutral if counts_from_neutral(declared) else 0.0
                center[key], spread[key] = neutral or 0.0, declared_spread or abs(probe.get(key, 1.0))
                u[key] = probe.get(key, 0.0) / spread[key]
            else:
                center[key], spread[key] = probe.get(key, declared.default), declared_spread or SCALE_SPREAD
                logarithmic |= set() if declared_spread else {key}
        if any(u.values()) or (u and not form.scalable):
            result.append((Missing(name, library, center, spread, frozenset(logarithmic)), np.array(list(u.values()))))
    return result
