"""How often 95 % intervals contain the truth: noise alone, sensor errors, a memory, an effect that the model lacks.

    python benchmarks/coverage.py [--recordings N] [--seed SEED]

Each group has N recordings (10) of tires with random coefficients, at five loads and three camber angles. The truth of
a memory is the tire at its mean state over the recording. Coefficients are compared with those of the tire, and with a
static effect also with those of the fit to the recording without noise ("of the best fit"): the effect changes what
coefficients describe the tire. Intervals assume exact sensors in the groups that have them. It prints for each group
the share of intervals that contain the truth, and in how many recordings the verdict names a missing part.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fitting"))
from known_tires import LOADS, NOMINAL, SIZES, known_tire, moved

from tirefmu.fitting import FitResult, fit
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps
from tirefmu.measurements.virtual_bench.bench_errors import (
    CROSS_TALK_PRIOR_SHARE,
    MAX_CROSS_TALK,
    MAX_SKEW,
    SKEW_PRIOR_SHARE,
    cross_talk,
)
from tirefmu.measurements.virtual_bench.sensor_noise import ChannelNoise
from tirefmu.tires import Tire

FloatArray = npt.NDArray[np.float64]
CAMBERS = [radians(angle) for angle in (0, 2, 4)]
GROUPS = ("noise", "offsets", "sensor errors", "memory", "static effect")
SEEDS = dict(zip(GROUPS, (0, 1, 4, 2, 3), strict=True))
FORCES = ("Fx", "Fy", "Mz")


@dataclass(frozen=True)
class Made:
    """A recording and its truth.

    - `exact`: the recording without noise.
    - `factor`: of the forces over the load and the own slip, at the mean state of a memory.
    """

    tire: Tire
    recording: Recording
    exact: Recording
    factor: Callable[[FloatArray, FloatArray], FloatArray]


def made(group: str, seed: int) -> Made:
    """Return a recording of a group."""
    rng = np.random.default_rng([SEEDS[group], seed])
    tire = moved(known_tire("mf96"), 0.1, seed).in_signs("iso")
    lateral = alpha_sweeps(LOADS, CAMBERS, sample_rate=20.0)
    driven = kappa_sweeps(LOADS, [radians(angle) for angle in (0, 3, 6)], CAMBERS[::2], sample_rate=20.0)
    exact = VirtualBench(tire, Noise.none()).truth(concatenate([lateral, driven], signs="iso"))
    noise = Noise({name: _sensor(name, group) for name in sorted({*Noise().channels, *SIZES})})
    factor = _static(rng) if group == "static effect" else lambda load, slip: np.ones_like(load)
    load = exact["Fz"].to_numpy()
    scales = {name: factor(load, exact[slip].to_numpy()) for name, slip in (("Fx", "kappa"), ("Fy", "alpha"))}
    if group == "memory":
        state = _heat(exact, float(rng.uniform(20.0, 60.0)))
        scales = dict.fromkeys(FORCES, 1.0 - 0.04 * (state - state.mean()) / np.ptp(state))
    for name, scale in scales.items():
        exact[name] = exact[name] * scale
    t = exact["t"].to_numpy()
    if group == "sensor errors":
        late = {n: SKEW_PRIOR_SHARE * MAX_SKEW * rng.standard_normal() for n in exact.columns.drop("t")}
        exact = exact.assign(**{n: np.interp(t - delay, t, exact[n]) for n, delay in late.items()})
    recorded = {n: noise.record(n, exact[n].to_numpy(), t, rng) for n in exact.columns.drop("t")}
    if group == "sensor errors":
        forces = exact[list(FORCES)].to_numpy().T
        for pair, target, column in cross_talk(FORCES, forces, NOMINAL["R0"]):
            size = CROSS_TALK_PRIOR_SHARE * MAX_CROSS_TALK[pair] * rng.standard_normal()
            recorded[FORCES[target]] = recorded[FORCES[target]] + size * column
    name = f"{group} {seed}"
    return Made(tire, Recording(exact.assign(**recorded), "iso", name), Recording(exact, "iso", name), factor)


def _sensor(name: str, group: str) -> ChannelNoise:
    """Return the noise of a channel, with the offset and the drift of a bench in two groups."""
    bench = Noise().channels.get(name, ChannelNoise())
    offset = bench.offset if group in ("offsets", "sensor errors") else 0.0
    return ChannelNoise(SIZES.get(name, 0.0), offset=offset, drift=bench.drift if group == "sensor errors" else 0.0)


def _heat(table: pd.DataFrame, time: float) -> FloatArray:
    """Return a state that follows the power of sliding with a delay."""
    power = (table["Fy"] * np.tan(table["alpha"])).abs() + (table["Fx"] * table["kappa"]).abs()
    state, found = 0.0, []
    for step, drive in zip(np.diff(table["t"], prepend=0.0), power, strict=True):
        state += (1.0 - np.exp(-step / time)) * (drive - state)
        found.append(state)
    return np.array(found)


def _static(rng: np.random.Generator) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Return an effect that no coefficient describes: of one load, or of the sliding part of a curve."""
    size = rng.choice([-1.0, 1.0]) * rng.uniform(0.04, 0.1)
    if rng.uniform() < 0.5:
        load_at, width = rng.choice(LOADS[1:-1]), rng.uniform(300.0, 600.0)
        return lambda load, slip: 1.0 + size * np.exp(-(((load - load_at) / width) ** 2))
    return lambda load, slip: 1.0 + size * np.tanh((np.abs(slip) / 0.12) ** 2)


def covered(case: Made, result: FitResult) -> Iterator[tuple[str, float]]:
    """Yield names and shares of intervals that contain the truth."""
    rng = np.random.default_rng(0)
    for force, slip, largest in (("Fx", "kappa", 0.28), ("Fy", "alpha", 0.2), ("Mz", "alpha", 0.2)):
        columns = {"Fz": rng.uniform(410.0, 2790.0, 200), slip: rng.uniform(-largest, largest, 200)}
        table = pd.DataFrame({**columns, "gamma": rng.choice(CAMBERS, 200), "p": NOMINAL["p0"], "V": NOMINAL["V0"]})
        scale = case.factor(columns["Fz"], columns[slip]) if force != "Mz" else 1.0
        yield force, _inside(result, force, table, case.tire.evaluate(table)[force] * scale)
    table = pd.DataFrame({"Fz": LOADS, "p": NOMINAL["p0"], "V": NOMINAL["V0"]})
    for name, slip, largest in (("mu_x", "kappa", 0.28), ("mu_y", "alpha", 0.2)):
        swept = np.linspace(0.0, largest, 200)
        scale = [float(_curve(case, load, slip, swept).max()) for load in LOADS]
        plain = [
            float((_curve(replace(case, factor=lambda a, b: np.ones_like(a)), load, slip, swept)).max())
            for load in LOADS
        ]
        truth = case.tire.evaluate(table)[name] * np.array(scale) / np.array(plain)
        yield name, _inside(result, name, table, truth)
    for name in ("K_xkappa", "K_yalpha"):
        zero = case.factor(np.array(LOADS), np.zeros(len(LOADS)))
        yield name, _inside(result, name, table, case.tire.evaluate(table)[name] * zero)
    yield "coefficients", _coefficients_inside(result, case.tire)


def _coefficients_inside(result: FitResult, tire: Tire) -> float:
    held = [c for c in result.coefficients if np.isfinite(c.interval) and not c.at_bound]
    return float(np.mean([abs(c.value - tire.values[c.name]) <= c.interval for c in held]))


def _curve(case: Made, load: float, slip: str, swept: FloatArray) -> FloatArray:
    force = case.tire.evaluate(pd.DataFrame({slip: swept, "Fz": load}))["Fx" if slip == "kappa" else "Fy"]
    return np.abs(force.to_numpy()) * case.factor(np.full(len(swept), load), swept)


def _inside(result: FitResult, name: str, table: pd.DataFrame, truth: pd.Series) -> float:
    found = result.interval(name, table)
    return float(np.mean((found["lower"] <= truth) & (truth <= found["upper"])))


def main() -> None:
    """Print the coverage of each group."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recordings", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for group in GROUPS:
        shares: dict[str, list[float]] = {}
        named = 0
        for seed in range(arguments.seed, arguments.seed + arguments.recordings):
            case = made(group, seed)
            options = {"nominal": NOMINAL, "recipe": "joint", "sensor_errors": group in ("offsets", "sensor errors")}
            result = fit([case.recording], "mf96", **options)
            named += any("diagnose" in reason for reason in result.verdict.reasons)
            for name, share in covered(case, result):
                shares.setdefault(name, []).append(share)
            if group == "static effect":
                best = fit([case.exact], "mf96", **options).tire
                shares.setdefault("of the best fit", []).append(_coefficients_inside(result, best))
        texts = [f"{name} {100.0 * np.mean(values):.0f}" for name, values in shares.items()]
        print(f"{group}: {', '.join(texts)} %; a missing part named in {named}")


if __name__ == "__main__":
    main()
