"""A state of an added effect: a memory of its drive with one of a few laws."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace

from .formula_names import names_in

#: By kind: the required formulas in addition to the drive, each a tuple of alternatives, and the optional formulas.
KINDS: dict[str, tuple[tuple[tuple[str, ...], ...], tuple[str, ...]]] = {
    "lag": ((("rate", "length"),), ("start",)),
    "heat": ((("rate",),), ("ambient", "start")),
    "accumulation": ((), ("start",)),
    "oscillator": ((("frequency",), ("damping",)), ("start",)),
    "hysteresis": ((("width",),), ("start",)),
    "play": ((("width",),), ("start",)),
}
#: The start of a state that is fitted to each segment of a recording, and the kinds that may have it.
FITTED, WITH_FITTED_START = "fitted", ("lag", "heat", "accumulation")
#: The kinds that change along a path, independent of time.
PATHS = ("hysteresis", "play")
#: The kind of the second state of an oscillator, which no file declares, and the ending of its name.
SPEED, SPEED_ENDING = "speed", "_speed"
#: The power that sliding turns into heat, W: formulas of states may read it like a named quantity.
SLIDING_POWER = "sliding_power"
#: Endings of the names of the lines that a state adds to a model: target or flow, rate, start, derivative.
LINES = ("target", "rate", "start", "derivative")


@dataclass(frozen=True)
class State:
    """A state x of an added effect.

    - `kind`: "lag": x' = rate (drive - x), with the rate |V|/length if a length is given. "heat": x' = drive - rate (x
      - ambient). "accumulation": x' = drive. "oscillator": x'' = frequency^2 (drive - x) - damping x', whose formulas
      read inputs alone; x' is a state of its own behind this one, of kind "speed" with the same formulas
      (`with_speeds`). "hysteresis": dx = (sgn(ds) - x) |ds|/width, where s is the lag that the drive names, or the size
      sqrt(a^2 + b^2) of two lags. "play": dx = ds/width, but not beyond -1 and 1: the follower of a backlash is at s -
      width x.
    - `drive`: a formula; of a hysteresis and of play the names of one or two lags.
    - `rate`, `length`, `width`, `ambient`, `frequency`, `damping`: formulas; empty if the kind does not have them.
    - `start`: a formula of coefficients for the value at the start of a recording. If empty, a lag, a heat balance and
      an oscillator start in equilibrium with the first row, and other states at 0. "fitted": so do they in a tire, but
      a fit and a diagnosis estimate the value at the start of each segment of a recording.
    - `observed`: whether its value is a result of the tire, in addition to the forces.

    >>> late = State("late_load", "lag", ("Fz",), length="LATE", unit="N")
    >>> sorted(late.reads), late.reads_only({"Fz", "V"}, {"LATE"})
    (['Fz', 'LATE', 'V'], True)
    """

    name: str
    kind: str
    drive: tuple[str, ...]
    rate: str = ""
    length: str = ""
    width: str = ""
    ambient: str = ""
    frequency: str = ""
    damping: str = ""
    start: str = ""
    description: str = ""
    unit: str = "1"
    observed: bool = False

    @property
    def line_names(self) -> tuple[str, ...]:
        """The names of the lines that it adds to a model, in the order of `LINES`."""
        return tuple(f"{self.name}_{ending}" for ending in LINES)

    @property
    def start_is_fitted(self) -> bool:
        """Whether its value at the start of each segment of a recording is estimated."""
        return self.start == FITTED

    @property
    def has_start_value(self) -> bool:
        """Whether a formula declares its value at the start of a recording."""
        return bool(self.start) and not self.start_is_fitted

    @property
    def settles(self) -> bool:
        """Whether it has an equilibrium at constant inputs."""
        return self.kind in ("lag", "heat", "oscillator", SPEED)

    @property
    def oscillates(self) -> bool:
        """Whether it has the position of an oscillator; the state behind it is the speed."""
        return self.kind == "oscillator"

    @property
    def speed_name(self) -> str:
        """The name of the speed of an oscillator."""
        return f"{self.name}{SPEED_ENDING}"

    @property
    def follows_a_path(self) -> bool:
        """Whether it changes along a path, without regard to time."""
        return self.kind in PATHS

    @property
    def event_line(self) -> str:
        """The name of the line whose sign changes where the derivative of a state along a path jumps; else empty."""
        return {"hysteresis": self.line_names[0], "play": f"{self.name}_margin"}.get(self.kind, "")

    def formulas(self) -> Iterator[tuple[str, str]]:
        """Yield key and text of each formula; the drive of a state along a path is none."""
        if not self.follows_a_path:
            yield "drive", self.drive[0]
        for key in ("rate", "length", "width", "ambient", "frequency", "damping", "start"):
            if (text := getattr(self, key)) and not (key == "start" and self.start_is_fitted):
                yield key, text

    @property
    def reads(self) -> frozenset[str]:
        """The names that its formulas read."""
        read = {name for _, text in self.formulas() for name in names_in(text)}
        read |= {"V"} if self.length else set()
        return frozenset(read.union(self.drive) if self.follows_a_path else read)

    def reads_only(self, inputs: Collection[str], coefficients: Collection[str]) -> bool:
        """Return whether it depends on inputs and coefficients alone, not on forces, quantities or other states."""
        return self.reads <= {*inputs, *coefficients}


def rate_unit(unit: str) -> str:
    """Return the unit of a derivative by time. All factors behind the one ``/`` divide.

    >>> rate_unit("N"), rate_unit("N/s")
    ('N/s', 'N/s s')
    """
    return f"{unit} s" if "/" in unit else f"{unit}/s"


def with_speeds(states: Iterable[State]) -> Iterator[State]:
    """Yield states, and the speed of each oscillator behind it.

    >>> swing = State("swing", "oscillator", ("Fy",), frequency="200", damping="20", unit="N")
    >>> [(state.name, state.kind, state.unit) for state in with_speeds([swing])]
    [('swing', 'oscillator', 'N'), ('swing_speed', 'speed', 'N/s')]
    """
    for state in states:
        yield state
        if state.oscillates:
            what = f"rate of change of {state.description or state.name}"
            yield replace(
                state, name=state.speed_name, kind=SPEED, start="", unit=rate_unit(state.unit), description=what
            )
