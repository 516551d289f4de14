"""Combined slip that no data show: the coefficients with which both forces share the friction ellipse.

By the similarity method a force at combined slip is that of pure slip at the magnitude of both slips, relative to those
of the peaks, in their direction: the resultant is on the ellipse of the peaks where both saturate, and within it
elsewhere. Pacejka, Tire and Vehicle Dynamics (2012), section 4.1.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from math import radians

import numpy as np
from scipy.optimize import least_squares

from ...numerics.arrays import FloatArray
from ...tires.code import fastest_code
from ...tires.tire import Tire
from .influence import generic

#: Largest slips at which a peak is sought, and points of a pure curve.
WIDEST, POINTS = {"kappa": 0.4, "alpha": radians(25.0)}, 61
#: Slips of the ellipse relative to those of the peaks, and directions between them.
SIZES, DIRECTIONS = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0), 9
#: Weight of a resultant beyond the ellipse: a tire that has too much of both forces is wrong on the unsafe side.
BEYOND = 10.0
#: Strength of the generic values, relative to a force of the size of its peak.
RIDGE = 0.01
#: Change of a force, relative to its peak, from which a coefficient has influence.
NOTICEABLE = 1e-4


def ellipse_values(tire: Tire, unknown: Collection[str]) -> dict[str, float]:
    """Return the values of unknown coefficients of combined slip with which the forces keep to the friction ellipse.

    `tire`: in adapted SAE, with the pure slip of the fit. `unknown`: coefficients that nothing determines; those that
    act at combined slip with their generic values are set. Empty if there are none.
    """
    if not ({"kappa", "alpha", "Fz"} <= set(tire.inputs) and {"Fx", "Fy"} <= set(tire.outputs)):
        return {}
    declared = tire.symbolic_model.coefficients
    live = tire.symbolic_model.live(tire.has).intersection(unknown)
    generics = ((name, generic(coefficient)) for name, coefficient in declared.items() if coefficient.fitted)
    start = {name: value for name, value in generics if name in live and value != 0.0}
    trial = _Forces(tire.with_values(**start))
    if not trial.peaks.min() > 0.0:
        return {}
    names = [name for name in start if trial.acts_only_combined(name)]
    if not names:
        return {}
    forces = _Forces(tire.with_values(**{name: start[name] for name in names}))
    sizes = np.array([max(abs(start[name]), 1.0) for name in names])
    lower, upper = (np.array([getattr(declared[name], end) for name in names]) for end in ("lower", "upper"))
    first = np.clip([start[name] for name in names], lower, upper) / sizes

    def residual(x: FloatArray) -> FloatArray:
        computed = forces.at(dict(zip(names, (x * sizes).tolist(), strict=True)))
        beyond = np.maximum(np.hypot(*computed) - 1.0, 0.0)
        return np.concatenate([(computed - forces.target).ravel(), BEYOND * beyond, RIDGE * (x - first)])

    x = least_squares(residual, first, bounds=(lower / sizes, upper / sizes)).x * sizes
    return dict(zip(names, x.tolist(), strict=True))


class _Forces:
    """Fx and Fy of a tire over combined slips, relative to their peaks in pure slip, at its nominal load."""

    def __init__(self, tire: Tire) -> None:
        self._tire, self._code = tire, fastest_code(tire.symbolic_model, POINTS)
        self._parameters, self._order = tire.parameters(), list(tire.symbolic_model.parameters)
        self._rows = [tire.outputs.index(name) for name in ("Fx", "Fy")]
        grids, zero = [np.linspace(0.0, WIDEST[name], POINTS) for name in ("kappa", "alpha")], np.zeros(POINTS)
        self._of_pure = self._inputs(grids[0], zero), self._inputs(zero, grids[1])
        self._unchanged = self._pure({})
        pure = [curve - curve[0] for curve in self._unchanged]
        ends = [int(np.abs(curve).argmax()) for curve in pure]
        self.peaks = np.array([np.abs(curve[end]) for curve, end in zip(pure, ends, strict=True)])
        at_peak = [max(float(grid[end]), grid[1]) for grid, end in zip(grids, ends, strict=True)]
        size, angle = np.meshgrid(SIZES, np.linspace(0.0, 0.5 * np.pi, DIRECTIONS))
        parts = np.cos(angle).ravel(), np.sin(angle).ravel()
        shares = [
            np.interp(size.ravel() * slip, grid, curve / peak)
            for slip, grid, curve, peak in zip(at_peak, grids, pure, np.maximum(self.peaks, 1e-300), strict=True)
        ]
        self.target = np.array([part * share for part, share in zip(parts, shares, strict=True)])
        self._of_combined = self._inputs(
            *(size.ravel() * part * slip for part, slip in zip(parts, at_peak, strict=True))
        )

    def at(self, values: dict[str, float]) -> FloatArray:
        """Return both forces relative to their peaks with values of some coefficients, shape (2, n)."""
        return np.asarray(self._forces(self._of_combined, values) / self.peaks[:, None])

    def acts_only_combined(self, name: str) -> bool:
        """Return whether a coefficient that grows by a tenth changes forces at combined slip, but none at pure slip."""
        more = {name: 1.1 * self._tire.values[name]}
        pure = (self._pure(more) - self._unchanged) / self.peaks[:, None]
        return bool(np.abs(self.at(more) - self._unchanged_combined).max() > NOTICEABLE >= np.abs(pure).max())

    @cached_property
    def _unchanged_combined(self) -> FloatArray:
        return self.at({})

    def _pure(self, values: dict[str, float]) -> FloatArray:
        """Return Fx over kappa and Fy over alpha, shape (2, POINTS)."""
        along, side = self._of_pure
        return np.array([self._forces(along, values)[0], self._forces(side, values)[1]])

    def _inputs(self, kappa: FloatArray, alpha: FloatArray) -> FloatArray:
        """Return the inputs of the code at slips."""
        tire = self._tire
        given = {"kappa": kappa, "alpha": alpha, "Fz": np.full(len(kappa), tire.values["FNOMIN"])}
        inputs = [given.get(name, np.full(len(kappa), tire.nominal(name))) for name in tire.inputs]
        return tire.effective_inputs(np.array(inputs))

    def _forces(self, inputs: FloatArray, values: dict[str, float]) -> FloatArray:
        parameters = self._parameters.copy()
        for name, value in values.items():
            parameters[self._order.index(name)] = value * self._tire.rescaled.get(name, 1.0)
        return np.asarray(self._code.forces(inputs, parameters))[self._rows]
