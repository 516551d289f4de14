"""One interval of the grid as a CasADi function: residuals of sensors and of the balance of forces, with derivatives.

The implicit midpoint rule joins the nodes: rates are differences over the interval, which are the exact means of the
rates, as the logged channels are means of samples. `evaluation.curved` adds what the curvature of the motion changes.
Residuals are divided by their standard deviations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ...symbolic.vehicle import quantities as vehicle
from ...symbolic.vehicle.quantities import CORNERS
from ...tires import Tire
from ...tires.code.casadi_code import ARRAYS, casadi_expression, compiled
from ...tires.code.modules import two_track
from .inputs.car import Car, loads_of
from .inputs.grid import MEASURED
from .inputs.log_channels import POSE
from .inputs.unknowns import ALONG, AXLES, FACTORS, Unknowns

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

MOTION = ("v_x", "v_y", "yaw_rate")
#: Residuals of the balance of forces, per static load.
BALANCE = ("e_front", "e_rear")
#: Further results of an interval for each axle: the inputs of a wheel that is the mean of both, its side force, W axes,
#: and that of the tire alone; longitudinal force of the left and of the right wheel. Fy is the tire's and half of what
#: the motion requires beyond it.
OUTPUTS = tuple(
    f"{name}_{axle}" for name in ("alpha", "Fy", "kappa", "V", "Fz", "Fy_tire", "Fx_left", "Fx_right") for axle in AXLES
)
#: Those whose standard deviations are computed: the first ones.
UNCERTAIN = OUTPUTS[: 2 * len(AXLES)]
#: Intervals that are evaluated at a time.
CHUNK = 100
#: How functions are compiled that each step of the states evaluates, and those of each step of the unknowns: to compile
#: these quickly is worth more. Those of an estimate alone are not compiled. Convention: computing time.
OFTEN, SELDOM = ("-O1",), ("-O0",)
#: Error of the integration of a pose, m/s and rad/s.
POSE_ERROR = 3e-3
#: Share of the mean load of an axle below which the load of a wheel changes smoothly to 0: a road cannot pull.
LIFTED = 0.02
#: Force per mass within which driving changes into braking, m/s^2.
COASTING = 0.2
#: Half the difference of the longitudinal forces of the wheels of an axle over their sum, error of a measured slip, and
#: slip within which a force is linear. Judgement: brakes of a car differ by 4 %, rolling radii by 0.2 %.
UNEQUAL, SLIP_NOISE, SMALL_SLIP = 0.02, 0.002, 0.01
#: Names of the arguments of `two_track` that describe the car, and the entries that they are.
BODY = {
    "m": "mass", "I_z": "yaw_inertia", "l_f": "cg_to_front", "l_r": "cg_to_rear", "w_f": "track_front",
    "w_r": "track_rear", "h": "cg_height", "roll_front": "front_roll_share", "drag": "drag",
    "down_f": "downforce_front", "down_r": "downforce_rear",
}  # fmt: skip


#: Entries that are the arguments of `two_track.turned` and `two_track.sensor`, and the rolling radii.
SUSPENSION = ("steer_front", "steer_rear", "camber")
SENSOR = ("x", "y", "roll_gradient", "misalignment")
RADII = ("radius_front", "radius_rear")


@dataclass(frozen=True)
class Relaxation:
    """Relaxation lengths of a tire: `lengths`, m, at `loads`, N, which grow with a power of the factor LKY, or LKX.

    A tire on a carcass of given stiffness has a length in proportion to its cornering stiffness.
    """

    loads: FloatArray
    lengths: FloatArray
    power: float

    def at(self, Fz: FloatArray) -> FloatArray:
        """Return the lengths at loads."""
        return np.asarray(np.interp(Fz, self.loads, self.lengths))


@dataclass(frozen=True)
class Chunk:
    """A function of `CHUNK` intervals.

    - `function`: of columns of left node, right node, data (`evaluation.interval_data`), and unknowns followed by the
      delay and the lags in the data. It gives values and their Jacobian by left node, right node, unknowns.
    - `depends`: the unknowns on which each of the first values depends, those with derivatives.
    """

    function: Any
    depends: tuple[IntArray, ...] = ()


@dataclass(frozen=True)
class Interval:
    """The function of an interval.

    - `states`: names of the states of a node.
    - `residuals`: names; those of `MEASURED` are first, `BALANCE` last.
    - `relaxations`: of the tire of each axle, in the directions "x" and "y".
    - `residual_chunk`, `output_chunk`: the residuals or `OUTPUTS`, with derivatives of residuals or `UNCERTAIN`.
    - `value_chunk`, `node_chunk`: the residuals alone, and with their derivatives by both nodes.
    - `volume_chunk`: of a further argument, a matrix for the Jacobian of the residuals by both nodes: their product
      minus the logarithm of the density that the balance gives the next motion, and its derivatives, the last two
      by the logarithms of the side forces of the tires of both axles.
    """

    states: tuple[str, ...]
    residuals: tuple[str, ...]
    relaxations: Mapping[tuple[str, str], Relaxation]
    value_chunk: Chunk
    node_chunk: Chunk
    residual_chunk: Chunk
    output_chunk: Chunk
    volume_chunk: Chunk


def interval_of(
    car: Car, tires: Mapping[str, Tire], unknowns: Unknowns, *, sampled: tuple[str, ...], spins: tuple[str, ...],
    step: float,
) -> Interval:  # fmt: skip
    """Return the function of the intervals of a drive.

    `sampled`: those of `MEASURED` that are logged. `spins`: the wheels whose spin is. `step`: s.
    """
    pose = "heading" in sampled
    states, n = MOTION + POSE * pose, len(MEASURED)
    left, right = ca.SX.sym("left", len(states)), ca.SX.sym("right", len(states))
    data, z = ca.SX.sym("data", 2 * n + 32), ca.SX.sym("z", len(unknowns))
    used = ca.SX.sym("used", 8)
    p = _entries(car, unknowns, z)
    middle, rate = ca.vertsplit((left + right) / 2), ca.vertsplit((right - left) / step)
    more = p["delay"] - used[0], p["lag"] - used[1]
    ends = [data[2 * n + i] + data[2 * n + 2 + i] * more[0] + data[2 * n + 4 + i] * more[1] for i in (0, 1)]
    scale = car.values["ratio"] / p["ratio"]
    steer, turning = p["offset"] + scale * (ends[0] + ends[1]) / 2, scale * (ends[1] - ends[0]) / step
    behind, motion = data[2 * n + 14 :], (*middle[:3], *rate[:3])
    lag = [behind[i] + (p[name] - used[3 + i]) * behind[2 + i] for i, name in enumerate(("pitch_lag", "roll_lag"))]
    heave = p["lift"] * (behind[16] + (p["heave_period"] - used[7]) * behind[17])
    *turned, gamma = two_track.turned(*motion, *lag, steer, *(p[name] for name in SUSPENSION), xp=ARRAYS)
    factors = {axle: {name: _factor(unknowns, axle, name, z) for name in FACTORS} for axle in AXLES}
    for axle, row in factors.items():
        row |= {name: row[lateral] * p[f"{entry}_{axle}"] for name, (lateral, entry) in ALONG.items()}
    slopes = [slip_stiffness(tires[axle]) * factors[axle]["LKX"] for axle in AXLES]
    relaxations = {(axle, direction): relaxation_of(tires[axle], direction) for axle in AXLES for direction in "xy"}
    stretch = [p["relaxation"] * factors[axle]["LKY"] ** relaxations[axle, "y"].power for axle in AXLES]
    wheels = _wheels(motion, [*lag, heave], turned, turning, p)
    wheels |= {f"gamma_{corner}": gamma for corner in CORNERS}
    for i, corner in enumerate(CORNERS):
        wheels[f"alpha_{corner}"] += behind[4 + i] + (stretch[i // 2] - used[5 + i // 2]) * behind[8 + i]
    pulls = _pulls(middle, rate, turned[0], car, p)
    slips = [[pull / (load * slope)] * 2 for pull, load, slope in zip(pulls, loads_of(p), slopes, strict=True)]
    late = {corner: p["wheel_delay"] * wheels[f"V_dot_{corner}"] for corner in CORNERS}
    scales = {axle: p[name] / car.values[name] if spins else 1.0 for axle, name in zip(AXLES, RADII, strict=True)}
    spun = data[2 * n + 6 : 2 * n + 10] + (p["wheel_delay"] - used[2]) * data[2 * n + 10 : 2 * n + 14]
    sides = [(1 + p[f"unequal_{axle}"] / 2, 1 - p[f"unequal_{axle}"] / 2) for axle in AXLES]
    rims = {corner: spun[i] * scales[AXLES[i // 2]] * sides[i // 2][i % 2] for i, corner in enumerate(CORNERS)}
    kappa = _kappa_of_spins(rims, wheels, spins) if spins else slips
    acting = [[kappa[i][side] + behind[12 + 2 * i + side] for side in (0, 1)] for i in (0, 1)]
    forces = {axle: _forces(tires[axle], axle, wheels, acting[i], factors[axle]) for i, axle in enumerate(AXLES)}
    body = [p[entry] for entry in BODY.values()]
    Fx = []
    for i, axle in enumerate(AXLES):
        stiffness = [slopes[i] * wheels[f"Fz_{axle[0]}{side}"] for side in "lr"]
        faster = (data[2 * n + 10 + 2 * i] - data[2 * n + 11 + 2 * i]) * scales[axle]
        spinning_up = -p["wheel_inertia"] * p["mass"] * faster / 2
        given = pulls[i], spinning_up, acting[i], forces[axle][0][:2], stiffness
        apart = _apart(*given) if len(spins) == len(CORNERS) else 0.0
        Fx += [pulls[i] / 2 + apart, pulls[i] / 2 - apart]
    share = ca.SX.sym("share", len(AXLES))
    order = [*Fx, *(share[i] * forces[axle][1][side] for i, axle in enumerate(AXLES) for side in (0, 1))]
    balance = dict(zip(_RESULTS, two_track.balance(*motion, *turned, *body, *order, xp=ARRAYS), strict=True))
    measured = _readings(p, middle, rate, lag, pose)
    for i, axle in enumerate(AXLES):
        mean = sum(wheels[f"V_{corner}"] - late[corner] for corner in (f"{axle[0]}l", f"{axle[0]}r")) / 2
        measured[f"rim_{axle}"] = mean * (1 + slips[i][0]) / scales[axle]
    parts = {name: (data[i] - measured[name]) * data[n + i] for i, name in enumerate(MEASURED) if name in sampled}
    parts |= _kinematics(middle, rate) if pose else {}
    parts |= {name: balance[name] / load for name, load in zip(BALANCE, loads_of(p), strict=True)}
    residual = ca.vertcat(*parts.values())
    required_forces = [balance[f"e_{axle}"] / ca.cos(turned[i]) / 2 for i, axle in enumerate(AXLES)]
    outputs = ca.vertcat(*_outputs(wheels, forces, kappa, required_forces), *Fx[::2], *Fx[1::2])
    arguments = [left, right, data, ca.vertcat(z, used)]

    def chunk(name: str, values: Any, by: Any = None, flags: tuple[str, ...] = (), more: tuple[Any, ...] = ()) -> Chunk:
        results = [values] if by is None else [values, ca.vec(by)]
        whole = [ca.substitute(ca.densify(result), share, 1.0) for result in results]
        function = ca.Function(name, [*arguments, *more], whole, {"cse": True})
        of_z = [] if by is None else ca.DM(by.sparsity(), 1.0).full()[:, 2 * len(states) :]
        depends = tuple(np.flatnonzero(row) for row in of_z)
        return Chunk((compiled(function, flags) if flags else function).map(CHUNK), depends)

    uncertain, everything = outputs[: len(UNCERTAIN)], ca.vertcat(left, right, z)
    by, by_nodes = ca.jacobian(residual, everything), ca.jacobian(residual, ca.vertcat(left, right))
    shares = ca.SX.sym("shares", by_nodes.numel())
    density = ca.log(ca.fabs(ca.det(ca.jacobian(residual[-len(BALANCE) :], right[1:3]))))
    volume = ca.dot(ca.vec(ca.densify(by_nodes)), shares) - density
    gradient = ca.gradient(volume, ca.vertcat(everything, share)).T
    chunks = (
        chunk("values", residual, flags=OFTEN),
        chunk("nodes", residual, by_nodes, OFTEN),
        chunk("residuals", residual, by, SELDOM),
        chunk("outputs", outputs, ca.jacobian(uncertain, everything)),
        chunk("volume", volume, gradient, SELDOM, (shares,)),
    )
    return Interval(states, tuple(parts), relaxations, *chunks)


_RESULTS = tuple(quantity.name for quantity in vehicle.BALANCE)


def _entries(car: Car, unknowns: Unknowns, z: Any) -> dict[str, Any]:
    """Return the entries of the car, those that are unknown as functions of z, and what follows from them."""
    p: dict[str, Any] = dict(car.values)
    for i, name in enumerate(unknowns.car):
        p[name] = unknowns.entry(i, z[i], ca.exp)
    p["cg_to_rear"] = p["wheelbase"] - p["cg_to_front"]
    return p


def _wheels(
    motion: tuple[Any, ...], moved: list[Any], turned: list[Any], turning: Any, p: Mapping[str, Any]
) -> dict[str, Any]:
    """Return slip angle, speed, its rate, and load of each wheel. `moved`: what lags and heave of the body add."""
    symbols = [ca.SX.sym(f"s{i}") for i in range(4)]
    body = [p[entry] for entry in BODY.values()]
    names = [f"{name}_{corner}" for name in ("alpha", "V", "Fz") for corner in CORNERS]
    wheels = dict(zip(names, two_track.wheels(*motion, *moved, *turned, *body, xp=ARRAYS), strict=True))
    of_symbols = two_track.wheels(*symbols[:3], *motion[3:], *moved, symbols[3], turned[1], *body, xp=ARRAYS)
    point, change = ca.vertcat(*motion[:3], turned[0]), ca.vertcat(*motion[3:], turning)
    by = ca.jacobian(ca.vertcat(*of_symbols[len(CORNERS) : 2 * len(CORNERS)]), ca.vertcat(*symbols))
    rates = ca.substitute(by, ca.vertcat(*symbols), point) @ change
    return wheels | {f"V_dot_{corner}": rates[i] for i, corner in enumerate(CORNERS)}


def relaxation_of(tire: Tire, direction: str) -> Relaxation:
    """Return the relaxation of a tire in a direction, "x" or "y": lengths of 0 for a tire without."""
    loads = tire.nominal("Fz") * np.linspace(0.1, 2.5, 25)
    quantity = tire.symbolic_model.quantity(f"relaxation_{direction}")
    if not tire.lags or not quantity:
        return Relaxation(loads, np.zeros_like(loads), 0.0)
    import pandas as pd

    rows, name, stiffer = pd.DataFrame({"kappa": 0.0, "alpha": 0.0, "Fz": loads}), f"LK{direction.upper()}", 1.1
    pair = tire, tire.with_values(**{name: stiffer * tire.values[name]})
    lengths, grown = (tire.evaluate(rows, steady=True)[quantity].to_numpy(np.float64) for tire in pair)
    power = np.log(np.sum(grown) / np.sum(lengths)) / np.log(stiffer) if lengths.any() else 0.0
    return Relaxation(loads, lengths, float(power))


def _forces(
    tire: Tire, axle: str, wheels: Mapping[str, Any], kappa: list[Any], factors: Mapping[str, Any]
) -> tuple[list[Any], list[Any], list[Any]]:
    """Return Fx and Fy of the left and of the right wheel, and of a wheel that is the mean of both."""
    model = tire.symbolic_model
    parameters = ca.SX(ca.DM(tire.parameters()))
    for name in factors.keys() & model.coefficients.keys():
        parameters[list(model.coefficients).index(name)] *= factors[name]
    results = []
    pair = [
        {"kappa": slip, **{name: wheels[f"{name}_{axle[0]}{side}"] for name in ("alpha", "V", "Fz", "gamma")}}
        for slip, side in zip(kappa, "lr", strict=True)
    ]
    mean = (pair[0]["Fz"] + pair[1]["Fz"]) / 2
    for wheel in pair:
        wheel["Fz"] = (wheel["Fz"] + ca.sqrt(wheel["Fz"] ** 2 + (LIFTED * mean) ** 2)) / 2
    for given in (*pair, {name: (pair[0][name] + pair[1][name]) / 2 for name in pair[0]}):
        inputs = ca.vertcat(*(given[name] if name in given else tire.nominal(name) for name in tire.inputs))
        results.append(casadi_expression(model, "forces", inputs, parameters, plain=True)[:2])
    return [result[0] for result in results], [result[1] for result in results], pair


def _readings(p: Mapping[str, Any], middle: list[Any], rate: list[Any], lag: list[Any], pose: bool) -> dict[str, Any]:
    """Return what the sensors measure."""
    motion = (*middle[:3], *rate[:3])
    ax, ay, _, _ = two_track.sensor(*motion, *lag, *(p[name] for name in SENSOR), xp=ARRAYS)
    delay = p["motion_delay"]
    late = [value - delay * slope for value, slope in zip(middle, rate, strict=True)]
    *_, vx, vy = two_track.sensor(*late[:3], *rate[:3], 0, 0, p["reference_x"], p["reference_y"], 0, 0, xp=ARRAYS)
    readings = {
        "yaw_rate": p["yaw_rate_gain"] * middle[2] + p["yaw_rate_offset"],
        "ax": ax + p["ax_offset"],
        "ay": p["ay_gain"] * ay + p["ay_offset"],
        "speed": vx,
        "beta": ca.atan(vy / vx) + p["heading_offset"],
        "vy": vy + vx * p["heading_offset"],
        "speed_rate": rate[0],
    }
    if pose:
        x, y, heading = late[3:]
        along, left = p["reference_x"], p["reference_y"]
        readings["x"] = x + along * ca.cos(heading) - left * ca.sin(heading)
        readings["y"] = y + along * ca.sin(heading) + left * ca.cos(heading)
        readings["heading"] = heading + p["heading_offset"]
    return readings


def _factor(unknowns: Unknowns, axle: str, name: str, z: Any) -> Any:
    i = unknowns.factor(axle, name)
    return ca.exp(unknowns.spread[i] * z[i])


def _pulls(middle: list[Any], rate: list[Any], steer: Any, car: Car, p: Mapping[str, Any]) -> list[Any]:
    """Return the longitudinal force of each axle: the driven axle drives, the brakes act on both."""
    # The side force of a steered axle has a component against the motion.
    cornering = (rate[1] + middle[0] * middle[2]) * p["cg_to_rear"] / p["wheelbase"] * ca.sin(steer)
    required = rate[0] - middle[1] * middle[2] + p["drag"] / p["mass"] * middle[0] ** 2 + cornering
    force = p["mass"] * required
    driving = {"front": 1.0, "rear": 0.0, "all": 0.5}[car.driven]
    share = p["brake_front"] + (driving - p["brake_front"]) * (1 + ca.tanh(required / COASTING)) / 2
    return [share * force, (1 - share) * force]


def _kappa_of_spins(rims: Mapping[str, Any], wheels: Mapping[str, Any], spins: tuple[str, ...]) -> list[list[Any]]:
    """Return the longitudinal slip of both wheels of each axle from the speed of rims (spin times rolling radius)."""
    slips = {corner: rims[corner] / wheels[f"V_{corner}"] - 1 for corner in spins}
    pairs = [(f"{axle[0]}l", f"{axle[0]}r") for axle in AXLES]
    # A wheel without a logged spin has the slip of the other one.
    return [[slips[a if a in spins else b] for a, b in (pair, pair[::-1])] for pair in pairs]


def _apart(pull: Any, unequal: Any, kappa: list[Any], Fx: list[Any], stiffness: list[Any]) -> Any:
    """Return half the difference of the longitudinal forces of the wheels of an axle, which add to a given one.

    Torques are equal (brakes, a differential), so that forces differ by `unequal`, half of what the inertia of the
    wheels takes; but a wheel near its limit cannot transmit its half. The tires say so at the measured slips, whose
    errors are independent. Both statements have the weights of their variances.
    """
    squares = [  # of the secants, which of a small slip are those of a linear tire
        (force**2 + (slope * SMALL_SLIP) ** 2) / (slip**2 + SMALL_SLIP**2)
        for force, slip, slope in zip(Fx, kappa, stiffness, strict=True)
    ]
    both = squares[0] + squares[1] + 1e-9
    difference = (Fx[0] - Fx[1] + (squares[0] - squares[1]) / both * (pull - Fx[0] - Fx[1])) / 2
    of_torques, of_slips = (UNEQUAL * pull) ** 2, squares[0] * squares[1] / both * SLIP_NOISE**2 + 1e-9
    return unequal + (difference - unequal) * of_torques / (of_torques + of_slips)


def slip_stiffness(tire: Tire) -> float:
    """Return the slope of Fx over kappa per load, at the nominal load."""
    ends = tire.forces(kappa=[-1e-3, 1e-3], Fz=tire.nominal("Fz"), code="numpy")["Fx"]
    return float(ends[1] - ends[0]) / 2e-3 / tire.nominal("Fz")


def _kinematics(middle: list[Any], rate: list[Any]) -> dict[str, Any]:
    vx, vy, yaw_rate, heading = (*middle[:3], middle[5])
    return {
        "x_rate": (rate[3] - vx * ca.cos(heading) + vy * ca.sin(heading)) / POSE_ERROR,
        "y_rate": (rate[4] - vx * ca.sin(heading) - vy * ca.cos(heading)) / POSE_ERROR,
        "heading_rate": (rate[5] - yaw_rate) / POSE_ERROR,
    }


def _outputs(
    wheels: Mapping[str, Any], forces: Mapping[str, Any], kappa: list[list[Any]], required: list[Any]
) -> list[Any]:
    means = {
        name: [(wheels[f"{name}_{axle[0]}l"] + wheels[f"{name}_{axle[0]}r"]) / 2 for axle in AXLES]
        for name in ("alpha", "V", "Fz")
    }
    Fy = [forces[axle][1][2] for axle in AXLES]
    whole = [Fy[i] + required[i] for i in (0, 1)]
    slips = [(left + right) / 2 for left, right in kappa]
    return [*means["alpha"], *whole, *slips, *means["V"], *means["Fz"], *Fy]
