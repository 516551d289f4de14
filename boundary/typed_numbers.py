"""Ranges of inputs in SI units, beyond which a number is in another unit."""

from __future__ import annotations

from collections.abc import Mapping

#: By input: lowest and highest value, and the unit with what to write instead. A wheel turns by at most 90 deg, and -1
#: is a locked wheel; a spinning wheel of a slow vehicle reaches several. The range of Fz is that of a pressed wheel.
RANGES: Mapping[str, tuple[float, float, str]] = {
    "kappa": (-10.5, 10.5, "a fraction (in percent? 10 % is 0.1)"),
    "alpha": (-1.6, 1.6, "in rad (in degrees? np.radians(5) is 5 deg)"),
    "gamma": (-1.6, 1.6, "in rad (in degrees? np.radians(5) is 5 deg)"),
    "Fz": (0.0, 1e6, "in N, positive where the wheel is pressed to the road (SAE? convert the signs)"),
    "p": (0.0, 5e6, "in Pa (83 kPa is 83e3)"),
    "V": (-150.0, 150.0, "in m/s (in km/h? 36 km/h is 10)"),
    "T": (-80.0, 250.0, "in deg C (in kelvin? 300 K is 26.85)"),
    "T_ambient": (200.0, 350.0, "in K (20 deg C is 293.15)"),
    "T_road": (200.0, 400.0, "in K (20 deg C is 293.15)"),
}
#: Pa. If the median pressure is smaller, it is not in Pa: a balloon tire has 1e4 Pa, and 250 psi is the number 250.
SMALLEST_PRESSURE = 2e3
#: Fraction of the rows. If more loads have the wrong sign, the sign convention is wrong: the majority decides.
MAX_WRONG_LOADS = 0.5
