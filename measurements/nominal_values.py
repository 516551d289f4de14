"""Nominal values that a user gives for a fit or a diagnosis, compared with the tables: a wrong unit is refused."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from ..boundary.errors import FitError, UnknownName
from ..symbolic.model import Model
from .checks.columns.radii import SIZE, radii
from .recording import Recording

#: Names of nominal values, and the coefficient that each sets.
NOMINAL = {"Fz0": "FNOMIN", "R0": "UNLOADED_RADIUS", "p0": "NOMPRES", "V0": "LONGVL"}
#: The channels of those that a table shows. Not V: a tire measured at walking speed may have any nominal speed.
MEASURED = {"Fz0": "Fz", "p0": "p"}
#: Largest ratio of a nominal value and the median of its channel, either way: about the geometric mean of 1 and 1000,
#: the ratio of N and kN, Pa and kPa, m and mm.
LARGEST_RATIO = 30.0
#: Largest ratio of the nominal load and the nearest tested load. Beyond it the coefficients of the load dependence,
#: which are polynomials about the nominal load, are an extrapolation. Judgement.
LARGEST_LOAD_DISTANCE = 3.0
#: Largest ratio of the nominal radius and a radius of the recording, either way: the loaded radius is up to 15 %
#: smaller, and a bench measures it to some percent. Judgement.
LARGEST_RADIUS_RATIO = 1.35
#: Largest ratio of the nominal radius and that of the size, either way, without a note. Judgement: the diameter in a
#: designation is rounded.
CLOSE_RADIUS_RATIO = 1.05


def rounded_median(values: pd.Series) -> float:
    """Return the median with the fewest digits, at least two, that leave it within the values; NaN if there are none.

    >>> rounded_median(pd.Series([220.0, 663.0, 1120.0])), rounded_median(pd.Series([11.1, 11.16, 11.29]))
    (660.0, 11.2)
    """
    median, low, high = float(values.median()), values.min(), values.max()
    rounded = (float(f"{median:.{digits}g}") for digits in range(2, 7))
    return next((value for value in rounded if low <= value <= high), median)


def check_radius(nominal: Mapping[str, float], recordings: Iterable[Recording]) -> list[str]:
    """Refuse a nominal radius that contradicts the loaded radius, the wheel speed or the size in a recording.

    `nominal`: R0 (m), if it is given. Returns a note on each recording whose size has another radius. Raises `FitError`
    with the radius of the recording if the ratio is beyond `LARGEST_RADIUS_RATIO`.

    >>> bench = Recording(pd.DataFrame({"Fz": [900.0]}), "iso", "run.mat", {"tireid": "Hoosier 16x7.5-10"})
    >>> check_radius({"R0": 0.41}, [bench])
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.FitError: nominal R0 = 0.41 m contradicts run.mat: 0.203 m by the size of its tire
    >>> check_radius({"R0": 0.23}, [bench])
    ['nominal R0 = 0.23 m differs by +13 % from run.mat: 0.203 m by the size of its tire']
    """
    value, notes = nominal.get("R0"), list[str]()
    if value is None:
        return notes
    for recording in recordings:
        for source, radius in radii(recording).items():
            shown, ratio = f"{recording.source}: {radius:.3g} m by the {source}", value / radius
            if not 1.0 / LARGEST_RADIUS_RATIO <= ratio <= LARGEST_RADIUS_RATIO:
                raise FitError(f"nominal R0 = {value:g} m contradicts {shown}")
            if source == SIZE and not 1.0 / CLOSE_RADIUS_RATIO <= ratio <= CLOSE_RADIUS_RATIO:
                notes.append(f"nominal R0 = {value:g} m differs by {100.0 * (ratio - 1.0):+.0f} % from {shown}")
    return notes


def check_nominal(nominal: Mapping[str, float], model: Model, tables: Iterable[pd.DataFrame]) -> None:
    """Refuse nominal values that are far outside the tables, or outside the bounds of the model where none shows them.

    `nominal`: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s). `model`: values that it does not have are not checked. `tables`: in
    SI units, in any sign convention. Raises `UnknownName` if there is no such nominal value. Raises `FitError` if a
    value is not positive, or far outside the tables.

    >>> from tirefmu.symbolic.models import model_named
    >>> check_nominal({"Fz0": 0.22, "R0": 0.23}, model_named("mf96"), [pd.DataFrame({"Fz": [220.0, 700.0, 1120.0]})])
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.FitError: nominal Fz0 = 0.22 N is far from the median of Fz, 700 N: in another unit?
    """
    tables = tuple(tables)
    for name, value in nominal.items():
        if name not in NOMINAL:
            raise UnknownName("nominal value", name, NOMINAL)
        if not value > 0.0:
            raise FitError(f"nominal {name} = {value:g} is not positive")
        coefficient = model.coefficients.get(NOMINAL[name])
        if coefficient is None or name == "V0":
            continue
        given = f"nominal {name} = {value:g} {coefficient.unit}"
        channel = MEASURED.get(name, "")
        measured = [table[channel].abs() for table in tables if channel in table]
        median = float(np.nanmedian(np.concatenate(measured))) if measured else 0.0
        if median > 0.0 and not 1.0 / LARGEST_RATIO < value / median < LARGEST_RATIO:
            near = f"{median:.3g} {coefficient.unit}"
            raise FitError(f"{given} is far from the median of {channel}, {near}: in another unit?")
        if channel == "Fz" and median > 0.0:
            low, high = np.nanquantile(np.concatenate(measured), [0.01, 0.99])
            if not low / LARGEST_LOAD_DISTANCE <= value <= high * LARGEST_LOAD_DISTANCE:
                raise FitError(f"{given} is far outside the tested loads, {low:.4g} to {high:.4g} N")
        if not median > 0.0 and not coefficient.lower <= value <= coefficient.upper:
            bounds = f"{coefficient.lower:g} .. {coefficient.upper:g} {coefficient.unit}"
            raise FitError(f"{given} is outside {bounds}: in another unit?")
