"""The start model fitted to a recording: from generic starts, several times, with weights by the noise found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d

from tirefmu.tires.tire import Tire

from .candidates import CENTER, CONTRACT, varies
from .disturbances import disturbances_of
from .least_squares import LeastSquares, Solution
from .signals import Signals
from .simulation import Simulator

FloatArray = npt.NDArray[np.float64]

#: Coefficients of the core, by the channels that they are read from.
CORE = {
    "Fx": ("PCX1", "PDX1", "PEX1", "PKX1"),
    "Fy": ("PCY1", "PDY1", "PEY1", "PKY1"),
    "Mz": ("QBZ1", "QCZ1", "QDZ1"),
}
#: Other starts of shape and curvature: a local optimum of the base looks like a missing effect.
STARTS = (
    {"PCX1": 1.6, "PEX1": 0.2, "PCY1": 1.4, "PEY1": -0.3, "QBZ1": 9.0, "QCZ1": 1.1},
    {"PCX1": 1.4, "PEX1": -1.0, "PCY1": 1.6, "PEY1": 0.3, "QBZ1": 6.0, "QCZ1": 1.3},
    {"PCX1": 1.8, "PEX1": 0.5, "PCY1": 1.25, "PEY1": -1.2, "QBZ1": 13.0, "QCZ1": 1.0},
)
#: Residuals beyond this many robust deviations of their neighbourhood are outliers.
OUTLIER = 7.0


def read_from(name: str) -> tuple[str, ...]:
    """Return the channels from which a coefficient can be read.

    Examples
    --------
    >>> read_from("PDY2"), read_from("RBX1"), read_from("SSZ1")
    (('Fy', 'Mz'), ('Fx',), ('Mz',))
    """
    special = {
        "SIGX": ("Fx",),
        "SIGY": ("Fy", "Mz"),
        "SIGC": ("Fy", "Mz"),
        "SIGK": ("Fx", "Fy", "Mz"),
        "PKX1": ("Fx", "Mz"),
    }
    if name in special:
        return special[name]
    if name[0] in "PR" and len(name) == 4:
        return {"X": ("Fx",), "Y": ("Fy", "Mz")}.get(name[2], ("Fx", "Fy", "Mz"))
    heads = {"QSX": ("Mx",), "PPMX": ("Mx",), "QSY": ("My",), "SSZ": ("Mz",), "PPZ": ("Mz",), "Q": ("Mz",)}
    return next((channels for head, channels in heads.items() if name.startswith(head)), ("Fx", "Fy", "Mz"))


def readable(names: tuple[str, ...], signals: Signals) -> tuple[str, ...]:
    """Return the coefficients that the measured channels say something about."""
    return tuple(name for name in names if set(read_from(name)) & set(signals.channels))


def base_coefficients(tire: Tire, signals: Signals) -> tuple[str, ...]:
    """Return the coefficients that a tire's own effects leave to fit.

    Parameters
    ----------
    tire : Tire
    signals : Signals

    Returns
    -------
    tuple of str
        In the order of the model.
    """
    free = {name for channel, names in CORE.items() if channel in signals.channels for name in names}
    if "Mz" in signals.channels:
        free |= set(CORE["Fy"])
        if "Fx" not in signals.channels and varies(signals, tire, "kappa"):
            free.add("PKX1")  # what kappa is worth as a slip angle of the trail
    book = tire.book
    cards = book.coefficients
    for effect in tire.has:
        if effect in CONTRACT:
            free |= set(CONTRACT[effect].shapes[0].free)
        elif effect in book.effects and effect != "relax_mf":
            free |= {name for name in book.owned(effect) if cards[name].neutral is not None}
    return tuple(name for name in cards if name in free and set(readable((name,), signals)))


def fit_base(tire: Tire, signals: Signals, *, known: bool) -> tuple[LeastSquares, Solution]:
    """Fit the start model.

    Parameters
    ----------
    tire : Tire
        Its effects; its values where ``known``, else only size and nominal values count.
    signals : Signals
    known : bool
        Whether the tire's values are a start (a fitted tire) rather than defaults.

    Returns
    -------
    LeastSquares
        With the weights found.
    Solution
    """
    free = base_coefficients(tire, signals)
    simulator = Simulator(tire, signals)
    learns = signals.present & ~signals.holdout
    noise = np.array([0.02 * np.std(row[there]) + 1e-9 for row, there in zip(signals.measured, learns, strict=True)])
    root = np.where(learns, 1.0 / noise[:, None], 0.0)
    center = CENTER | ({name: tire.values[name] for name in free} if known else {})
    problem = LeastSquares(simulator, root, disturbances_of(signals, noise), center)
    thin = slice(None, None, max(1, len(signals.rows) // 1500))
    tries = [problem.solve(start, free, rows=thin, iterations=25) for start in _starts(tire, signals, free, known)]
    best = problem.solve(min(tries, key=lambda solution: solution.cost).parameters, free, iterations=4)
    for _ in range(2):
        problem = weighed(problem, best)
        trial = problem.at(best.parameters, free).disturbance
        problem = replace(problem, disturbances=problem.disturbances.plausible(trial))
        best = problem.solve(best.parameters, free, iterations=8)
    return problem, best


def _starts(tire: Tire, signals: Signals, free: tuple[str, ...], known: bool) -> list[FloatArray]:
    simulator = Simulator(tire, signals)
    rescaled = simulator.rescaled
    own = tire.parameters()
    if known:
        return [own]
    inputs = signals.named()
    measured = dict(zip(signals.channels, signals.measured, strict=True))
    starts = []
    for shape in STARTS:
        values = {**CENTER, **shape}
        for channel, peak in (("Fx", "PDX1"), ("Fy", "PDY1")):
            if channel in measured:
                values[peak] = float(np.quantile(np.abs(measured[channel]) / inputs["Fz"], 0.98))
        for channel, stiffness, slip in (("Fx", "PKX1", "kappa"), ("Fy", "PKY1", "alpha")):
            if channel in measured:
                small = np.abs(inputs[slip]) < 0.03
                over = inputs[slip][small] * inputs["Fz"][small]
                slope = float(over @ measured[channel][small] / max(over @ over, 1e-12))
                values[stiffness] = min(max(slope, 5.0), 60.0) * 1.1
        if "PKY2" in free and "PKY1" in values:
            values["PKY1"] /= float(np.sin(2.0 * np.arctan(1.0 / values.get("PKY2", 2.0))))
        parameters = own.copy()
        for name, value in values.items():
            if name in free:
                parameters[simulator.place[name]] = value * rescaled.get(name, 1.0)
        starts.append(parameters)
    return starts


def weighed(problem: LeastSquares, solution: Solution) -> LeastSquares:
    """Return the problem with weights by the noise that a solution leaves, outliers out.

    Parameters
    ----------
    problem : LeastSquares
    solution : Solution

    Returns
    -------
    LeastSquares
        The noise of a channel has a constant and a proportional part, read from the short-range scatter.
    """
    signals = problem.simulator.signals
    simulated = signals.measured - solution.residual
    present = signals.present.copy()
    roots = np.zeros_like(problem.root)
    level = np.zeros(len(signals.channels))
    for i, residual in enumerate(solution.residual):
        there = signals.present[i]
        rest = np.where(there, residual - uniform_filter1d(residual, 15, mode="nearest"), 0.0)
        typical = 1.4826 * float(np.median(np.abs(rest[there]))) + 1e-12
        present[i] &= np.abs(rest) < OUTLIER * 2.0 * max(typical, 1e-12)
        constant, proportional = _two_parts(rest[present[i]], simulated[i][present[i]])
        deviation = np.sqrt(constant**2 + (proportional * simulated[i]) ** 2)
        level[i] = float(np.sqrt(np.mean(deviation**2)))
        roots[i] = np.where(present[i] & ~signals.holdout, 1.0 / deviation, 0.0)
    simulator = problem.simulator.over(replace(signals, present=present))
    return replace(problem, simulator=simulator, root=roots, disturbances=disturbances_of(signals, level))


def _two_parts(rest: FloatArray, force: FloatArray) -> tuple[float, float]:
    """Return the constant and the proportional deviation of noise."""
    order = np.argsort(np.abs(force))
    parts = np.array_split(order, 10)
    size = np.array([np.mean(force[part] ** 2) for part in parts])
    power = np.array([(1.4826 * np.median(np.abs(rest[part]))) ** 2 for part in parts])
    slope, level = np.polyfit(size, power, 1, w=1.0 / (power + 1e-12 + 0.1 * power.mean()))
    level = max(level, 0.1 * float(power.mean()), 1e-12)
    return float(np.sqrt(level)), float(np.sqrt(max(slope, 0.0)))
