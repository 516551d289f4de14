"""Random numbers that are the same on every version of NumPy, which promises this of raw bits only (NEP 19)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Item = TypeVar("Item")


class Draws:
    """A stream of random numbers; `key`: integers from 0, which select the stream."""

    def __init__(self, *key: int) -> None:
        self._bits = np.random.PCG64(np.random.SeedSequence(key))

    def uniform(self, low: float, high: float, n: int) -> FloatArray:
        """Return uniformly distributed numbers, shape (n,)."""
        raw = np.asarray(self._bits.random_raw(n), dtype=np.uint64)
        return low + (high - low) * (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53

    def between(self, low: float, high: float) -> float:
        """Return one uniformly distributed number."""
        return float(self.uniform(low, high, 1)[0])

    def chance(self, probability: float) -> bool:
        """Return True with a probability."""
        return self.between(0.0, 1.0) < probability

    def normal(self, n: int) -> FloatArray:
        """Return normally distributed numbers, shape (n,) (Box and Muller, 1958)."""
        radius = np.sqrt(-2.0 * np.log1p(-self.uniform(0.0, 1.0, n)))
        return np.asarray(radius * np.cos(self.uniform(0.0, 2.0 * np.pi, n)))

    def shuffled(self, items: Sequence[Item]) -> list[Item]:
        """Return the items in random order."""
        return [items[i] for i in np.argsort(self.uniform(0.0, 1.0, len(items)), kind="stable")]

    def choice(self, items: Sequence[Item]) -> Item:
        """Return one of the items."""
        return items[int(self.between(0.0, 1.0) * len(items))]


def low_pass(signal: FloatArray, steps: FloatArray) -> FloatArray:
    """Return a first-order lag of a signal, shape (n,), that starts at its first value.

    `steps`, shape (n,): the step to each row over the length or time of the lag; the first is not used. Within a step
    the signal is linear.
    """
    lagged = np.empty_like(signal)
    state = lagged[0] = signal[0]
    for i in range(1, len(signal)):
        behind = (signal[i] - signal[i - 1]) / steps[i]
        state = lagged[i] = signal[i] - behind + (state - signal[i - 1] + behind) * np.exp(-steps[i])
    return lagged
