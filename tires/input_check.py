"""Inputs that no tire has in SI units and in its signs, or far beyond the loads of a tire: one check for all ways in.

Numbers, lists and arrays are treated alike. NaN is no error here: the forces there are NaN.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from ..boundary.errors import DataError, TirefmuError, TirefmuWarning, UnknownName, WrongType
from ..boundary.escaping import quoted
from ..symbolic.channels import CHANNELS
from .definition import TireDefinition
from .signs import TABLE_INPUTS, convert_signs

if TYPE_CHECKING:
    import pandas as pd

FloatArray = npt.NDArray[np.float64]

#: Pa. If the median pressure is smaller, it is not in Pa: a balloon tire has 1e4 Pa, and 250 psi is the number 250.
SMALLEST_PRESSURE = 2e3
#: Fraction of the rows. If more loads have the wrong sign, the sign convention is wrong: the majority decides.
MAX_WRONG_LOADS = 0.5
#: kappa of a wheel that turns backwards. A locked wheel has -1; the margin is for noise.
BACKWARD_SLIP = -1.05
#: Fraction of the rows. A bench that brakes to lock overshoots -1 in a few rows. One in percent does so in many, and
#: one up to 10 % is within the limits of the channel. Judgement.
MAX_BACKWARD_ROWS = 0.1
#: |kappa| of a wheel that turns at three times the speed of the road, or as fast backwards as the road moves.
FAR_SLIP = 2.0
#: Fraction of the values. If more slips are as far, they are probably in percent. Those of a wheel that spins may be:
#: they are evaluated, with a warning.
MAX_FAR_SLIPS = 0.5
#: The head of a column whose name declares a unit: ``alpha [deg]``, ``p (kPa)``, ``alpha_deg``.
_HEAD = re.compile(r"\s*(\w+?)\s*([\[(]|_(deg|degrees|percent|pct|kn|lbf|kpa|bar|psi|kmh|kph|mph)$)", re.IGNORECASE)
#: The inputs by their other names; bench names are case-sensitive, since "Et" is no time.
_BENCH_NAMES = {alias: name for name in TABLE_INPUTS for alias in CHANNELS[name].bench_names}
_ALIASES = {alias: name for name in TABLE_INPUTS for alias in (name.casefold(), *CHANNELS[name].aliases)}


class SignedTable(Protocol):
    """A table with its sign convention and origin: `tirefmu.measurements.Recording`."""

    @property
    def table(self) -> pd.DataFrame:
        """Columns of the public tables, SI."""

    @property
    def signs(self) -> str:
        """The sign convention of the table."""

    @property
    def source(self) -> str:
        """Where the table comes from."""

    @property
    def about(self) -> Mapping[str, str]:
        """Metadata; `declared` has the channels whose unit the file declares."""


#: Loads above this multiple of a tire's largest load are refused. Judgement: an impact reaches several times the static
#: load, and the polynomials of the load change the sign of the friction within this multiple.
FAR_LOAD = 5.0
#: The largest load of a tire without a stated range, as a multiple of its nominal load: the Trento tire has 220 N for
#: loads up to 1220 N.
NOMINAL_SHARE = 5.0


def load_limit(tire: TireDefinition) -> float:
    """Return the load above which a tire is not evaluated, N: five times FZMAX, 25 times FNOMIN if that is not stated.

    >>> from tirefmu.tires import published
    >>> load_limit(published("trento_hoosier"))
    6100.0
    """
    nominal = tire.values["FNOMIN"]
    _, highest = tire.ranges.get("Fz", (0.0, NOMINAL_SHARE * nominal))
    return FAR_LOAD * max(highest, nominal)


def possible_range(tire: TireDefinition, name: str) -> tuple[float, float]:
    """Return the possible values of an input in SI units; slip angles up to 180 deg, since a car may spin.

    >>> from tirefmu.tires import published
    >>> possible_range(published("trento_hoosier"), "Fz")
    (0.0, 6100.0)
    """
    if name not in CHANNELS:
        return -math.inf, math.inf
    wider = {"alpha": (-math.pi, math.pi), "Fz": (0.0, load_limit(tire)), "p": (SMALLEST_PRESSURE, math.inf)}
    return wider.get(name, CHANNELS[name].limits)


def checked_inputs(tire: TireDefinition, inputs: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return given inputs of `Tire.forces` as arrays.

    Raises `UnknownName` for an input that is none of the public tables, `WrongType` for one that is not numeric, and
    `TirefmuError` for values in another unit or sign, loads far beyond the range of the tire, and shapes that do not
    broadcast. Warns (`TirefmuWarning`) of slips that are probably in percent.

    >>> from tirefmu.tires import published
    >>> checked_inputs(published("trento_hoosier"), {"V": [10.0, 200.0]})
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.TirefmuError: V from 10 to 200 is outside -150 to 150: it is in m/s (in km/h? 36 km/h is 10)
    """
    arrays = {}
    for name, given in inputs.items():
        if name not in TABLE_INPUTS:
            raise UnknownName("input", name, TABLE_INPUTS)
        arrays[name] = _numbers(name, given)
        if problem := _problem(name, arrays[name]):
            raise TirefmuError(problem)
        _warn_of_percent(name, arrays[name])
    if problem := _far_load(tire, arrays.get("Fz")):
        raise TirefmuError(problem)
    try:
        np.broadcast_shapes(*(values.shape for values in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in arrays.items() if values.ndim)
        raise TirefmuError(f"the shapes of the inputs do not broadcast: {shapes}") from None
    return arrays


def checked_table(
    tire: TireDefinition, table: pd.DataFrame | SignedTable, signs: str | None, *, limited: bool = False
) -> tuple[pd.DataFrame, str]:
    """Return the rows of a DataFrame or a recording and their sign convention.

    `signs`: the convention of a DataFrame, "iso" if None. `limited`: whether the formula limits loads to the range of
    the tire, so that none is too far. As in a recording, some loads may have the wrong sign, since a sensor has noise
    around a lifted wheel; channels whose unit a file declares may have any value. Raises `DataError` if a column is in
    another unit or sign, has loads far beyond those of the tire, or `signs` contradicts the recording. Raises
    `WrongType` if it is neither.

    >>> import pandas as pd
    >>> from tirefmu.tires import published
    >>> checked_table(published("trento_hoosier"), pd.DataFrame({"Fz": [-900.0]}), "iso")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.DataError: table: Fz is negative in 100 % of the rows: signs='sae'?
    """
    import pandas as pd  # here, because every import of tirefmu imports this module

    if isinstance(table, pd.DataFrame):
        rows, written, declared, source = table, signs or "iso", [], "table"
    elif isinstance(getattr(table, "table", None), pd.DataFrame):
        rows, written, source = table.table, table.signs, table.source
        declared = table.about.get("declared", "").split()
        if signs not in (None, written):
            raise DataError(f"{source}: the recording is in {written} signs, not {signs} (with_signs converts it)")
    else:
        raise WrongType("table", table, "a DataFrame or a Recording (tirefmu.evaluate takes a path)")
    _check_headers(rows, source, {*tire.inputs, "t"})
    given = convert_signs(
        rows[[name for name, channel in CHANNELS.items() if channel.hint and name in rows]], written, "iso"
    )
    for name in map(str, given):
        values = _numbers(name, given[name])
        values = values[np.isfinite(values)]  # others are errors of their row
        problem = _wrong_load_signs(values, written) if name == "Fz" else ""
        if name not in declared:
            problem = problem or _problem(name, np.abs(values) if name == "Fz" else values)
            if not problem and (rows is table or "Fx" not in rows):  # with Fx, the reader judges the slips of a file
                _warn_of_percent(name, values)
        if name == "Fz" and not limited:
            problem = problem or _far_load(tire, values)
        if problem:
            raise DataError(f"{source}: {problem}")
    return rows, written


def _check_headers(rows: pd.DataFrame, source: str, read: Collection[str]) -> None:
    """Refuse a channel that occurs twice, and an input under another name or with a unit in it: it would be ignored."""
    for name in map(str, rows.columns[rows.columns.duplicated()]):
        if name in TABLE_INPUTS:
            raise DataError(f"{source}: column {name!r} occurs more than once")
    for column in map(str, rows.columns):
        if column in TABLE_INPUTS:
            continue
        head = _HEAD.match(column)
        written = head[1] if head else column
        other = _BENCH_NAMES.get(written) or _ALIASES.get(written.casefold().replace(" ", "_"))
        meant = written if written in TABLE_INPUTS else other
        if meant in read and meant not in rows:
            raise DataError(
                f"{source}: column {quoted(column)} is not {meant}: the columns are in SI units and have plain names "
                "(tirefmu.evaluate reads units of headers)"
            )


def _numbers(name: str, given: Any) -> FloatArray:
    """Return numbers as an array; masked ones are NaN. Texts, truth values and dates are no numbers."""
    try:
        if isinstance(given, np.ma.MaskedArray):
            given = np.ma.filled(given.astype(np.float64), np.nan)
        array = np.asarray(given)
        objects = array.flat if array.dtype.kind == "O" else ()
        if given is None or array.dtype.kind not in "iufO" or not all(map(_is_number, objects)):
            raise TypeError
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise WrongType(name, given, "a number or an array of numbers") from None


def _is_number(value: object) -> bool:
    return not isinstance(value, (str, bytes, bool, np.bool_))


def _problem(name: str, values: FloatArray) -> str:
    """Return a sentence if a value is outside the range of its input; empty otherwise."""
    (low, high), unit = CHANNELS[name].limits, CHANNELS[name].hint
    low = 0.0 if name == "Fz" else low  # a magnitude
    with np.errstate(invalid="ignore"):
        outside = bool(np.any((values < low) | (values > high)))
    if outside:
        return f"{name} {_extent(values)} is outside {low:g} to {high:g}: it is {unit}"
    if name == "p" and np.any(values > 0.0) and np.median(values[values > 0.0]) < SMALLEST_PRESSURE:
        return f"p {_extent(values)} is no pressure of a tire: it is {unit}"
    return ""


def _warn_of_percent(name: str, values: FloatArray) -> None:
    """Warn of slips of which most are those of a wheel that spins or turns backwards."""
    if name == "kappa" and values.size and np.mean(np.abs(values) >= FAR_SLIP) > MAX_FAR_SLIPS:
        sentence = f"kappa {_extent(values)} is that of a wheel that spins: it is {CHANNELS[name].hint}"
        warnings.warn(sentence, TirefmuWarning, stacklevel=4)


def _wrong_load_signs(values: FloatArray, signs: str) -> str:
    share = float(np.mean(values < 0.0)) if values.size else 0.0
    if share <= MAX_WRONG_LOADS:
        return ""
    sign, advice = ("positive", "not 'sae'?") if signs == "sae" else ("negative", "signs='sae'?")
    return f"Fz is {sign} in {100.0 * share:.0f} % of the rows: {advice}"


def _far_load(tire: TireDefinition, values: FloatArray | None) -> str:
    """Return a sentence if a load is far beyond those of the tire; empty otherwise."""
    limit = load_limit(tire)
    if values is None or not values.size or not np.any(values > limit):
        return ""
    stated = f"{FAR_LOAD:g} times FZMAX" if "Fz" in tire.ranges else f"{FAR_LOAD * NOMINAL_SHARE:g} times FNOMIN"
    return f"Fz {_extent(values)} N is far beyond the loads of this tire: the limit is {limit:g} N, {stated}"


def _extent(values: FloatArray) -> str:
    finite = values[~np.isnan(values)]
    low, high = float(finite.min()), float(finite.max())
    return f"= {low:g}" if low == high else f"from {low:g} to {high:g}"
