"""The channels of a recording: one declaration per column of the public contract."""

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
        The SI unit (deg C for T) and the physical quantity.
    role : str
        "input" (imposed by the bench) or "output" (response of the tire).
    bench_names : tuple of str
        Names in FSAE TTC files, the preferred one first.
    aliases : tuple of str
        Other common names. A message suggests the contract's name for them; they are never accepted silently.
    limits : tuple of float
        The plausible range in SI units, much wider than that of any bench.
    tolerance : float, optional
        Deviation of a held channel from its level, in SI units. None: proportional to the data (loads).
    """

    name: str
    meaning: str
    unit: str
    quantity: str
    role: str
    bench_names: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    limits: tuple[float, float] = (-inf, inf)
    tolerance: float | None = None


# Limits: slightly more than 90 deg for alpha and gamma, and 10 for kappa (-1 is a locked wheel, a spinning wheel of a
# slow vehicle reaches several). Values beyond them can only be in another unit.
# Tolerances: judgement, from the accuracy with which benches control a held channel; 0.5 deg for angles, 3 kPa for the
# pressure, 0.5 m/s for the speed, 2 K for the temperature.
_DECLARATIONS = (
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
CHANNELS: dict[str, Channel] = {declared.name: declared for declared in _DECLARATIONS}
INPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role == "input")
OUTPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role == "output")
#: The inputs that a bench controls. Time and temperature are not controlled.
CONTROLLED_INPUTS: tuple[str, ...] = tuple(name for name in INPUTS if name not in ("t", "T"))
# Bench names are case-sensitive: "ET" is the time, "Et" the curvature factor of the trail.
_BENCH_NAMES = {alias: declared.name for declared in _DECLARATIONS for alias in declared.bench_names}
_ALIASES = {
    alias.casefold(): declared.name for declared in _DECLARATIONS for alias in (declared.name, *declared.aliases)
}
_SUFFIXED = re.compile(r"(?P<name>\w+)[ _]?[ _(](?P<unit>[^()_]+)\)?")

_BRACKETED = re.compile(r"\s*(?P<name>\w+)\s*\[")


def channel(name: str) -> Channel:
    """Return the declaration of a channel.

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
    """Return the channel that the name of a column probably means, or None.

    Recognized are names in another case, bench names, aliases, names with a unit as suffix, and single typing errors in
    names of four letters or more. Named quantities of a tire (``alpha_y``) are not channels.

    Parameters
    ----------
    column : str
        Name of a column that the contract does not have.

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
    spelled = _BENCH_NAMES.get(column.strip()) or _ALIASES.get(re.sub(r"[ \-]+", "_", folded))
    if spelled is not None:
        return spelled
    if suffixed := unit_in_name(column):
        return suffixed[0]
    if (bracketed := _BRACKETED.match(folded)) and (spelled := _ALIASES.get(bracketed["name"])) is not None:
        return spelled
    return next((name for name in CHANNELS if len(name) >= 4 and _one_error_apart(folded, name)), None)


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
    name = written if written in CHANNELS else _BENCH_NAMES.get(written) or _ALIASES.get(written.casefold())
    try:
        quantity = unit_named(match["unit"]).quantity
    except UnknownName:
        return None
    # The unit has to match the quantity: "kappa_in" is an input, not a slip in inches.
    return (name, match["unit"]) if name is not None and quantity == CHANNELS[name].quantity else None


def _one_error_apart(written: str, name: str) -> bool:
    """Return whether one letter is wrong, missing or added, or two adjacent ones are swapped."""
    same = next((i for i, (a, b) in enumerate(zip(written, name, strict=False)) if a != b), None)
    if same is None:
        return abs(len(written) - len(name)) <= 1
    left, right = written[same:], name[same:]
    swapped = left[1::-1] + left[2:]
    return right in (left[1:], swapped) or left == right[1:] or left[1:] == right[1:]
