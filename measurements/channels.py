"""The channels of a recording: one card per column of the public contract."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import inf, radians

from tirefmu.symbolic.errors import UnknownName

from .units import unit_named


@dataclass(frozen=True)
class Channel:
    """One column of the contract.

    Parameters
    ----------
    name : str
        The contract's name.
    meaning : str
    unit, quantity : str
        The SI unit (deg C for T), and what it measures.
    role : str
        "input" (imposed by the bench) or "output" (answered by the tire).
    bench : tuple of str
        Names in FSAE TTC files, the preferred one first.
    words : tuple of str
        What people write instead: offered back in a message, never taken silently.
    limits : tuple of float
        The plausible range in SI, for the magnitude of a loaded wheel's channel; far wider than any bench.
    tolerance : float, optional
        How far from its level a held channel wanders, in SI. None: in proportion to the data (loads).
    """

    name: str
    meaning: str
    unit: str
    quantity: str
    role: str
    bench: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    limits: tuple[float, float] = (-inf, inf)
    tolerance: float | None = None


# Limits: alpha and gamma stop just above a quarter turn, kappa above ten (a locked wheel is -1, a spinning
# one on a crawling car reaches several), so that what lies outside can only be another unit.
_CARDS = (
    Channel("t", "time", "s", "time", "input", ("ET",), ("time",)),
    Channel(
        "kappa", "longitudinal slip (omega R_e - V_x)/|V_x|, a fraction", "-", "ratio", "input", ("SL",),
        ("slip", "slip_ratio", "longitudinal_slip"), (-10.5, 10.5), 0.01,
    ),
    Channel(
        "alpha", "slip angle", "rad", "angle", "input", ("SA",), ("slip_angle", "side_slip"), (-1.6, 1.6),
        radians(0.5),
    ),
    Channel(
        "gamma", "inclination (camber) angle", "rad", "angle", "input", ("IA",),
        ("camber", "camber_angle", "inclination", "inclination_angle"), (-1.6, 1.6), radians(0.5),
    ),
    Channel("Fz", "wheel load", "N", "force", "input", ("FZ",), ("load", "vertical_load"), (-1e6, 1e6)),
    Channel(
        "p", "inflation pressure, gauge", "Pa", "pressure", "input", ("P",),
        ("pressure", "inflation_pressure"), (0.0, 5e6), 3e3,
    ),
    Channel(
        "V", "speed of the wheel center", "m/s", "speed", "input", ("V",), ("speed",), (-150.0, 150.0),
        0.5,
    ),
    Channel(
        "T", "temperature at the tread's center", "deg C", "temperature", "input", ("TSTC",),
        ("temperature", "tread_temperature"), (-80.0, 250.0), 2.0,
    ),
    Channel("phit", "turn slip", "1/m", "curvature", "input", (), ("turn_slip",), tolerance=0.01),
    Channel("Fx", "longitudinal force", "N", "force", "output", ("FX",), ("longitudinal_force",)),
    Channel("Fy", "lateral force", "N", "force", "output", ("FY",), ("lateral_force", "side_force")),
    Channel("Mz", "aligning moment", "N m", "moment", "output", ("MZ",), ("aligning_torque",)),
    Channel("Mx", "overturning moment", "N m", "moment", "output", ("MX",), ("overturning_moment",)),
    Channel("My", "rolling resistance moment", "N m", "moment", "output", ("MY",), ("rolling_resistance",)),
)  # fmt: skip
CHANNELS: dict[str, Channel] = {card.name: card for card in _CARDS}
INPUTS: tuple[str, ...] = tuple(card.name for card in _CARDS if card.role == "input")
OUTPUTS: tuple[str, ...] = tuple(card.name for card in _CARDS if card.role == "output")
# Bench names count as written only: "ET" is a clock, "Et" the curvature factor of a trail.
_BENCH_NAMES = {alias: card.name for card in _CARDS for alias in card.bench}
_WORDS = {alias.casefold(): card.name for card in _CARDS for alias in (card.name, *card.words)}
_SUFFIXED = re.compile(r"(?P<name>\w+)[ _]?[ _(](?P<unit>[^()_]+)\)?")

_BRACKETED = re.compile(r"\s*(?P<name>\w+)\s*\[")


def channel(name: str) -> Channel:
    """Return the card of a channel.

    Parameters
    ----------
    name : str
        The contract's name.

    Returns
    -------
    Channel

    Raises
    ------
    UnknownName
        If the contract has no such column.

    Examples
    --------
    >>> channel("p").unit
    'Pa'
    """
    if name not in CHANNELS:
        raise UnknownName("channel", name, CHANNELS)
    return CHANNELS[name]


def intended_channel(column: str) -> str | None:
    """Return the channel that a column's name seems to mean, or None.

    Names in another case, bench names, plain words, names with a unit hung on, and single slips of
    the pen in names of four letters or more count; the named quantities of a tire (``alpha_y``) do not.

    Parameters
    ----------
    column : str
        A column's name that the contract does not have.

    Returns
    -------
    str or None

    Examples
    --------
    >>> [intended_channel(name) for name in ("Alpha", "SA", "gama", "alpha_deg", "Alpha [deg] raw")]
    ['alpha', 'alpha', 'gamma', 'alpha', 'alpha']
    >>> intended_channel("alpha_y") is None
    True
    """
    column = "".join(character for character in column if character.isprintable())
    folded = column.strip().casefold()
    spelled = _BENCH_NAMES.get(column.strip()) or _WORDS.get(re.sub(r"[ \-]+", "_", folded))
    if spelled is not None:
        return spelled
    if suffixed := unit_in_name(column):
        return suffixed[0]
    if (bracketed := _BRACKETED.match(folded)) and (spelled := _WORDS.get(bracketed["name"])) is not None:
        return spelled
    return next((name for name in CHANNELS if len(name) >= 4 and _one_slip_apart(folded, name)), None)


def unit_in_name(column: str) -> tuple[str, str] | None:
    """Return channel and unit of a name like ``alpha_deg`` or ``p (kPa)``, or None.

    Parameters
    ----------
    column : str

    Returns
    -------
    tuple of (str, str) or None

    Examples
    --------
    >>> unit_in_name("p_kPa"), unit_in_name("kappa_in")
    (('p', 'kPa'), None)
    """
    match = _SUFFIXED.fullmatch(column.strip())
    if match is None:
        return None
    written = match["name"]
    name = written if written in CHANNELS else _BENCH_NAMES.get(written) or _WORDS.get(written.casefold())
    try:
        quantity = unit_named(match["unit"]).quantity
    except UnknownName:
        return None
    # The unit has to fit: "kappa_in" is an input, not a slip in inches.
    return (name, match["unit"]) if name is not None and quantity == CHANNELS[name].quantity else None


def _one_slip_apart(written: str, name: str) -> bool:
    """One letter wrong, missing, too many, or two neighbors swapped."""
    same = next((i for i, (a, b) in enumerate(zip(written, name, strict=False)) if a != b), None)
    if same is None:
        return abs(len(written) - len(name)) <= 1
    left, right = written[same:], name[same:]
    swapped = left[1::-1] + left[2:]
    return right in (left[1:], swapped) or left == right[1:] or left[1:] == right[1:]
