"""Times that no log of a drive has: another unit, a jump, single precision. They are found before any work."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ....boundary.escaping import quoted
from ....measurements.units import to_si

FloatArray = npt.NDArray[np.float64]

#: s: shortest and longest median step of a log, and its longest duration. Judgement: 10 kHz, 1 Hz, a day.
SHORTEST_STEP, LONGEST_STEP, LONGEST = 1e-4, 1.0, 86400.0
#: s: duration below which steps shorter than the second number are rather of another unit (minutes of a log at 10 Hz),
#: and the units that are tried.
SHORTEST, SHORT_STEP, TRIED = 5.0, 2e-3, ("ms", "us", "ns", "min", "h")
#: Largest share of samples without a time of their own.
MAX_REPEATED = 0.5


def clock_problem(t: FloatArray, header: str) -> str:
    """Return why times in s are not those of a drive, with the unit that makes them plausible; empty if they may be.

    `t`, shape (n,): as logged. `header`: of their column; empty if the file has the times of each channel.

    >>> clock_problem(1e4 * np.arange(1500.0), "timestamp")
    "1500 samples span 1.499e+07 s, with a step of 1e+04 s: in us? --columns 't=timestamp [us]'"
    """
    if len(t) < 3:
        return ""
    steps = np.diff(t)
    if (steps < 0.0).any():
        row = int(np.flatnonzero(steps < 0.0)[0])
        return f"time decreases at sample {row + 2}: {t[row]:.10g} to {t[row + 1]:.10g} s: cut the log there"
    forward = steps[steps > 0.0]
    if len(forward) < (1.0 - MAX_REPEATED) * len(steps):
        return (
            f"{len(steps)} steps of time, of which {len(steps) - len(forward)} are 0: times in single precision, or "
            "rounded: export them with more digits or from 0 on"
        )
    step, span = float(np.median(forward)), float(t[-1] - t[0])
    if _plausible(step, span) or (SHORT_STEP <= step <= LONGEST_STEP and span < SHORTEST):
        return ""
    fact = f"{len(t)} samples span {span:.4g} s, with a step of {step:.4g} s"
    units = [unit for unit in TRIED if _plausible(float(to_si(step, unit)), float(to_si(span, unit)))]
    if units and header:
        option = f"t={header} [{units[0]}]"
        return f"{fact}: in {' or '.join(units)}? --columns {quoted(option)}"
    if units:
        return f"{fact}: in {' or '.join(units)}?"
    largest = float(steps.max())
    if span > LONGEST and step <= LONGEST_STEP and span - largest <= LONGEST:
        row = int(np.argmax(steps))
        return f"time jumps by {largest:.4g} s behind sample {row + 1}: cut the log there"
    if span > LONGEST:
        return f"{fact}: more than a day: cut the log, or state the unit of t"
    return f"{fact}: a step above {LONGEST_STEP:g} s is none of a drive" if step > LONGEST_STEP else ""


def _plausible(step: float, span: float) -> bool:
    return SHORTEST_STEP <= step <= LONGEST_STEP and SHORTEST <= span <= LONGEST
