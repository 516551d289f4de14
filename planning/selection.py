"""The choice of maneuvers: greedy addition, then exchange (Fedorov, Theory of Optimal Experiments, 1972).

The next maneuver is the one of a random sample of the library that lowers the criterion most per second of bench time.
A sample of a tenth is nearly as good as the library (Mirzasoleiman et al., Lazier than lazy greedy, AAAI 2015); what it
misses, the exchange finds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
#: Maneuvers of a sample; rounds of exchange, and the share of the maneuvers that a round may exchange.
SAMPLE, EXCHANGES, EXCHANGED = 24, 3, 1.0 / 3.0
#: The bench time of a program with its real changes: rounds in which it is adjusted, until this share is used.
ROUNDS, CLOSE = 4, 0.96


@dataclass(frozen=True, eq=False)
class Selection:
    """Chooses maneuvers within limits of time and energy.

    - `parts`, each with maneuvers along its first axis: what a maneuver adds to the information of a program.
    - `criterion`: of sums of these parts; the best program has the lowest.
    - `seconds`, `energy`, shape (m,): what each maneuver needs, about.
    - `max_energy`: of the whole program.
    """

    parts: tuple[FloatArray, ...]
    criterion: Callable[..., float]
    seconds: FloatArray
    energy: FloatArray
    max_energy: float

    def chosen(
        self, budget: float, needed: Callable[[list[int]], float], progress: Callable[[float], None]
    ) -> list[int]:
        """Return the indices of the best maneuvers, with repetitions; none if the time is too short.

        `budget`: s. `needed`: returns the real bench time of maneuvers. `progress`: called with the share of the time.
        """
        allowed, best, chosen = budget, list[int](), list[int]()
        for _ in range(ROUNDS):
            chosen = self._exchanged(self._filled(chosen, allowed, progress), allowed, progress)
            used = needed(chosen) if chosen else 0.0
            if used <= budget and (not best or used > needed(best)):
                best = chosen
            if not chosen or CLOSE * budget <= used <= budget:
                break
            allowed *= min(0.99 * budget / used, 1.3)
            while chosen and self.seconds[chosen].sum() > allowed:
                chosen = self._without_least(chosen, 1)
        return best

    def _exchanged(self, chosen: list[int], budget: float, progress: Callable[[float], None]) -> list[int]:
        """Exchange the least useful maneuvers as long as the criterion gets lower."""
        for _ in range(EXCHANGES):
            fewer = self._without_least(chosen, int(EXCHANGED * len(chosen)))
            exchanged = self._filled(fewer, budget, progress)
            if self._value(exchanged) >= self._value(chosen):
                break
            chosen = exchanged
        return chosen

    def _filled(self, start: Sequence[int], budget: float, progress: Callable[[float], None]) -> list[int]:
        """Add the best maneuvers while there is time."""
        chosen = list(start)
        while True:
            seconds, energy = self.seconds[chosen].sum(), self.energy[chosen].sum()
            progress(min(float(seconds / budget), 1.0))
            possible = (self.seconds + seconds <= budget) & (self.energy + energy <= self.max_energy)
            if not possible.any():
                return chosen
            index = np.flatnonzero(possible)
            sample = self._random.choice(index, min(SAMPLE, len(index)), replace=False)
            now = self._sums(chosen)
            values = [self.criterion(*(total + part[i] for total, part in zip(now, self.parts, strict=True))) for i in sample]
            chosen.append(int(sample[np.argmin((np.array(values) - self.criterion(*now)) / self.seconds[sample])]))

    def _without_least(self, chosen: list[int], count: int) -> list[int]:
        """Return a program without the maneuvers that contribute least per second."""
        now = self._sums(chosen)
        losses = {
            i: self.criterion(*(total - part[i] for total, part in zip(now, self.parts, strict=True))) - self.criterion(*now)
            for i in set(chosen)
        }
        order = sorted(range(len(chosen)), key=lambda k: losses[chosen[k]] / self.seconds[chosen[k]])
        return [chosen[k] for k in sorted(order[count:])]

    def _value(self, chosen: Sequence[int]) -> float:
        return self.criterion(*self._sums(chosen))

    def _sums(self, chosen: Sequence[int]) -> tuple[FloatArray, ...]:
        return tuple(np.asarray(part[list(chosen)].sum(axis=0)) for part in self.parts)

    @cached_property
    def _random(self) -> np.random.Generator:
        return np.random.default_rng(0)
