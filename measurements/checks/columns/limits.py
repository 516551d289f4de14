"""Values that no bench gives in the declared units: they are errors wherever a table is read."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....boundary.errors import DataError
from ....numerics.arrays import FloatArray
from ....numerics.ties import graded
from ....symbolic.channels import CHANNELS
from ....tires.input_check import (
    BACKWARD_SLIP,
    FAR_SLIP,
    MAX_BACKWARD_ROWS,
    MAX_FAR_SLIPS,
    MAX_WRONG_LOADS,
    SMALLEST_PRESSURE,
)
from ...recording import Recording
from ...thresholds import LARGEST_BAR, LARGEST_PSI, RATIO_TOLERANCE, SMALLEST_LOAD
from ...units import to_si

#: Degrees of a radian.
DEGREES = 180.0 / np.pi


def check_plausible(recording: Recording) -> None:
    """Refuse a recording whose numbers are implausible in the declared units or signs.

    Channels whose unit the file declares are not checked.

    Parameters
    ----------
    recording : Recording
        In SI units, as read.

    Raises
    ------
    DataError
        One line for the first problem: angles in degrees, slip in percent, loads in kN, pressures in kPa, bar or psi,
        speeds in km/h, temperatures in kelvin, slips of a wheel that spins, or loads of the wrong sign.

    Examples
    --------
    >>> import pandas as pd
    >>> check_plausible(Recording(pd.DataFrame({"alpha": [0.0, 12.0]}), "iso", "a.csv"))
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.DataError: a.csv: alpha reaches 12 rad: in degrees? declare it: 'alpha [deg]'
    """
    for problem in _problems(recording):
        raise DataError(f"{recording.source}: {problem}")


def _problems(recording: Recording) -> Iterator[str]:
    table = recording.table
    declared = recording.about.get("declared", "").split()
    for name, channel in CHANNELS.items():
        if name not in table or name in declared:
            continue
        low, high = channel.limits
        values = table[name].to_numpy(dtype=np.float64)
        outside = values[(values < low) | (values > high)]
        if len(outside):
            worst = outside[np.argmax(graded(np.abs(outside)))]
            if channel.wrong_unit[0] == "deg" and (mixed := _two_angle_units(name, values, low, high)):
                yield mixed
            unit, guess = channel.wrong_unit
            if unit and not low <= to_si(worst, unit, channel.quantity) <= high:
                unit, guess = "", "in another unit"
            hint = f"declare it: '{name} [{unit}]'" if unit else "check the unit"
            yield f"{name} reaches {worst:.4g}{channel.after}: {guess}? {hint}"
    yield from _too_small(recording, declared)
    yield from _spinning_wheel(recording, declared)
    yield from _wrong_load_sign(recording)


def _two_angle_units(name: str, values: FloatArray, low: float, high: float) -> str:
    """Return a sentence if the range of an angle grows by the ratio of deg and rad at one row; empty otherwise."""
    first = int(np.argmax((values < low) | (values > high)))
    before, after = (float(np.max(np.abs(part), initial=0.0)) for part in (values[:first], values[first:]))
    # The first rows of the part in degrees are within the limits: the larger part before it is compared.
    early = float(np.max(np.abs(values[: first - first // 4]), initial=0.0))
    for part in (before, early):
        if part > 0.0 and abs(after / part / DEGREES - 1.0) < RATIO_TOLERANCE:
            return (
                f"mixed units? {name} reaches {part:.4g} rad in the first rows and {after:.4g} rad "
                f"from row {first + 1} on, the ratio of rad and deg: convert one part"
            )
    return ""


def _too_small(recording: Recording, declared: list[str]) -> Iterator[str]:
    table = recording.table
    if "Fz" in table and "Fz" not in declared:
        largest = float(table["Fz"].abs().max())
        if 0.0 < largest < SMALLEST_LOAD:
            yield f"no |Fz| is above {largest:.4g} N: in kN? declare it: 'Fz [kN]' (or 'Fz [N]')"
    if "p" in table and "p" not in declared:
        median = float(table["p"].median())
        if 0.0 < median < SMALLEST_PRESSURE:
            guess = "bar" if median < LARGEST_BAR else "psi" if median < LARGEST_PSI else "kPa"
            yield f"p is about {median:.4g} Pa: in {guess}? declare it: 'p [{guess}]' (or 'p [Pa]')"


def _spinning_wheel(recording: Recording, declared: list[str]) -> Iterator[str]:
    """Report slips in percent within the limits of the channel: with them the wheel would turn backwards or spin."""
    if "kappa" not in recording.table or "kappa" in declared or "Fx" not in recording.table:
        return
    kappa = recording.table["kappa"].to_numpy(dtype=np.float64)[recording.table["Fx"].notna().to_numpy()]
    advice = "in percent? declare it: 'kappa [%]' (or 'kappa [1]')"
    backwards = float(np.mean(kappa < BACKWARD_SLIP)) if len(kappa) else 0.0
    far = float(np.mean(np.abs(kappa) >= FAR_SLIP)) if len(kappa) else 0.0
    if backwards > MAX_BACKWARD_ROWS:
        yield f"kappa is below -1 in {100.0 * backwards:.0f} % of the rows, a wheel that turns backwards: {advice}"
    if far > MAX_FAR_SLIPS:
        yield f"|kappa| is 2 or more in {100.0 * far:.0f} % of the rows, a wheel that spins: {advice}"


def _wrong_load_sign(recording: Recording) -> Iterator[str]:
    if "Fz" not in recording.table:
        return
    load = recording.table["Fz"].to_numpy(dtype=np.float64)
    expected = -1.0 if recording.signs == "sae" else 1.0
    share = float(np.mean(load * expected < 0.0))
    if share > MAX_WRONG_LOADS:
        sign, advice = (
            ("positive", "not SAE? (--signs iso or adapted-sae)")
            if recording.signs == "sae"
            else ("negative", "SAE signs? (--signs sae)")
        )
        yield f"Fz is {sign} in {100.0 * share:.0f} % of the rows: {advice}"
