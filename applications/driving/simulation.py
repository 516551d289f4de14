"""The simulated vehicle over the recorded steering and speed, in pieces of a few seconds, against the log.

The four tires are generated code, or FMUs. The longitudinal forces are those of the recorded motion: equal forces of
both wheels of an axle would lack a yaw moment where one is near its limit. The code has the states of effects (lagged
slips, heat) from the recorded motion; an FMU has states of its own, which begin with each piece.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...symbolic.vehicle.quantities import CORNERS
from ...tires import Tire
from ...tires.code.interface import all_plain
from ...tires.code.modules import numpy_routine, two_track
from ...tires.code.selection import fastest_code
from .effects import Motion, motion_of
from .estimate import Estimate
from .inputs.car import USUAL_WHEELBASE, Car, loads_of
from .inputs.grid import MEASURED, Grid
from .inputs.unknowns import AXLES, Unknowns
from .interval import BODY, OUTPUTS, SUSPENSION, relaxation_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

#: Length of a piece of a typical car, s; longest Heun step, s, and in the shorter time constant of lateral speed and
#: yaw rate.
HORIZON, MAX_STEP, MAX_SHARE = 2.0, 0.01, 0.5
#: What is simulated: its name and unit.
SIGNALS = {
    "yaw_rate": ("yaw rate", "rad/s"), "ay": ("lateral acceleration", "m/s^2"), "vy": ("lateral speed", "m/s"),
}  # fmt: skip
#: kappa, alpha, gamma, Fz, V and states of effects, shape (4, n) each, and the length of the step that follows with
#: these inputs, s (0: none); the answer is Fx and Fy, shape (2, 4, n).
TireForces = Callable[[Mapping[str, FloatArray], float], FloatArray]


@dataclass(frozen=True)
class VehicleSimulation:
    """Motion simulated from the estimated state at the start of each piece, NaN outside of pieces.

    `motion`, shape (n, 3): yaw rate, ay and lateral speed at the intervals. `rms`: of their errors, by name. `fmus`:
    whether the tires were FMUs.
    """

    motion: FloatArray
    rms: Mapping[str, float]
    fmus: bool = False


def horizon(car: Car) -> float:
    """Return the length of a piece, s: similar cars have periods in proportion to the root of their length."""
    return float(HORIZON * np.sqrt(car.values["wheelbase"] / USUAL_WHEELBASE))


def pieces_of(grid: Grid, car: Car) -> IntArray:
    """Return the first interval of each piece."""
    length = round(horizon(car) / grid.step)
    first = np.arange(0, len(grid.t) - length + 1, length)
    return np.asarray(first[grid.segment[first] == grid.segment[first + length - 1]], dtype=np.intp)


def simulated(
    grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car, tires: Mapping[str, Tire], *, z: FloatArray,
    fmus: bool = False,
) -> VehicleSimulation:  # fmt: skip
    """Simulate a car on its tires. `z`: deviations of the entries of the car. `fmus`: the tires are four FMUs."""
    motion = np.full((len(grid.t), 3), np.nan)
    if len(pieces_of(grid, car)):
        pieces = simulated_pieces(grid, estimate, unknowns, car, tires, z=z[:, None], fmus=fmus)
        motion[rows_of(grid, car)] = pieces[0]
    return VehicleSimulation(motion, errors_of(motion, grid, estimate, unknowns, car), fmus)


def rows_of(grid: Grid, car: Car) -> IntArray:
    """Return the intervals of each piece, shape (n_pieces, n)."""
    return pieces_of(grid, car)[:, None] + np.arange(round(horizon(car) / grid.step))


def simulated_pieces(
    grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car, tires: Mapping[str, Tire], *, z: FloatArray,
    factors: Mapping[str, Mapping[str, FloatArray]] | None = None, fmus: bool = False, memory: float = np.inf,
) -> FloatArray:  # fmt: skip
    """Return yaw rate, ay and lateral speed of cars, all simulated side by side, shape (n_cars, n_pieces, n, 3).

    `z`: deviations of the entries of one car, shape (n_z, 1), or of each car for each piece, shape (n_z, n_cars
    n_pieces). `factors`: likewise, by axle and name, on the factors of the tires. `memory`: time constant with which a
    car returns to the recorded motion, s.
    """
    n_cars = max(z.shape[1] // len(pieces_of(grid, car)), 1)
    rows = np.tile(rows_of(grid, car), (n_cars, 1))
    motion = np.empty((*rows.shape, 3))
    some = [unknowns.car_values(car, column) for column in z.T]
    p = {name: np.array([entries[name] for entries in some]) for name in some[0]}
    # Offset and delay of the steering are those of the log: all cars drive with them.
    offset = unknowns.car_values(car, estimate.z)["offset"]
    steer = grid.steer[:, rows] * (car.values["ratio"] / p["ratio"])[:, None] + offset
    speed = estimate.states[:, 0]
    kappa = _outputs(estimate, "kappa")[rows].repeat(2, axis=2)
    Fx = np.stack([_outputs(estimate, f"Fx_{side}")[rows] for side in ("left", "right")], axis=3).reshape(*kappa.shape)
    state = estimate.states[grid.left[rows[:, 0]], 1:3].T
    longest = min(MAX_STEP, MAX_SHARE * _shortest_time(some[0], tires, float(speed[grid.left[rows]].min())))
    substeps = int(np.ceil(grid.step / longest - 1e-9))
    h, returned = grid.step / substeps, -np.expm1(-grid.step / memory)
    past = {} if fmus else states_of(motion_of(grid, estimate, unknowns, car), tires)
    past = {name: values[:, rows] for name, values in past.items()}
    if "alpha" in past:
        past["alpha"] *= _stretch(p, tires, factors or {})[:, :, None]
    turning = estimated_motion(grid, estimate)[rows[:, 0], 1]
    vehicle = _Vehicle(p, h, turning + grid.behind[1, rows[:, 0]])
    with fmu_forces(tires, len(rows)) if fmus else nullcontext(code_forces(tires, factors or {})) as forces:
        for k in range(rows.shape[1]):
            at = rows[:, k]
            ends = speed[grid.left[at]], speed[grid.right[at]]
            held = {name: values[:, :, k] for name, values in past.items()}
            body = grid.behind[0, at], p["lift"] * grid.behind[16, at]
            given = kappa[:, k].T, Fx[:, k].T, held, (ends[1] - ends[0]) / grid.step, body, forces
            before = state
            for i in range(substeps):
                share = (i + 0.5) / substeps
                vx = ends[0] + share * (ends[1] - ends[0])
                angle = steer[0, :, k] + share * (steer[1, :, k] - steer[0, :, k])
                first = vehicle.rates(vx, state, angle, 0.0, *given)
                second = vehicle.rates(vx, state + h * first, angle, h, *given)
                state = state + h / 2 * (first + second)
                vehicle.advance(vx, state, second)
            mean = (before + state) / 2
            motion[:, k] = np.stack(
                [mean[1], (state[0] - before[0]) / grid.step + mean[1] * (ends[0] + ends[1]) / 2, mean[0]], axis=1
            )
            state = state + returned * (estimate.states[grid.right[at], 1:3].T - state)
    return motion.reshape(n_cars, -1, *motion.shape[1:])


def _outputs(estimate: Estimate, name: str) -> FloatArray:
    """Return one of `OUTPUTS` of both axles, shape (n, 2)."""
    return estimate.outputs[:, [OUTPUTS.index(f"{name}_{axle}") for axle in AXLES]]


def _shortest_time(p: Mapping[str, float], tires: Mapping[str, Tire], speed: float) -> float:
    """Return the shorter time constant of lateral speed and yaw rate on the cornering stiffness of the tires, s."""
    arms = p["cg_to_front"], p["cg_to_rear"]
    slopes = [
        tires[axle].forces(alpha=[-1e-3, 1e-3], Fz=load / 2, code="numpy")["Fy"]
        for axle, load in zip(AXLES, loads_of(p), strict=True)
    ]
    stiffness = [abs(float(Fy[1] - Fy[0])) / 1e-3 for Fy in slopes]  # of both wheels
    turning = sum(C * arm**2 for C, arm in zip(stiffness, arms, strict=True)) / p["yaw_inertia"]
    return speed / max(sum(stiffness) / p["mass"], turning)


def _stretch(
    p: Mapping[str, FloatArray], tires: Mapping[str, Tire], factors: Mapping[str, Mapping[str, FloatArray]]
) -> FloatArray:
    """Return the relaxation lengths of the wheels of vehicles over those of their tires, shape (4, 1) or (4, n)."""
    lengths = [
        p["relaxation"] * factors.get(axle, {}).get("LKY", 1.0) ** relaxation_of(tires[axle], "y").power
        for axle in AXLES
    ]
    return np.array(lengths).repeat(2, axis=0)


class _Vehicle:
    """Vehicles side by side, with the accelerations that act on their loads.

    `p`: entries of the car, shape (1,) or (n,) each; `rolled`, shape (n,): lateral acceleration behind the lag of roll.
    """

    def __init__(self, p: Mapping[str, FloatArray], step: float, rolled: FloatArray) -> None:
        self._body, self._suspension = [p[entry] for entry in BODY.values()], [p[entry] for entry in SUSPENSION]
        self._kept = np.exp(-step / np.maximum(p["roll_lag"], 1e-9))
        self._rolled, self._last = rolled, np.zeros((2, len(rolled)))

    def rates(
        self, vx: FloatArray, state: FloatArray, steer: FloatArray, step: float, kappa: FloatArray, Fx: FloatArray,
        held: Mapping[str, FloatArray], along: FloatArray, body: tuple[FloatArray, FloatArray], forces: TireForces,
    ) -> FloatArray:  # fmt: skip
        """Return the rates of lateral speed and yaw rate; loads follow from the last ones. `step`: see `TireForces`.

        `Fx`, shape (4, n): as the recorded motion requires, N. `held`: `states_of` the tires. `body`: what the lag of
        pitch adds to the longitudinal acceleration, and vertical acceleration.
        """
        motion = vx, *state, along, *self._last
        lag = body[0], self._rolled - (self._last[0] + vx * state[1])
        *turned, gamma = two_track.turned(*motion, *lag, steer, *self._suspension)
        wheels = two_track.wheels(*motion, *lag, body[1], *turned, *self._body)
        alpha, V, Fz = np.array(wheels).reshape(3, len(CORNERS), -1)
        gamma = np.broadcast_to(gamma, alpha.shape)
        inputs = {**held, "kappa": kappa, "alpha": alpha + held.get("alpha", 0.0), "gamma": gamma, "Fz": Fz, "V": V}
        _, Fy = forces(inputs, step)
        self._last = np.array(two_track.accelerations(vx, *state, *turned, *self._body, *Fx, *Fy)[1:])
        return self._last

    def advance(self, vx: FloatArray, state: FloatArray, rates: FloatArray) -> None:
        """Advance the lag of roll to the end of a step."""
        now = rates[0] + vx * state[1]
        self._rolled = now + (self._rolled - now) * self._kept


def states_of(motion: Motion, tires: Mapping[str, Tire]) -> dict[str, FloatArray]:
    """Return the states of effects over a recorded motion, and as "alpha" by how much the slip angle lags: (4, n)."""
    states: dict[str, FloatArray] = {}
    for i, (axle, wheels) in enumerate(zip(AXLES, motion.wheels, strict=True)):
        table = tires[axle].evaluate(pd.DataFrame({"t": motion.times, **wheels}), signs="iso")
        table = table.assign(distance=wheels["distance"])
        columns = {name: table[name] for name in (*tires[axle].symbolic_model.states, "distance") if name in table}
        if "alpha_lagged" in table:
            columns["alpha"] = table["alpha_lagged"] - table["alpha"]
        for name, column in columns.items():
            values = states.setdefault(name, np.zeros((len(CORNERS), len(motion.t))))
            values[2 * i : 2 * i + 2] = column.to_numpy().reshape(2, -1)
    return states


def estimated_motion(grid: Grid, estimate: Estimate) -> FloatArray:
    """Return yaw rate, ay and lateral speed of the center of gravity as estimated, shape (n, 3)."""
    middle = (estimate.states[grid.left] + estimate.states[grid.right]) / 2
    rate = (estimate.states[grid.right] - estimate.states[grid.left]) / grid.step
    return np.stack([middle[:, 2], rate[:, 1] + middle[:, 2] * middle[:, 0], middle[:, 1]], axis=1)


def errors_of(motion: FloatArray, grid: Grid, estimate: Estimate, unknowns: Unknowns, car: Car) -> dict[str, float]:
    """Return the rms of simulated minus estimated motion, and minus the measured yaw rate, its offset removed."""
    reference = estimated_motion(grid, estimate)
    yaw_rate = grid.means[MEASURED.index("yaw_rate")] - unknowns.car_values(car, estimate.z)["yaw_rate_offset"]
    reference[:, 0] = np.where(np.isfinite(yaw_rate), yaw_rate, reference[:, 0])
    squares = ((motion - reference) ** 2)[np.isfinite(motion[:, 0])]
    rms = np.sqrt(squares.mean(axis=0)) if len(squares) else np.full(3, np.nan)
    return dict(zip(SIGNALS, rms.tolist(), strict=True))


def changes(before: Mapping[str, float], after: Mapping[str, float], names: Iterable[str] = SIGNALS) -> str:
    """Return errors of signals before and after in words.

    >>> changes({"yaw_rate": 0.0123}, {"yaw_rate": 0.01}, ["yaw_rate"])
    'yaw rate 0.0123 -> 0.01 rad/s'
    """
    return ", ".join(
        f"{meaning} {before[name]:.3g} -> {after[name]:.3g} {unit}"
        for name, (meaning, unit) in SIGNALS.items()
        if name in names
    )


def code_forces(tires: Mapping[str, Tire], factors: Mapping[str, Mapping[str, FloatArray]]) -> TireForces:
    """Return the forces of the tires for given states, from their generated code; `factors`: see `simulated`."""
    given = {axle: tires[axle].parameters() for axle in AXLES}
    codes = {axle: fastest_code(tires[axle].symbolic_model) for axle in AXLES}
    parameters = {axle: list(values) for axle, values in given.items()}
    for axle in AXLES:
        for name, values in factors.get(axle, {}).items():
            place = list(tires[axle].symbolic_model.coefficients).index(name)
            parameters[axle][place] = parameters[axle][place] * np.tile(values, 2)

    def forces(inputs: Mapping[str, FloatArray], step: float) -> FloatArray:
        parts = []
        for i, (axle, tire) in enumerate(tires.items()):
            some = [inputs[name][2 * i : 2 * i + 2] if name in inputs else tire.nominal(name) for name in tire.inputs]
            rows = tire.effective_inputs(np.stack(np.broadcast_arrays(*some)).reshape(len(some), -1))
            if factors:  # the parameters of each car
                plain = all_plain(tire.symbolic_model, rows, given[axle])
                outputs = numpy_routine(tire.symbolic_model, "forces", plain=plain)(tuple(rows), parameters[axle])
                outputs = np.broadcast_arrays(rows[0], *outputs[:2])[1:]
            else:
                outputs = codes[axle].forces(rows, given[axle])[:2]
            parts.append(np.array(outputs).reshape(2, 2, -1))
        return np.concatenate(parts, axis=1)

    return forces


@contextmanager
def fmu_forces(tires: Mapping[str, Tire], n: int) -> Iterator[TireForces]:
    """Export the tires, and yield the forces of an FMU at each wheel of `n` vehicles."""
    from ...fmu.packaging.export import export  # imports FMPy, which is large
    from ...fmu.simulation.simulate import Coupled, instances

    with TemporaryDirectory(prefix="tirefmu-", ignore_cleanup_errors=True) as folder, ExitStack() as stack:
        axles = []
        for axle in AXLES:
            path = export(tires[axle], Path(folder) / f"{axle}.fmu")
            slaves = stack.enter_context(instances(path, 2 * n))
            read = [name for name in ("kappa", "alpha", "gamma", "Fz", "V") if name in tires[axle].inputs]
            axles.append(Coupled(slaves, read, ("Fx", "Fy")))

        def forces(inputs: Mapping[str, FloatArray], step: float) -> FloatArray:
            parts = []
            for i, coupled in enumerate(axles):
                rows = [inputs[name][2 * i : 2 * i + 2].ravel() for name in coupled.inputs]
                parts.append(coupled.exchange(np.stack(rows, axis=1), step).T.reshape(2, 2, n))
            return np.concatenate(parts, axis=1)

        yield forces
