"""The tire of a solution: the baseline model with or without the identified effects."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from ...tires.definition import RANGES
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution


def tire_of(problem: LeastSquares, solution: Solution, added: Collection[str]) -> Tire:
    """Return the tire of a solution: the baseline model with the effects of these names."""
    start = problem.simulator.tire
    present = set(start.has) | set(added)
    if "relax_load" in present:
        present.discard("relax_lat")
    read = {name for effect in start.added if effect.name in present for name in effect.reads}
    nominal = {str(quantity.nominal) for quantity in start.symbolic_model.inputs if quantity.name in read}
    used = tuple(  # also effects that are off but declare the nominal value of an input
        e for e in start.added if e.name in present or nominal & {declaration.name for declaration in e.declarations}
    )
    of_used, of_all = ({d.name for effect in effects for d in effect.declarations} for effects in (used, start.added))
    values = {name: value for name, value in start.values.items() if name in of_used or name not in of_all}
    tire = replace(start, effects=tuple(present), added=used, values=values)
    index, factors = problem.simulator.index, tire.rescaled
    inputs = problem.simulator.signals.named()
    varied = [name for name in RANGES if name in inputs and np.ptp(inputs[name]) > 0.0]
    ranges = {name: (float(inputs[name].min()), float(inputs[name].max())) for name in varied}
    values = {
        name: float(solution.parameters[index[name]]) / factors.get(name, 1.0)
        for name in tire.symbolic_model.coefficients.keys() - {end for name in varied for end in RANGES[name]}
    }
    return replace(tire, values=values, ranges=ranges)
