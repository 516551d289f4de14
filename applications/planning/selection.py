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

from ...numerics.ties import graded
from .bench_file import Bench, Heat, PlanError
from .information import Experiment, energies
from .maneuvers import Maneuver, held_levels
from .program import TestProgram, cost, nearest_order, timed

FloatArray = npt.NDArray[np.float64]
#: Maneuvers of a sample; rounds of exchange, and the share of the maneuvers that a round may exchange.
SAMPLE, EXCHANGES, EXCHANGED = 24, 3, 1.0 / 3.0
#: The bench time of a program with its real changes: rounds in which it is adjusted, until this share is used.
ROUNDS, CLOSE = 4, 0.96
#: Exchanges of two steps that are tried for a better order.
TRIALS = 300


@dataclass(frozen=True, eq=False)
class ManeuverSelection:
    """Chooses maneuvers within limits of time and energy.

    - `maneuvers`, of length m: the library.
    - `parts`, each with maneuvers along its first axis: what a maneuver adds to the information of a program.
    - `criterion`: of sums of these parts; the best program has the lowest.
    - `seconds`, `energy`, shape (m,): what each maneuver needs, about; infinite for one that heats the tread too much.
    """

    bench: Bench
    maneuvers: Sequence[Maneuver]
    parts: tuple[FloatArray, ...]
    criterion: Callable[..., float]
    seconds: FloatArray
    energy: FloatArray

    @classmethod
    def of(
        cls, experiment: Experiment, bench: Bench, maneuvers: Sequence[Maneuver], parts: tuple[FloatArray, ...],
        criterion: Callable[..., float],
    ) -> ManeuverSelection:  # fmt: skip
        """Return the choice among a library; raises `PlanError` if each of its maneuvers heats the tread too much."""
        energy, nominal = np.zeros(len(maneuvers)), held_levels(bench, experiment.tires[0])
        if bench.heat != Heat():
            energy = energies(experiment, [maneuver.table(bench.sample_rate) for maneuver in maneuvers])
        if energy.min() > bench.heat.energy_of_a_sweep:
            raise PlanError(
                f"[heat] energy_of_a_sweep: every sweep has more sliding energy, {energy.min():.4g} J at least"
            )
        seconds = [cost(maneuver, bench, joule, nominal) for maneuver, joule in zip(maneuvers, energy, strict=True)]
        possible = np.where(energy <= bench.heat.energy_of_a_sweep, seconds, np.inf)
        return cls(bench, maneuvers, parts, criterion, possible, energy)

    def chosen(self, minutes: float, progress: Callable[[float], None]) -> list[int]:
        """Return the indices of the best maneuvers, with repetitions, in an order with short changes.

        `progress`: called with the share of the time that is used. Raises `PlanError` if the time is too short.
        """
        budget = allowed = 60.0 * minutes - self.bench.warm_up
        best, longest, chosen = list[int](), 0.0, list[int]()
        for _ in range(ROUNDS):
            chosen = self._exchanged(self._filled(chosen, allowed, progress), allowed, progress)
            if not chosen:
                break
            order = [chosen[i] for i in nearest_order([self.maneuvers[i] for i in chosen], self.bench)]
            used = self.program(order).seconds - self.bench.warm_up
            if longest < used <= budget:
                best, longest = order, used
            if CLOSE * budget <= used <= budget:
                break
            allowed *= min(0.99 * budget / used, 1.3)
            while chosen and self.seconds[chosen].sum() > allowed:
                chosen = self._without_least(chosen, 1)
        if not best:
            raise PlanError(
                f"{minutes:g} min are too short: a warm-up of {self.bench.warm_up:g} s and the shortest maneuver of "
                f"this bench with its change need {self.bench.warm_up + self.seconds.min():.3g} s"
            )
        return best

    def program(self, order: Sequence[int], *, alternate: bool = True) -> TestProgram:
        """Return the program of some maneuvers in their order."""
        maneuvers, energy = [self.maneuvers[i] for i in order], self.energy[list(order)].tolist()
        return timed(maneuvers, energy, self.bench, alternate=alternate)

    def exchanged_order(
        self, order: list[int], minutes: float, criterion: Callable[[TestProgram, Sequence[int]], float]
    ) -> TestProgram:
        """Return the program of the best order: exchanges of two random steps within the time lower its criterion.

        The criterion depends on the order by drift.
        """
        random, program = np.random.default_rng(0), self.program(order)
        best = criterion(program, order)
        for _ in range(TRIALS):
            i, j = random.integers(len(order), size=2)
            trial = list(order)
            trial[i], trial[j] = order[j], order[i]
            candidate = self.program(trial)
            if candidate.seconds <= 60.0 * minutes and (value := criterion(candidate, trial)) < best:
                program, order, best = candidate, trial, value
        return program

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
            possible = (self.seconds + seconds <= budget) & (self.energy + energy <= self.bench.heat.energy)
            if not possible.any():
                return chosen
            index = np.flatnonzero(possible)
            sample = self._random.choice(index, min(SAMPLE, len(index)), replace=False).tolist()
            chosen.append(sample[np.argmin(graded(self._changes(chosen, sample, 1.0) / self.seconds[sample]))])

    def _without_least(self, chosen: list[int], count: int) -> list[int]:
        """Return a program without the maneuvers that contribute least per second."""
        distinct = list(dict.fromkeys(chosen))
        losses = dict(zip(distinct, self._changes(chosen, distinct, -1.0) / self.seconds[distinct], strict=True))
        order = sorted(range(len(chosen)), key=lambda k: graded(losses[chosen[k]]))
        return [chosen[k] for k in sorted(order[count:])]

    def _changes(self, chosen: Sequence[int], others: Sequence[int], sign: float) -> FloatArray:
        """Return the changes of the criterion by adding other maneuvers, or by removing them."""
        now = self._sums(chosen)
        values = [
            self.criterion(*(s + sign * part[i] for s, part in zip(now, self.parts, strict=True))) for i in others
        ]
        return np.array(values) - self.criterion(*now)

    def _value(self, chosen: Sequence[int]) -> float:
        return self.criterion(*self._sums(chosen))

    def _sums(self, chosen: Sequence[int]) -> tuple[FloatArray, ...]:
        return tuple(np.asarray(part[list(chosen)].sum(axis=0)) for part in self.parts)

    @cached_property
    def _random(self) -> np.random.Generator:
        return np.random.default_rng(0)
