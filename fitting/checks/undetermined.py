"""Why a coefficient is not identifiable: the smallest additional test program that would determine it.

Additional test programs are evaluated with exact derivatives of the tire: further loads, inclinations, pressures, more
slip, combined slip, turn slip; first single programs, then pairs. The program that determines a coefficient best, with
a standard deviation of at most its typical size (a quarter of its plausible range), states what the data lack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product

import numpy as np

from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.ties import graded
from ...tires.code import fastest_code
from ...tires.tire import Tire
from ..problem.rows import inputs_of
from ..problem.weights import MIN_NOISE, OWN_SLIP
from ..uncertainty.sandwich import LARGEST_SD
from .residuals import Residuals

#: Number of measured rows that are evaluated as a sample; effective sample size of an additional program.
SAMPLE, PROGRAM_ROWS = 2000, 300.0
#: Lower limit of the eigenvalues of the information matrix.
MIN_EIGENVALUE = 1e-9
#: Least slip range of a program with more slip, rad or 1.
FULL_SLIP = {"kappa": 0.3, "alpha": 0.25}
#: Slip that counts as zero; share of the largest slip range below which a range is short.
NO_SLIP, SHORT = 0.02, 0.8
#: Inclination that counts as zero, rad.
NO_INCLINATION = 0.01
#: The inputs that additional programs vary.
PROGRAMS = ("Fz", "gamma", "p", "kappa", "alpha", "both", "phit")


@dataclass(frozen=True)
class Undetermined:
    """Coefficients that are not identifiable, and the reason.

    - `coefficients`: one without influence at the measured rows, several of which only a combination is determined, or
      those at a bound.
    - `reason`: what the data lack, or that the data pull a coefficient beyond its bound.
    """

    coefficients: tuple[str, ...]
    reason: str


def undetermined(
    residuals: Residuals, free: Sequence[str], sets: Sequence[tuple[str, ...]], effective: Mapping[str, float]
) -> tuple[Undetermined, ...]:
    """Return what the data lack for each set of coefficients that is not identifiable.

    `free`: the free coefficients. `sets`: the sets, their names among `free`. `effective`: effective sample size of
    each channel. Returns: sets with the same reason are combined.
    """
    if not sets:
        return ()
    identifiability = _Identifiability(residuals, tuple(free), effective)
    by_reason: dict[str, list[str]] = {}
    for names in sets:
        by_reason.setdefault(identifiability.reason(names), []).extend(names)
    return tuple(Undetermined(tuple(dict.fromkeys(names)), reason) for reason, names in by_reason.items())


def at_bounds(
    residuals: Residuals, free: Sequence[str], bounded: Sequence[str], effective: Mapping[str, float]
) -> tuple[Undetermined, ...]:
    """Return for coefficients at a bound whether the data pull beyond it, or whether they are not identifiable.

    `free`: the free coefficients, with those at a bound. `bounded`: those at a bound. `effective`: effective sample
    size of each channel. Returns: those with the same reason are combined.
    """
    if not bounded:
        return ()
    identifiability = _Identifiability(residuals, tuple(free), effective)
    by_reason: dict[str, list[str]] = {}
    for name in bounded:
        reason = (
            "the data pull beyond it"
            if identifiability.determines(name)
            else f"not identifiable, {identifiability.reason([name])}"
        )
        by_reason.setdefault(f"at a bound: {reason}", []).append(name)
    return tuple(Undetermined(tuple(names), reason) for reason, names in by_reason.items())


@dataclass(frozen=True, eq=False)
class _Identifiability:
    """Information in the data and in additional test programs."""

    residuals: Residuals
    free: tuple[str, ...]
    effective: Mapping[str, float]

    def determines(self, name: str) -> bool:
        """Return whether the measured data determine a coefficient."""
        return bool(_spreads(self._known)[self.free.index(name)] <= LARGEST_SD)

    def reason(self, names: Sequence[str]) -> str:
        """Return what the data lack to determine some coefficients."""
        indices = [self.free.index(name) for name in names]
        for count in (1, 2):
            spreads = {p: self._spreads[p][indices].max() for p in self._programs if len(p) == count}
            best = min(spreads, key=lambda program: graded(spreads[program]))
            if spreads[best] <= LARGEST_SD:
                return " together with ".join(self._lack(name, indices[0]) for name in best)
        alone = max(float(matrix[indices[0], indices[0]]) for matrix in self._information.values())
        if len(names) == 1 and alone < 1.0 / LARGEST_SD**2:
            return "it has almost no influence with the fitted values of the other coefficients"
        return "other coefficients have the same influence at every tested load, slip, inclination and pressure"

    @cached_property
    def _programs(self) -> list[tuple[str, ...]]:
        inputs = {*self.residuals.tire.inputs, "both"}
        single = [name for name in PROGRAMS if name in inputs]
        return [*((name,) for name in single), *combinations(single, 2)]

    @cached_property
    def _sigma(self) -> Mapping[str, float]:
        """The noise of each channel, at least `MIN_NOISE` of its signal."""
        residual_values, table = self.residuals.measured_minus_computed, self.residuals.table
        return {
            name: max(
                _root_mean_square(residual_values[name]),
                MIN_NOISE * _root_mean_square(table[name].to_numpy(dtype=float)),
            )
            for name in self.residuals.channels
        }

    @cached_property
    def _known(self) -> FloatArray:
        """The information in the data, in the sizes of the coefficients."""
        rows = np.random.default_rng(0).permutation(len(self.residuals.table))[:SAMPLE]
        table = self.residuals.table.iloc[np.sort(rows)]
        present = {name: np.isfinite(table[name].to_numpy(dtype=float)) for name in self.residuals.channels}
        return self._weighted_information(inputs_of(table, self._tire), present, self.effective)

    @cached_property
    def _information(self) -> Mapping[tuple[str, ...], FloatArray]:
        return {program: self._weighted_information(self._rows(program), {}, {}) for program in self._programs}

    @cached_property
    def _spreads(self) -> Mapping[tuple[str, ...], FloatArray]:
        """The standard deviation of every coefficient, in typical sizes, with each program."""
        return {program: _spreads(self._known + more) for program, more in self._information.items()}

    @property
    def _tire(self) -> Tire:
        return self.residuals.tire

    def _weighted_information(
        self, inputs: FloatArray, present: Mapping[str, BoolArray], effective_rows: Mapping[str, float], only: str = ""
    ) -> FloatArray:
        """Return the information matrix of rows, for the measured channels or for one channel."""
        tire = self._tire
        order = list(tire.symbolic_model.parameters)
        columns = np.array([order.index(name) for name in self.free])
        reach = self._sizes * np.array([tire.rescaled.get(name, 1.0) for name in self.free])
        jacobian = fastest_code(tire.symbolic_model).jacobian_parameters(
            tire.effective_inputs(inputs), tire.parameters()
        )
        matrix = np.zeros((len(self.free), len(self.free)))
        for name, sigma in self._sigma.items():
            part = np.nan_to_num(jacobian[:, tire.outputs.index(name), columns]) * reach
            part = part[present[name]] if name in present else part
            if len(part) and sigma > 0 and only in ("", name):
                matrix += effective_rows.get(name, PROGRAM_ROWS) / len(part) * part.T @ part / sigma**2
        return matrix

    @cached_property
    def _sizes(self) -> FloatArray:
        declarations = [self._tire.symbolic_model.coefficients[name] for name in self.free]
        spans = [0.25 * (declaration.upper - declaration.lower) for declaration in declarations]
        return np.array([span if np.isfinite(span) else 1.0 for span in spans])

    @cached_property
    def _ranges(self) -> Mapping[str, tuple[float, float]]:
        table = self.residuals.table
        nominal = {name: (self._tire.nominal(name),) * 2 for name in self._tire.inputs if name not in table}
        measured = [name for name in self._tire.inputs if name in table]
        return {**nominal, **{name: (float(table[name].min()), float(table[name].max())) for name in measured}}

    def _rows(self, program: tuple[str, ...]) -> FloatArray:
        """Return the rows of a program, with the slip ranges of the data or larger ones."""
        nominal = {name: self._tire.nominal(name) for name in self._tire.inputs}
        loads, pressure = self._ranges["Fz"], nominal.get("p", 0.0)
        middle = 0.5 * (loads[0] + loads[1])
        axes = {
            "Fz": (0.5 * loads[0], middle, 1.5 * loads[1]) if "Fz" in program else (middle,),
            "gamma": (-0.07, 0.0, 0.07) if "gamma" in program else (0.0,),
            "p": (0.8 * pressure, pressure, 1.2 * pressure) if "p" in program else (pressure,),
            "phit": (-0.2, 0.0, 0.2) if "phit" in program else (0.0,),
        }
        reach = {
            name: max(full, 1.5 * self._reach(name)) if {name, "both"} & set(program) else self._reach(name)
            for name, full in FULL_SLIP.items()
        }
        sweep = {name: np.linspace(-size, size, 15) for name, size in reach.items()}
        slips = [(k, 0.0) for k in sweep["kappa"]] + [(0.0, a) for a in sweep["alpha"]]
        if "both" in program:
            slips += list(product(sweep["kappa"][::2], sweep["alpha"][::2]))
        points = [
            {**nominal, "kappa": k, "alpha": a, **dict(zip(axes, values, strict=True))}
            for values in product(*axes.values())
            for k, a in slips
        ]
        return np.array([[point[name] for name in self._tire.inputs] for point in points]).T

    def _reach(self, slip: str) -> float:
        return max(map(abs, self._ranges[slip]))

    def _lack(self, name: str, index: int) -> str:
        if name == "Fz":
            return self._lacking_load(index)
        low, high = self._ranges.get(name, (0.0, 0.0))
        if name in self.residuals.table and name not in FULL_SLIP:
            low, high = self.residuals.range_of(name, self._channel(index))
        if name == "gamma":
            reach, other = sorted((abs(low), abs(high)), reverse=True)
            if reach < NO_INCLINATION:
                return "no inclination"
            one_sided = low * high > 0 or other < SHORT * reach
            return "inclination to one side only" if one_sided else f"no inclination beyond {np.degrees(reach):.2g} deg"
        if name == "p":
            return (
                "one pressure only"
                if high - low < 0.03 * high
                else f"no pressure beyond {low / 1e3:.3g} to {high / 1e3:.3g} kPa"
            )
        if name == "phit":
            return "no turn slip"
        if name == "both":
            return "no combined slip" if not self._combined else "not enough combined slip"
        reach = self._reach(name)
        unit = "" if name == "kappa" else " rad"
        return f"{name} does not vary" if high - low < NO_SLIP else f"no {name} beyond {reach:.2g}{unit}"

    @property
    def _combined(self) -> bool:
        table = self.residuals.table
        if not {"kappa", "alpha"} <= set(table.columns):
            return False
        return bool(((table["kappa"].abs() > NO_SLIP) & (table["alpha"].abs() > NO_SLIP)).any())

    def _lacking_load(self, index: int) -> str:
        """Return which loads the data lack: a second load, a second load with a large slip range, or a wider range."""
        loads = np.array(self.residuals.levels.get("Fz", ()))
        low, high = self._ranges["Fz"]
        if len(loads) < 2 and high - low < 0.3 * high:
            return "one load only"
        channel = self._channel(index)
        slip = OWN_SLIP.get(channel, "alpha")
        table = self.residuals.table
        if len(loads) > 1 and slip in table:
            level = np.abs(table["Fz"].to_numpy(dtype=float)[:, None] - loads).argmin(axis=1)
            measured = table[channel].notna().to_numpy()
            size = np.abs(table[slip].to_numpy(dtype=float))
            reaches = sorted(float(np.max(size[measured & (level == k)], initial=0.0)) for k in range(len(loads)))
            if reaches[-2] < SHORT * reaches[-1]:
                return f"no second load above {reaches[-2]:.2g} {slip}"
        return f"no load beyond {low:.4g} to {high:.4g} N"

    def _channel(self, index: int) -> str:
        """Return the channel with the most information on a coefficient."""
        return max(self._of_channels, key=lambda name: graded(float(self._of_channels[name][index])))

    @cached_property
    def _of_channels(self) -> Mapping[str, FloatArray]:
        """The information on each coefficient by channel."""
        rows = self._rows(("Fz", "both"))
        return {name: self._weighted_information(rows, {}, {}, name).diagonal() for name in self.residuals.channels}


def _spreads(information: FloatArray) -> FloatArray:
    """Return the standard deviation of each coefficient, in its sizes."""
    values, vectors = np.linalg.eigh(information)
    return np.asarray(np.sqrt(vectors**2 @ (1.0 / np.maximum(values, MIN_EIGENVALUE))))


def _root_mean_square(values: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))
