"""Wheel kinematics for programs that know the motion of a wheel carrier: contact point, slip velocities, hub forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..boundary.errors import UnknownName
from ..symbolic.declarations import Quantity
from ..symbolic.wheel.quantities import (
    CARRIER,
    CONTACT_FORCES,
    CONTACT_POINT,
    GLOBAL_WRENCH,
    LOADED_RADIUS,
    MOTION,
    NORMAL,
    RADIUS_RATE,
    ROAD,
    ROTATION,
    SPIN,
    WRENCH,
)
from .code.modules import wheel_kinematics

#: Default values other than 0: the carrier's axes are the global axes, the road is level.
NEUTRAL = {"R_11": 1.0, "R_22": 1.0, "R_33": 1.0, "road_nz": 1.0}


def wheel_motion(**given: ArrayLike) -> dict[str, NDArray[Any]]:
    """Return the motion of a wheel at its contact point.

    - `**given`: position ``r_x`` to ``r_z`` of the wheel centre, m; orientation ``R_11`` to ``R_33`` of the carrier
      (columns are its axes in global axes); velocity ``v_x`` to ``v_z``, m/s, and angular velocity ``w_x`` to ``w_z``,
      rad/s, in global axes; spin ``omega`` of the wheel relative to the carrier, rad/s; height ``road_z`` of the road
      plane at r_x, r_y, its normal ``road_nx`` to ``road_nz``, and its velocity ``road_vx`` to ``road_vz``. What is
      absent is 0, without rotation, on a level road.

    Returns: ``V_x``, ``V_y`` (contact point relative to the road, W axes), ``wheel_speed``, ``psi_dot``, ``gamma``,
    ``R_l`` (loaded radius), ``R_l_rate``, ``c_x``, ``c_y``, ``c_z`` (contact point, global). Raises `UnknownName` if a
    name is none of these.

    Source: ISO 8855:2011; Pacejka, Tire and Vehicle Dynamics (2012), section 2.2.

    >>> motion = wheel_motion(r_z=0.3, v_x=10.0, omega=33.0)
    >>> float(motion["V_x"]), float(motion["R_l"]), float(motion["wheel_speed"])
    (10.0, 0.3, 33.0)
    """
    results = (*MOTION, LOADED_RADIUS, RADIUS_RATE, *CONTACT_POINT)
    return _call(wheel_kinematics.wheel_motion, (*CARRIER, *ROAD, SPIN), results, given)


def hub_wrench(**given: ArrayLike) -> dict[str, NDArray[Any]]:
    """Return forces and moments on a wheel at its centre from those at its contact point.

    `**given`: ``Fx``, ``Fy``, ``Fz``, N, ``Mx``, ``My``, ``Mz``, N m, in W axes; loaded radius ``R_l``, m; orientation
    ``R_11`` to ``R_33`` and normal ``road_nx`` to ``road_nz`` as in `wheel_motion`. The default is 0, without rotation,
    on a level road. Returns: ``F_x`` to ``M_z`` in carrier axes, and the same in global axes, such as ``F_x_global``.
    Raises `UnknownName` if a name is none of these.

    >>> float(hub_wrench(Fx=1000.0, R_l=0.3)["M_y"])
    -300.0
    """
    arguments = (*ROTATION, *NORMAL, LOADED_RADIUS, *CONTACT_FORCES)
    return _call(wheel_kinematics.hub_wrench, arguments, (*WRENCH, *GLOBAL_WRENCH), given)


def _call(
    function: Callable[..., tuple[Any, ...]],
    arguments: tuple[Quantity, ...],
    results: tuple[Quantity, ...],
    given: dict[str, ArrayLike],
) -> dict[str, NDArray[Any]]:
    """Call a generated function by names."""
    names = [argument.name for argument in arguments]
    for name in given:
        if name not in names:
            raise UnknownName("argument", name, names)
    values = [np.asarray(given.get(name, NEUTRAL.get(name, 0.0)), dtype=float) for name in names]
    computed = function(*values)
    return {result.name: np.asarray(value) for result, value in zip(results, computed, strict=True)}
