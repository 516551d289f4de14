"""What could be added to an explanation: gains in the linear problem, and effects that take one another's place."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...numerics.ties import graded
from ..thresholds import REPORTED, RIVALS
from .evidence import Projected
from .linearization import Addition, Linearization

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Gain:
    """An addition with the increase of the logarithm of the evidence, prior odds included, and its estimate."""

    gain: float
    addition: Addition
    estimate: FloatArray


def projected(linear: Linearization, additions: Sequence[Addition]) -> Projected:
    """Return the columns of additions without what an explanation contains."""
    return Projected.of(linear.equations(additions), [len(addition.deviation) for addition in additions])


def gains(columns: Projected, additions: Sequence[Addition]) -> dict[str, list[Gain]]:
    """Return what could be added to an explanation, by name, with its gain in the linear problem."""
    scored = dict[str, list[Gain]]()
    for addition, group in zip(additions, columns.groups, strict=True):
        gain, estimate = columns.gain(group)
        scored.setdefault(addition.name, []).append(Gain(gain + addition.log_prior, addition, estimate))
    return scored


def rivals_of(parts: Collection[str], columns: Projected, additions: Sequence[Addition]) -> tuple[str, ...]:
    """Return the `RIVALS` effects that take most of what parts of an explanation take, if they are confounded."""
    size = dict[str, float]()
    for part, group in zip(additions, columns.groups, strict=True):
        if part.name in parts:
            correlations = columns.correlations(group)
            for other, others in zip(additions, columns.groups, strict=True):
                size[other.name] = max(size.get(other.name, 0.0), float(correlations[others].max()))
    confounded = [name for name, most in size.items() if most > REPORTED and name not in parts]
    return tuple(sorted(confounded, key=lambda name: -graded(size[name]))[:RIVALS])
