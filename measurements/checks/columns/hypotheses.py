"""Hypotheses on a table: what may be wrong with its columns, each as the interpretation that corrects it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from ....boundary.errors import UnknownName
from ....symbolic.channels import CHANNELS
from ....tires.signs import SIGNS
from ...interpretation import Interpretation
from ...recording import Recording
from ...units import UNITS_OF_TABLES, unit_of

#: Quantities whose unit is tested, and units that only mistakes have.
TESTED, MISTAKEN = ("force", "moment", "angle", "ratio", "pressure"), {"force": ("0.1 N",)}
#: Channels that come in one unit: alone or together in another one.
TOGETHER = (("Fx", "Fy"), ("Mz", "Mx"), ("alpha", "gamma"), ("Fz", "Fx", "Fy"))
#: Pairs of columns that are exchanged.
EXCHANGED = (("alpha", "kappa"), ("alpha", "gamma"), ("kappa", "gamma"), ("Fx", "Fy"), ("Mx", "Mz"))
#: Channels whose sign is often reversed.
MIRRORED = ("alpha", "kappa", "gamma", "Fx", "Fy", "Mz", "Fz")
#: Minus the logarithm of the probability that a table has the fault: its sign convention, a unit that it does not
#: declare, a declared one, a reversed sign, exchanged columns. Judgement.
CONVENTION_COST, UNIT_COST, DECLARED_COST, MIRROR_COST, EXCHANGE_COST = 2.0, 2.5, 3.5, 3.0, 3.0
#: The same of a further fault in addition to its own, and of units that few tables have.
SECOND_COST, RARE_COST = 1.0, {"kgf": 1.0, "daN": 1.5, "0.1 N": 2.0, "lbf in": 1.0, "kN m": 1.0}


@dataclass(frozen=True)
class Hypothesis:
    """An interpretation of a table and its signs, with its cost: minus the logarithm of its prior probability."""

    signs: str
    interpretation: Interpretation = field(default_factory=Interpretation)
    cost: float = 0.0

    def applied(self, recording: Recording) -> Recording:
        """Return the recording in this reading."""
        read = replace(recording, signs=self.signs)
        return self.interpretation.applied(read) if self.interpretation else read

    def exchanges(self, name: str) -> bool:
        """Return whether it exchanges a channel with another one."""
        return self.interpretation.columns.get(name) in CHANNELS

    def described(self, claimed: str) -> str:
        """Return the hypothesis in words."""
        parts = [f"the data fit {self.signs}"] if self.signs != claimed else []
        columns = dict(self.interpretation.columns)
        for name, source in self.interpretation.columns.items():
            if source == f"-{name}":
                parts.append(f"{name} has the other sign")
            elif columns.get(source) == name and name < source:
                parts.append(f"the columns {name} and {source} are exchanged")
        parts += [f"{name} is in {unit}" for name, unit in self.interpretation.units.items()]
        return " and ".join(parts)

    def advice(self, claimed: str) -> str:
        """Return the header or the options that make the program read the table in this way."""
        parts = [f"--signs {self.signs}"] if self.signs != claimed else []
        if self.interpretation.columns:
            parts.append(str(replace(self.interpretation, units={})))
        if self.interpretation.units:
            headers = ", ".join(f"'{name} [{unit}]'" for name, unit in self.interpretation.units.items())
            written = ",".join(f"{name}={unit.replace(' ', '')}" for name, unit in self.interpretation.units.items())
            parts.append(f"--units {written}, or the header {headers}")
        return " ".join(parts)


def hypotheses(recording: Recording) -> Iterator[Hypothesis]:
    """Yield what may be wrong with a table, one fault each; channels that the user asserts are right."""
    asserted = recording.about.get("asserted", "").split()
    present = [name for name in CHANNELS if name in recording.table and name not in asserted]
    for signs in SIGNS if {*MIRRORED} & {*present} else ():  # a convention turns channels that are not asserted
        if signs != recording.signs:
            yield Hypothesis(signs, cost=CONVENTION_COST)
    for name in present:
        yield from _in_other_units(recording, (name,))
    for names in TOGETHER:
        if set(names) <= set(present):
            yield from _in_other_units(recording, names)
    for name in MIRRORED:
        if name in present:
            yield Hypothesis(recording.signs, Interpretation({name: f"-{name}"}), MIRROR_COST)
    for first, second in EXCHANGED:
        if first in present and second in present:
            yield Hypothesis(recording.signs, Interpretation({first: second, second: first}), EXCHANGE_COST)


def _in_other_units(recording: Recording, names: Sequence[str]) -> Iterator[Hypothesis]:
    """Yield the units of channels of one quantity, other than the one in which they were read."""
    read_as = {name: recording.about.get(f"unit of {name}", "") for name in names}
    quantity = CHANNELS[names[0]].quantity
    declared = bool({*names} & {*recording.about.get("declared", "").split()})
    for unit in (*UNITS_OF_TABLES[quantity], *MISTAKEN.get(quantity, ())) if quantity in TESTED else ():
        factors = {_factor(spelling, quantity) for spelling in read_as.values()}
        if factors != {_factor(unit, quantity)}:
            cost = (DECLARED_COST if declared else UNIT_COST) + RARE_COST.get(unit, 0.0)
            yield Hypothesis(recording.signs, Interpretation({}, dict.fromkeys(names, unit)), cost + len(names) - 1)


def _factor(spelling: str, quantity: str) -> float:
    try:
        return unit_of(spelling, quantity).factor if spelling else 1.0
    except UnknownName:  # a spelling that only its reader knows
        return 1.0


def combined(first: Hypothesis, second: Hypothesis, claimed: str) -> Hypothesis | None:
    """Return both hypotheses as one; None if they contradict each other or do the same twice."""
    mine, other = first.interpretation, second.interpretation
    names = [*mine.columns, *mine.units, *other.columns, *other.units]
    if len(set(names)) < len(names):
        return None
    if claimed not in (first.signs, second.signs):
        return None
    both = Interpretation({**mine.columns, **other.columns}, {**mine.units, **other.units})
    signs = first.signs if second.signs == claimed else second.signs
    return Hypothesis(signs, both, first.cost + second.cost + SECOND_COST)
