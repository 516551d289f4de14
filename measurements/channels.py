"""The channels of a recording: one declaration per column of the public contract."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians

from ..boundary.errors import UnknownName
from ..boundary.typed_numbers import RANGES


@dataclass(frozen=True)
class Channel:
    """One column of the contract.

    Parameters
    ----------
    name : str
        The contract's name.
    meaning : str
        What is measured.
    unit, quantity : str
        The SI unit (deg C for T) and the physical quantity; "absolute temperature" is in kelvin.
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


# Limits: those of every input (`boundary.typed_numbers`), where a table may not have both signs of the load.
# Values beyond them can only be in another unit.
# Tolerances: judgement, from the accuracy with which benches control a held channel; 0.5 deg for angles, 3 kPa for the
# pressure, 0.5 m/s for the speed, 2 K for the temperature.
_DECLARATIONS = (
    Channel("t", "time", "s", "time", "input", ("ET",), ("time", "elapsed_time", "timestamp")),
    Channel(
        "kappa", "longitudinal slip (omega R_e - V_x)/|V_x|, a fraction", "-", "ratio", "input", ("SL",),
        ("slip", "slip_ratio", "longitudinal_slip", "long_slip"), RANGES["kappa"][:2], 0.01,
    ),
    Channel(
        "alpha", "slip angle", "rad", "angle", "input", ("SA",),
        ("slip_angle", "side_slip", "lateral_slip", "alfa"), RANGES["alpha"][:2], radians(0.5),
    ),
    Channel(
        "gamma", "inclination (camber) angle", "rad", "angle", "input", ("IA",),
        ("camber", "camber_angle", "inclination", "inclination_angle"), RANGES["gamma"][:2], radians(0.5),
    ),
    Channel(
        "Fz", "wheel load", "N", "force", "input", ("FZ",),
        ("load", "vertical_load", "wheel_load", "normal_load", "vertical_force", "normal_force"), (-1e6, 1e6),
    ),
    Channel(
        "p", "inflation pressure, gauge", "Pa", "pressure", "input", ("P",),
        ("pressure", "inflation_pressure", "tire_pressure", "tyre_pressure"), RANGES["p"][:2], 3e3,
    ),
    Channel(
        "V", "speed of the wheel center", "m/s", "speed", "input", ("V",),
        ("speed", "velocity", "road_speed", "belt_speed"), RANGES["V"][:2], 0.5,
    ),
    Channel(
        "T", "temperature at the tread's center", "deg C", "temperature", "input", ("TSTC",),
        ("temperature", "tread_temperature", "tire_temperature", "tyre_temperature"), RANGES["T"][:2], 2.0,
    ),
    Channel(
        "T_ambient", "temperature of the air around the tire", "K", "absolute temperature", "input", ("AMBTMP",),
        ("ambient_temperature", "air_temperature"), RANGES["T_ambient"][:2], 2.0,
    ),
    Channel(
        "T_road", "temperature of the surface of the road", "K", "absolute temperature", "input", ("RST",),
        ("road_temperature", "road_surface_temperature", "track_temperature"), RANGES["T_road"][:2], 2.0,
    ),
    Channel("phit", "turn slip", "1/m", "curvature", "input", (), ("turn_slip",), tolerance=0.01),
    Channel("Fx", "longitudinal force", "N", "force", "output", ("FX",), ("longitudinal_force", "tractive_force")),
    Channel("Fy", "lateral force", "N", "force", "output", ("FY",), ("lateral_force", "side_force")),
    Channel("Mz", "aligning moment", "N m", "moment", "output", ("MZ",), ("aligning_torque", "aligning_moment")),
    Channel("Mx", "overturning moment", "N m", "moment", "output", ("MX",), ("overturning_moment",)),
    Channel(
        "My", "rolling resistance moment", "N m", "moment", "output", ("MY",),
        ("rolling_resistance", "rolling_moment"),
    ),
)  # fmt: skip
CHANNELS: dict[str, Channel] = {declared.name: declared for declared in _DECLARATIONS}
INPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role == "input")
OUTPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role == "output")
#: The inputs that a bench controls. Time and temperatures are not controlled.
CONTROLLED_INPUTS: tuple[str, ...] = tuple(name for name in INPUTS if name not in ("t", "T", "T_ambient", "T_road"))


def channel(name: str) -> Channel:
    """Return the declaration of a channel.

    Parameters
    ----------
    name : str
        The contract's name.

    Returns
    -------
    Channel
        Its declaration.

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
