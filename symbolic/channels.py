"""The channels of a recording: one declaration per column of the public contract."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians

from ..boundary.errors import UnknownName

_ANGLE, _KELVIN = "in rad (in degrees? np.radians(5) is 5 deg)", "in K (20 deg C is 293.15)"


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
        The SI unit (deg C for T; "1" of a ratio) and the physical quantity; "absolute temperature" is in kelvin.
    role : str
        "controlled" (an input that the bench imposes), "input" (another one) or "output" (response of the tire).
    bench_names : tuple of str
        Names in FSAE TTC files, the preferred one first.
    bench_unit : str
        The unit in TTC files that declare none. Empty: that of the physical quantity there; a ratio has none in common.
    aliases : tuple of str
        Other common names. A message suggests the contract's name for them; they are never accepted silently.
    limits : tuple of float
        The plausible range in SI units, much wider than that of any bench; of a load its magnitude.
    tolerance : float, optional
        Deviation of a held channel from its level, in SI units. None: proportional to the data (loads).
    hint : str
        What a value beyond the limits must be, with an example.
    wrong_unit : tuple of str
        The probable unit of values beyond the limits, and words for it. Empty: unknown.
    reversed_in : tuple of str
        What changes its sign: sign conventions other than "iso", and "mirror" for the mirror in the wheel plane.
    typical : tuple of float, optional
        Range of a slider, in SI units, where neither the tire nor a recording has a range.
    stream : int
        Number of its random stream on the virtual bench. Never changed: a seed gives the same recording as before.
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
    hint: str = ""
    wrong_unit: tuple[str, str] = ("", "in another unit")
    reversed_in: tuple[str, ...] = ()
    typical: tuple[float, float] | None = None
    stream: int = 0
    bench_unit: str = ""

    @property
    def after(self) -> str:
        """The unit as written after a number: a blank and the SI unit; nothing for a ratio."""
        return "" if self.unit == "1" else f" {self.unit}"


# Limits: a wheel turns by at most 90 deg, and -1 is a locked wheel; a spinning wheel of a slow vehicle reaches several.
# Values beyond them can only be in another unit.
# Tolerances: judgement, from the accuracy with which benches control a held channel; 0.5 deg for angles, 3 kPa for the
# pressure, 0.5 m/s for the speed, 2 K for the temperature.
_DECLARATIONS = (
    Channel(
        "t", "time", "s", "time", "input", ("ET",), ("time", "elapsed_time", "timestamp"), typical=(0.0, 600.0),
        stream=0,
    ),
    Channel(
        "kappa", "longitudinal slip (omega R_e - V_x)/|V_x|, a fraction", "1", "ratio", "controlled", ("SL",),
        ("slip", "slip_ratio", "longitudinal_slip", "long_slip"), (-10.5, 10.5), 0.01,
        "a fraction (in percent? 10 % is 0.1)", ("%", "in percent"), (), (-0.3, 0.3), 1, "1",
    ),
    Channel(
        "alpha", "slip angle", "rad", "angle", "controlled", ("SA",),
        ("slip_angle", "side_slip", "lateral_slip", "alfa"), (-1.6, 1.6), radians(0.5),
        _ANGLE, ("deg", "in degrees"), ("sae", "mirror"), (-0.25, 0.25), 2,
    ),
    Channel(
        "gamma", "inclination (camber) angle", "rad", "angle", "controlled", ("IA",),
        ("camber", "camber_angle", "inclination", "inclination_angle"), (-1.6, 1.6), radians(0.5),
        _ANGLE, ("deg", "in degrees"), ("mirror",), (-0.15, 0.15), 3,
    ),
    Channel(
        "Fz", "wheel load", "N", "force", "controlled", ("FZ",),
        ("load", "vertical_load", "wheel_load", "normal_load", "vertical_force", "normal_force"), (-1e6, 1e6), None,
        "in N, positive where the wheel is pressed to the road (SAE? convert the signs)",
        reversed_in=("sae",), stream=4,
    ),
    Channel(
        "p", "inflation pressure, gauge", "Pa", "pressure", "controlled", ("P",),
        ("pressure", "inflation_pressure", "tire_pressure", "tyre_pressure"), (0.0, 5e6), 3e3,
        "in Pa (83 kPa is 83e3)", stream=5,
    ),
    Channel(
        "V", "speed of the wheel center", "m/s", "speed", "controlled", ("V",),
        ("speed", "velocity", "road_speed", "belt_speed"), (-150.0, 150.0), 0.5,
        "in m/s (in km/h? 36 km/h is 10)", ("km/h", "in km/h"), (), (0.0, 60.0), 6,
    ),
    Channel(
        "T", "temperature at the tread's center", "deg C", "temperature", "input", ("TSTC",),
        ("temperature", "tread_temperature", "tire_temperature", "tyre_temperature"), (-80.0, 250.0), 2.0,
        "in deg C (in kelvin? 300 K is 26.85)", ("K", "in kelvin"), typical=(0.0, 120.0), stream=7,
    ),
    Channel(
        "T_ambient", "temperature of the air around the tire", "K", "absolute temperature", "input", ("AMBTMP",),
        ("ambient_temperature", "air_temperature"), (200.0, 350.0), 2.0,
        _KELVIN, ("deg C", "in deg C"), typical=(253.15, 333.15), stream=14,
    ),
    Channel(
        "T_road", "temperature of the surface of the road", "K", "absolute temperature", "input", ("RST",),
        ("road_temperature", "road_surface_temperature", "track_temperature"), (200.0, 400.0), 2.0,
        _KELVIN, ("deg C", "in deg C"), typical=(253.15, 353.15), stream=15,
    ),
    Channel(
        "phit", "turn slip", "1/m", "curvature", "controlled", (), ("turn_slip",), tolerance=0.01,
        reversed_in=("mirror",), typical=(-0.2, 0.2), stream=8,
    ),
    Channel(
        "Fx", "longitudinal force", "N", "force", "output", ("FX",), ("longitudinal_force", "tractive_force"), stream=9
    ),
    Channel(
        "Fy", "lateral force", "N", "force", "output", ("FY",), ("lateral_force", "side_force"),
        reversed_in=("adapted-sae", "sae", "mirror"), stream=10,
    ),
    Channel(
        "Mz", "aligning moment", "N m", "moment", "output", ("MZ",), ("aligning_torque", "aligning_moment"),
        reversed_in=("adapted-sae", "sae", "mirror"), stream=11,
    ),
    Channel(
        "Mx", "overturning moment", "N m", "moment", "output", ("MX",), ("overturning_moment",),
        reversed_in=("mirror",), stream=12,
    ),
    Channel(
        "My", "rolling resistance moment", "N m", "moment", "output", ("MY",),
        ("rolling_resistance", "rolling_moment"), reversed_in=("adapted-sae", "sae"), stream=13,
    ),
)  # fmt: skip
CHANNELS: dict[str, Channel] = {declared.name: declared for declared in _DECLARATIONS}
INPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role != "output")
OUTPUTS: tuple[str, ...] = tuple(declared.name for declared in _DECLARATIONS if declared.role == "output")
#: The inputs that a bench controls. Time and temperatures are not controlled.
CONTROLLED_INPUTS: tuple[str, ...] = tuple(name for name in INPUTS if CHANNELS[name].role == "controlled")


def reversed_by(change: str) -> frozenset[str]:
    """Return the channels that a sign convention writes with the opposite sign of "iso", or that "mirror" reverses."""
    return frozenset(name for name, declared in CHANNELS.items() if change in declared.reversed_in)


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
