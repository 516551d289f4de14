"""Predicted temperatures against recorded ones: measured recordings, and made ones of an independent generator.

    python benchmarks/temperature.py [FOLDER]

FOLDER has ``cornering.mat`` and ``drivebrake.mat``; without it only made recordings are computed. Printed are, for each
measured recording, the rms error over the last 30 % of the time after a fit to the rest, the error of the other
recording's coefficients, and the error of Fy with the predicted and with the recorded temperature; for the made
recordings, errors in units of the sensor's noise, how many intervals contain the truth, and what a diagnosis finds
without a recorded temperature of the tread; and the time of a simulated row and of a step of FMUs with and without
temperatures.
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu import FitResult, fit
from tirefmu.diagnosis import diagnose
from tirefmu.fitting.temperature.heat_balance import EFFECT, HeatBalance
from tirefmu.fitting.temperature.optimum import optimum_temperature
from tirefmu.fitting.temperature.temperature_fit import FITTED_SHARE, FREE, STARTS, fit_temperature, solved
from tirefmu.fmu.packaging.binaries import FLAGS
from tirefmu.measurements import Recording, recording_from
from tirefmu.tires import Tire
from tirefmu.tires.code.compiler import find_compiler

sys.path += [str(Path(__file__).parents[1] / "tests" / folder) for folder in ("fitting", "fmu")]
from programs import random_steps
from thermal_generator import recording

#: Effects of the forces of measured recordings.
EFFECTS = (
    "load_friction", "load_stiffness", "camber_thrust", "camber_friction", "camber_stiffness", "pressure_friction",
    "pressure_stiffness", "plysteer", "conicity", "temp_friction", "temp_stiffness",
)  # fmt: skip
#: Duration, s, from whose temperatures the starts of the other recording are estimated.
START = 60.0
MADE, NOISE, DURATION = 30, 0.3, 300.0
#: Largest friction, deg C, and its curvature, 1/K^2, of made recordings.
OPTIMUM = {"inside": 55.0, "above": 140.0, "none": 60.0}
CURVATURE = {"inside": 2e-4, "above": 2e-5, "none": 0.0}
NOMINAL = {"Fz0": 1500.0, "R0": 0.25}
#: Diagnosed recordings, and the curvature of friction about 30 deg C in them, 1/K^2.
DIAGNOSED, DIAGNOSED_CURVATURE = 10, 1e-4
#: Recordings of the model itself, and the standard deviation of the logarithms of their coefficients.
OWN, DRAWN = 20, 0.4
#: Groups of load of which one is left out; steps of FMUs.
LOADS, STEPS = 4, 100_000


def rms(values: pd.Series | np.ndarray) -> float:
    """Return the root of the mean square of finite values."""
    values = np.asarray(values, dtype=np.float64)
    return float(np.sqrt(np.nanmean(values**2)))


def from_other(tire: Tire, warm: Tire, measured: Recording) -> float:
    """Return the error over a recording with the thermal coefficients of another tire, K."""
    values = {name: warm.values[name] for name in FREE}
    balance = HeatBalance.of(replace(tire, effects={*tire.has, EFFECT}).with_values(**values), measured, "T")
    known = np.isfinite(balance.measured)
    started = solved([balance], [known & (balance.t < balance.t[0] + START)], ())
    return rms(started.errors([balance])[0])


def forces(measured: Recording) -> tuple[float, float]:
    """Return the error of Fy over the last part of the time with the recorded and with the predicted temperature, N."""
    table = measured.table
    early = table["t"] <= table["t"].iloc[0] + FITTED_SHARE * (table["t"].iloc[-1] - table["t"].iloc[0])
    result = fit(replace(measured, table=table[early]), "mf61", effects=[*EFFECTS, EFFECT])
    predicted = result.tire.evaluate(table, signs=measured.signs)
    recorded = result.tire.with_values(THACT=0.0).evaluate(table, signs=measured.signs, steady=True)
    return tuple(rms((one["Fy"] - table["Fy"])[~early]) for one in (recorded, predicted))


def measured_recordings(folder: Path) -> None:
    """Print the errors of the measured recordings."""
    recordings = {name: recording_from(folder / f"{name}.mat") for name in ("cornering", "drivebrake")}
    tires, warm = {}, {}
    for name, measured in recordings.items():
        tires[name] = fit(measured, "mf61").tire
        began = time.perf_counter()
        warm[name], found = fit_temperature(tires[name], [measured])
        seconds = time.perf_counter() - began
        print(f"{name}: {found.text()}; {seconds:.0f} s", flush=True)
        print(
            "  "
            + ", ".join(f"{key} {value:.3g} (x/ {found.intervals[key]:.2f})" for key, value in found.values.items())
        )
    for name, other in (("cornering", "drivebrake"), ("drivebrake", "cornering")):
        error = from_other(tires[other], warm[name], recordings[other])
        print(f"coefficients of {name} over {other}: rms {error:.2f} K", flush=True)
    for name, measured in recordings.items():
        errors = ", ".join(f"{error:.2f}" for error in without_a_load(warm[name], measured))
        print(f"{name}, a quarter of the loads left out: rms {errors} K", flush=True)
    recorded, predicted = forces(recordings["cornering"])
    print(
        f"cornering, last {1 - FITTED_SHARE:.0%}: Fy rms {recorded:.1f} N with T recorded, {predicted:.1f} N predicted"
    )


def without_a_load(warm: Tire, measured: Recording) -> list[float]:
    """Return the error over the rows of each load after a fit without them, K."""
    balance = HeatBalance.of(warm, measured, "T")
    known = np.isfinite(balance.measured)
    load = balance.inputs[warm.inputs.index("Fz")]
    at = np.digitize(load, np.quantile(load[known], np.arange(1, LOADS) / LOADS))
    whole, errors = solved([balance], [known], FREE), []
    for group in range(LOADS):
        left_out = known & (at == group)
        errors.append(rms(solved([balance], [known & ~left_out], FREE, whole).errors([balance])[0][left_out]))
    return errors


def made_recordings() -> None:
    """Print the errors of made recordings, and the temperature of the largest friction.

    A third has friction with a maximum within the recorded range, a third one far above it, a third none.
    """
    all_rows, held_out = [], []
    for seed in range(MADE):
        kind = ("inside", "above", "none")[seed % 3]
        table, result = made(seed, kind, [EFFECT])
        surface = result.tire.evaluate(table)["T_surface"] - 273.15
        shown = np.interp(table["t"] - result.temperature.delay[0], table["t"], surface)
        all_rows.append(rms(shown - table["T"]) / NOISE)
        held_out.append(result.temperature.holdout_rmse / NOISE)
        answer = result.temperature.optimum
        inside = f", contained: {abs(answer.value - OPTIMUM[kind]) <= answer.half}" if answer.determined else ""
        print(
            f"made {seed}, {kind}: {all_rows[-1]:.2f} of the noise, {held_out[-1]:.2f} held out;"
            f" {answer.text()}{inside}",
            flush=True,
        )
    for what, ratios in (("over all rows", all_rows), ("held out", held_out)):
        within = sum(ratio <= 1.5 for ratio in ratios)
        print(
            f"{what}: median {np.median(ratios):.2f}, largest {max(ratios):.2f}, {within} of {MADE} within 1.5 times "
            "the noise"
        )


def made(seed: int, kind: str, effects: list[str]) -> tuple[pd.DataFrame, FitResult]:
    """Return a made recording and the fit to it."""
    table = recording(seed, noise=NOISE, duration=DURATION, friction=CURVATURE[kind], optimum=OPTIMUM[kind])
    effects = ["load_friction", "load_stiffness", "temp_friction", *effects]
    return table, fit(table, "mf96", effects=effects, nominal=NOMINAL)


def without_influence() -> None:
    """Print in how many of further recordings without an influence an optimum is determined."""
    named = 0
    for seed in range(100, 100 + MADE):
        table, result = made(seed, "none", [])
        named += optimum_temperature(result.tire, [Recording(table, "iso", "made")]).determined
    print(f"without an influence: an optimum in {named} of {MADE}", flush=True)


def emissivity() -> None:
    """Print the errors of the same made recording with sensors of two emissivities."""
    table, result = made(0, "none", [])
    table = recording(0, noise=0.0, duration=DURATION)
    noise, ambient = np.random.default_rng(0).normal(0.0, NOISE, len(table)), table["T_ambient"] - 273.15
    for factor in (1.0, 0.9):
        shown = Recording(table.assign(T=ambient + factor * (table["T"] - ambient) + noise), "iso", "made")
        found = fit_temperature(result.tire, [shown])[1]
        print(f"emissivity {factor}: rms {found.rmse:.4f} K, {found.holdout_rmse:.4f} K held out", flush=True)


def diagnosed() -> None:
    """Print what a diagnosis finds in made recordings without a temperature of the tread."""
    for what, influence in (("with", DIAGNOSED_CURVATURE), ("without", 0.0)):
        found = []
        for seed in range(200, 200 + DIAGNOSED):
            table = recording(seed, noise=NOISE, duration=180.0, friction=influence, optimum=30.0)
            answer = diagnose(table.drop(columns="T"), model="mf96", effects=["load_friction", "load_stiffness"],
                              nominal=NOMINAL)  # fmt: skip
            found.append(" + ".join(sorted(one.effect for one in answer.found)) or "nothing")
        counts = ", ".join(f"{name} {found.count(name)}" for name in sorted(set(found), key=found.count, reverse=True))
        print(f"diagnosis of {DIAGNOSED} recordings {what} an influence of the temperature: {counts}", flush=True)


def coverage() -> None:
    """Print how many intervals contain the true coefficients, in recordings of the model itself."""
    contained = []
    for seed in range(OWN):
        random = np.random.default_rng(seed)
        truth = Tire("mf96", {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25}, effects={EFFECT})
        neutral = {name: truth.values[name] for name in FREE}
        values = {name: value * np.exp(random.normal(0.0, DRAWN)) for name, value in neutral.items()}
        truth = truth.with_values(**values, **{name: random.normal(308.0, 2.0) for name in STARTS})
        table = truth.evaluate(recording(seed, duration=DURATION).drop(columns=["T", "Fx", "Fy"]))
        shown = np.interp(table["t"] - 0.1, table["t"], table["T_surface"])
        table = table.assign(T=shown - 273.15 + random.normal(0.0, NOISE, len(table)))
        _, found = fit_temperature(truth, [Recording(table, "iso", "own")])
        contained += [abs(np.log(found.values[name] / values[name])) <= np.log(found.intervals[name])
                      for name in FREE]  # fmt: skip
    print(f"intervals contain the truth in {np.mean(contained):.1%} of {len(contained)}", flush=True)


def cost() -> None:
    """Print the time of a simulated row with and without temperatures, and the same of a step of FMUs."""
    t = np.arange(0.0, 60.0, 0.005)
    table = pd.DataFrame({"t": t, "alpha": 0.1 * np.sin(t), "kappa": 0.05 * np.sin(1.3 * t), "Fz": 1500.0, "V": 15.0})
    values = {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "TMU1": -0.002, "SIGX": 0.1, "SIGY": 0.3}
    plain = Tire("mf61", values, effects={"temp_friction", "relax_lat", "relax_lon"})
    heated = Tire("mf61", {**values, "THACT": 1.0}, effects={*plain.has, EFFECT})
    seconds = []
    for tire in (plain, heated):
        tire.evaluate(table, hold=True)
        began = time.process_time()
        tire.evaluate(table, hold=True)
        seconds.append(1e6 * (time.process_time() - began) / len(t))
    print(f"a row: {seconds[0]:.1f} us without, {seconds[1]:.1f} us with temperatures")
    for inputs in ("slip", "hub", "hub-torque"):
        medians = []
        for tire in (plain, heated):
            with tempfile.TemporaryDirectory() as folder:
                program = (find_compiler(), Path(folder), tire.in_signs("iso"), inputs, STEPS, "-O2", *FLAGS)
                medians.append(random_steps(*program)["median"])
        print(f"a step with {inputs} inputs: {medians[0]:.1f} us without, {medians[1]:.1f} us with temperatures")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measured_recordings(Path(sys.argv[1]))
    made_recordings()
    without_influence()
    emissivity()
    diagnosed()
    coverage()
    cost()
