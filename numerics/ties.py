"""Declared order instead of ties: scores are compared at a resolution that rounding errors do not reach.

Scores that are equal in exact arithmetic differ in their last digits, which depend on the processor, the libraries and
the order of the rows. Whatever is sorted or chosen by a computed score is therefore sorted or chosen by the graded
score: `sorted`, `max`, `min` and `argmax` then keep the declared order of equal candidates, or take the first one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

import numpy as np

from .arrays import FloatArray

#: Bits of a score that count: a relative resolution of 1e-6, coarser than the rounding errors of sums, regressions and
#: converged fits, finer than anything that a message shows.
BITS = 20


@overload
def graded(score: float) -> float: ...
@overload
def graded(score: FloatArray | Sequence[float] | Sequence[FloatArray]) -> FloatArray: ...
def graded(score: float | FloatArray | Sequence[float] | Sequence[FloatArray]) -> float | FloatArray:
    """Return scores rounded to the bits that count; infinite and undefined ones are unchanged.

    >>> tied = {"first": 0.3, "second": 0.1 + 0.2}
    >>> max(tied, key=tied.get), max(tied, key=lambda name: graded(tied[name]))
    ('second', 'first')
    """
    mantissa, exponent = np.frexp(score)
    rounded: FloatArray = np.ldexp(np.rint(np.ldexp(mantissa, BITS)), exponent - BITS)
    return rounded if np.ndim(rounded) else float(rounded)
