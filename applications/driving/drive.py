"""From a log to an answer: the estimate of a drive, the tires that it implies, and the simulated vehicle."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...boundary.errors import DataError
from ...boundary.named_options import named
from ...numerics.one_thread import one_blas_thread
from ...tires import Tire, tire_from
from ...tires.description import limits_of
from ...tires.tire_argument import TireLike
from .effects import factor_values, motion_of, scaled
from .estimate import Estimate, estimated, restarted
from .factors import CERTAIN, believed, factors_of, scaled_tires, withheld
from .inputs.car import Car, read_car
from .inputs.grid import Grid, forward_speed, gridded, spinning, unwrapped
from .inputs.log import Log, LogLike, read_log
from .inputs.log_channels import POSE
from .inputs.plausibility import check_load_class, check_log, check_wheel_speeds, exchanged_axles
from .inputs.unknowns import Unknowns, check_factors, unknowns_of
from .interval import Interval, interval_of
from .result import Drive, wheel_table
from .rivals import (
    DriveExplanation,
    Rival,
    explaining,
    forces_of,
    nearby,
    probabilities_of,
    reestimated,
    rivals_of,
)
from .simulation import SIGNALS, changes, simulated
from .trust.contradiction import IMPROBABLE, contradiction_of
from .trust.left_out import left_out, parts_of, widened
from .verdict import disagreement, unexplained_axles, verdict_on

FloatArray = npt.NDArray[np.float64]


@named()
def drive(
    log: LogLike,
    *,
    vehicle: Car | str | Path,
    tire: TireLike,
    rear: TireLike | None = None,
    columns: dict[str, str] | None = None,
    fmus: bool = False,
) -> Drive:
    """Compare a drive with the tires of the car: forces of the axles, scaling factors, simulated motion.

    Parameters
    ----------
    log : pandas.DataFrame, str or path-like
        A log: channels ``t``, ``steer``, and ``speed``, ``yaw_rate``, ``ay`` or ``x``, ``y``, ``heading``; see
        `read_log`.
    vehicle : Car, str or Path
        The car, or its file (``tirefmu drive --example``).
    tire, rear : Tire, path or published name
        The tires of the front and of the rear axle; the rear tire is the front one by default. Their model needs the
        factors LMUY and LKY.
    columns : dict of str to str, optional
        Header of a channel that has another name in the log; beyond those of the car file.
    fmus : bool
        Whether the vehicle is simulated on four tire FMUs, whose states lag, in place of the generated code in steady
        state; `Drive.save` writes the FMUs of the scaled tires.

    Returns
    -------
    Drive
        The answer; it is one also where the drive determines nothing.

    Raises
    ------
    DataError
        If the log cannot be used, or contradicts the car: signs, units, no steering, no motion.
    TirefmuError
        If the car file is invalid, or a tire lacks a factor.

    References
    ----------
    Two-track model: Schramm, Hiller, Bardini, Vehicle Dynamics (2018), chapters 10 and 11.

    Examples
    --------
    >>> import pandas as pd
    >>> from tirefmu.applications.driving.inputs.car_entries import ENTRIES
    >>> body = {entry.name: entry.example for entry in ENTRIES.values() if entry.section == "body"}
    >>> t = [0.01 * i for i in range(1000)]
    >>> still = pd.DataFrame({"t": t, "steer": 0.0, "speed": 0.0, "yaw_rate": 0.0, "ay": 0.0})
    >>> drive(still, vehicle=Car.from_content({"body": body}, "car"), tire=Tire("mf61", {"FNOMIN": 4e3,
    ...       "UNLOADED_RADIUS": 0.3}))
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.DataError: log: the speed is 0 m/s or less: the car does not move forward
    """
    car = vehicle if isinstance(vehicle, Car) else read_car(vehicle)
    front = tire_from(tire).in_signs("iso")
    tires = {"front": front, "rear": front if rear is None else tire_from(rear).in_signs("iso")}
    check_factors(tires)
    check_load_class(car, tires)
    recorded = read_log(log, {**car.columns, **(columns or {})})
    check_wheel_speeds(recorded, car)
    speed = forward_speed(recorded, car)
    grid = gridded(recorded, car, speed)
    at_intervals = np.interp(grid.t, *speed)
    check_log(recorded, car, grid, at_intervals)
    if axles := exchanged_axles(grid, at_intervals, car):
        recorded = recorded.with_exchanged(axles)
        grid = gridded(recorded, car, speed)
    with one_blas_thread():
        return _answer(car, tires, recorded, grid, speed, fmus)


def _answer(
    car: Car, tires: dict[str, Tire], log: Log, grid: Grid, speed: tuple[FloatArray, FloatArray], fmus: bool
) -> Drive:
    unknowns = unknowns_of(car, log, tires)
    interval = interval_of(car, tires, unknowns, sampled=grid.sampled, spins=spinning(log, car), step=grid.step)
    start = _start(grid, interval.states, log, car, speed)
    try:
        given = interval, unknowns, start, log, car
        grid, estimate = estimated(grid, *given)
        if contradiction_of(estimate, unknowns).p < IMPROBABLE:
            grid, estimate = restarted(grid, *given, estimate)
    except np.linalg.LinAlgError:
        raise DataError(f"{log.source}: no motion of {car.source} on these tires explains the log") from None

    base = DriveExplanation(None, grid, estimate)

    def with_effect(rival: Rival) -> DriveExplanation | None:
        forces, near = forces_of(rival, unknowns, car, base), nearby(rival, base, unknowns)
        return _refitted(rival, lambda: estimated(grid, *given, forces, near))

    ranked, with_effects = reestimated(rivals_of(base, unknowns, car, tires), base, unknowns, with_effect)
    first = ranked[0].missing
    best = with_effects.get(first.name, base) if first and ranked[0].probability > CERTAIN else base
    context = base, ranked, unknowns, interval, car, tires, log, fmus
    answer = _concluded(best, *context) or _concluded(base, *context)
    assert answer
    return answer


def _concluded(
    answer: DriveExplanation, base: DriveExplanation, ranked: list[Rival], unknowns: Unknowns, interval: Interval,
    car: Car, tires: dict[str, Tire], log: Log, fmus: bool,
) -> Drive | None:  # fmt: skip
    """Return the answer that an explanation gives.

    None: it has an effect, and contradicts the car or does not predict better than `base`, the one without.
    """
    delivered = answer.missing.delivered(answer.estimate.z[len(unknowns) :]) if answer.missing else tires
    parts = parts_of(answer.grid, answer.estimate, unknowns, car)
    of_base = parts if answer is base else parts_of(base.grid, base.estimate, unknowns, car)
    wrong = probabilities_of(answer.grid, answer.estimate, unknowns).car
    wide = widened(answer.estimate, parts)
    contradiction = contradiction_of(wide, unknowns)
    if answer.missing and (not parts or not of_base or contradiction.certain):
        return None
    answer = replace(answer, estimate=wide)
    if contradiction.certain:
        explained = not unexplained_axles(wide)
        contradiction = replace(contradiction, unless=explaining(ranked), explained=explained)
    changed = probabilities_of(answer.grid, wide, unknowns).factors
    factors = factors_of(wide, unknowns, delivered, answer.grid.step, changed)
    new = scaled_tires(delivered, factors)
    common = answer.grid, answer.estimate, unknowns, car
    sound = answer.estimate.converged and not contradiction.doubtful
    differing = [(axle, name) for axle, row in factors.items() for name, factor in row.items() if factor.differs]
    predicted, certain = None, frozenset[tuple[str, str]]()
    if parts and of_base:
        predicted, certain, better = left_out(parts, of_base, tires, delivered, differing if sound else [])
        if answer.missing and not better:
            return None
    factors = believed(factors, certain)
    if contradiction.certain:
        factors = withheld(factors, "the drive contradicts the car file")
    elif not answer.estimate.converged:
        factors = withheld(factors, "the estimate did not converge")
    before = simulated(*common, tires, z=0.0 * answer.estimate.z, fmus=fmus)
    after = simulated(*common, new, z=answer.estimate.z, fmus=fmus)
    gap = _lacking(answer, unknowns, car, tires, (tires, new))
    where = disagreement(answer.grid, answer.estimate, gap[0], car)
    verdict = verdict_on(answer, ranked, unknowns, car, factors, certain, wrong, contradiction, predicted, where)
    further = [*_worse(before.rms, after.rms), *_limits(tires)] if sound and verdict.better else _limits(tires)
    verdict = replace(verdict, lines=(*verdict.lines, *further, *_exchanged(log)))
    deviations = answer.estimate.output_deviations(answer.grid, interval, len(unknowns))
    wheels = wheel_table(answer.grid, answer.estimate.outputs, deviations)
    return Drive(
        log, car, answer.grid, unknowns, answer.estimate, tires, new, factors, wheels, before, after, gap, verdict
    )


def _refitted(rival: Rival, refit: Callable[[], tuple[Grid, Estimate]]) -> DriveExplanation | None:
    """Return the estimate of the whole drive with an effect, or None if there is none."""
    try:
        explanation = DriveExplanation(rival.missing, *refit())
    except (np.linalg.LinAlgError, DataError):  # no motion, or one whose loads no tire has
        return None
    return explanation if explanation.estimate.converged else None


def _worse(before: Mapping[str, float], after: Mapping[str, float]) -> list[str]:
    """Return in which signals the simulated vehicle is worse on the new tires."""
    names = [name for name in SIGNALS if after[name] > before[name]]
    return [
        "the vehicle that is simulated without a return to the recorded motion is worse on the new tires (rms errors: "
        f"{changes(before, after, names)}): where a car slides, errors of its motion grow"
    ] * bool(names)


def _exchanged(log: Log) -> list[str]:
    """Return what was assumed of the sides of wheel speeds."""
    return [
        f"{' and '.join(log.exchanged)} axle: the logged left wheel is the faster one in left turns: left and right "
        "wheel speeds were exchanged (or steer, yaw rate and ay are positive to the right: --columns steer=-HEADER,...)"
    ] * bool(log.exchanged)


def _limits(tires: Mapping[str, Tire]) -> list[str]:
    """Return what the files of the tires do not know, with the axles."""
    axles: dict[str, list[str]] = {}
    for axle, tire in tires.items():
        for text in limits_of(tire):
            axles.setdefault(text, []).append(axle)
    return [f"{' and '.join(names)} tire file: {text}" for text, names in axles.items()]


def _lacking(
    best: DriveExplanation,
    unknowns: Unknowns,
    car: Car,
    tires: Mapping[str, Tire],
    compared: Iterable[Mapping[str, Tire]],
) -> FloatArray:
    """Return the side force of each axle that the motion requires beyond pairs of tires, shape (n_pairs, n, 2), N."""
    motion, factors = motion_of(best.grid, best.estimate, unknowns, car), factor_values(unknowns, best.estimate.z)
    if best.missing:
        whole = best.missing.on(best.estimate.z[len(unknowns) :], factors)
    else:
        whole = {axle: scaled(tire, factors[axle]) for axle, tire in tires.items()}
    required = motion.side_forces(whole) + best.estimate.beyond
    return np.stack([(required - motion.side_forces(pair)) * motion.loads for pair in compared])


def _start(grid: Grid, states: tuple[str, ...], log: Log, car: Car, speed: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return initial states of the nodes, shape (n_nodes, n_states): as logged, without lateral speed."""
    t = np.empty(grid.n_nodes)
    t[grid.left], t[grid.right] = grid.t - grid.step / 2, grid.t + grid.step / 2
    start = np.zeros((grid.n_nodes, len(states)))
    start[:, 0] = np.interp(t, *speed)
    if "yaw_rate" in log.channels:
        start[:, 2] = np.interp(t, *log.channels["yaw_rate"])
    if "heading" in states:
        channels = unwrapped(log)
        (x, x_rate), (y, y_rate), (heading, yaw_rate) = (_course(channels[name], t) for name in POSE)
        heading = heading - car.values["heading_offset"]
        start[:, 1] = y_rate * np.cos(heading) - x_rate * np.sin(heading) - yaw_rate * car.values["reference_x"]
        start[:, 2] = yaw_rate
        along, left = car.values["reference_x"], car.values["reference_y"]
        start[:, 3] = x - along * np.cos(heading) + left * np.sin(heading)
        start[:, 4] = y - along * np.sin(heading) - left * np.cos(heading)
        start[:, 5] = heading
    return start


def _course(samples: tuple[FloatArray, FloatArray], t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a channel and its smoothed rate at given times."""
    times, values = samples
    ahead, behind = np.interp(t + 0.1, times, values), np.interp(t - 0.1, times, values)
    return np.interp(t, times, values), (ahead - behind) / 0.2
