"""Predicted temperatures against recorded ones: measured recordings, and made ones of an independent generator.

    python benchmarks/temperature.py [FOLDER]

FOLDER has ``cornering.mat`` and ``drivebrake.mat``; without it only made recordings are computed. Printed are, for each
measured recording, the rms error over the last 30 % of the time after a fit to the rest, the error of the other
recording's coefficients, and the error of Fy with the predicted and with the recorded temperature; for the made
recordings, errors in units of the sensor's noise; and the time of a simulated row with and without temperatures.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu import fit
from tirefmu.fitting.temperature.heat_balance import EFFECT, HeatBalance
from tirefmu.fitting.temperature.solution import solved
from tirefmu.fitting.temperature.temperature_fit import FITTED_SHARE, FREE, fit_temperature
from tirefmu.measurements import Recording, recording_from
from tirefmu.tires import Tire

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fitting"))
from thermal_generator import recording

#: Effects of the forces of measured recordings.
EFFECTS = (
    "load_friction", "load_stiffness", "camber_thrust", "camber_friction", "camber_stiffness", "pressure_friction",
    "pressure_stiffness", "plysteer", "conicity", "temp_friction", "temp_stiffness",
)  # fmt: skip
#: Duration, s, from whose temperatures the starts of the other recording are estimated.
START = 60.0
MADE, NOISE, DURATION = 30, 0.3, 300.0


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
    recorded, predicted = forces(recordings["cornering"])
    print(
        f"cornering, last {1 - FITTED_SHARE:.0%}: Fy rms {recorded:.1f} N with T recorded, {predicted:.1f} N predicted"
    )


def made_recordings() -> None:
    """Print the errors of made recordings, and the temperature of the largest friction.

    A third has friction with a maximum within the recorded range, a third one far above it, a third none.
    """
    all_rows, held_out = [], []
    for seed in range(MADE):
        kind = ("inside", "above", "none")[seed % 3]
        optimum = {"inside": 55.0, "above": 140.0, "none": 60.0}[kind]
        curvature = {"inside": 2e-4, "above": 2e-5, "none": 0.0}[kind]
        table = recording(seed, noise=NOISE, duration=DURATION, friction=curvature, optimum=optimum)
        effects = ["load_friction", "load_stiffness", "temp_friction", EFFECT]
        result = fit(table, "mf96", effects=effects, nominal={"Fz0": 1500.0, "R0": 0.25})
        error = result.tire.evaluate(table)["T_surface"] - 273.15 - table["T"]
        all_rows.append(rms(error) / NOISE)
        held_out.append(result.temperature.holdout_rmse / NOISE)
        answer = result.temperature.optimum.text()
        print(
            f"made {seed}, {kind}: {all_rows[-1]:.2f} of the noise, {held_out[-1]:.2f} held out; {answer}", flush=True
        )
    for what, ratios in (("over all rows", all_rows), ("held out", held_out)):
        within = sum(ratio <= 1.5 for ratio in ratios)
        print(
            f"{what}: median {np.median(ratios):.2f}, largest {max(ratios):.2f}, {within} of {MADE} within 1.5 times "
            "the noise"
        )


def cost() -> None:
    """Print the time of a simulated row with and without temperatures."""
    t = np.arange(0.0, 60.0, 0.005)
    table = pd.DataFrame({"t": t, "alpha": 0.1 * np.sin(t), "kappa": 0.05 * np.sin(1.3 * t), "Fz": 1500.0, "V": 15.0})
    seconds = {}
    for effects in ({"temp_friction"}, {"temp_friction", EFFECT}):
        values = {"FNOMIN": 1500.0, "UNLOADED_RADIUS": 0.25, "TMU1": -0.002}
        tire = Tire("mf61", {**values, **({"THACT": 1.0} if EFFECT in effects else {})}, effects=effects)
        tire.evaluate(table, hold=True)
        began = time.perf_counter()
        tire.evaluate(table, hold=True)
        seconds[EFFECT in effects] = time.perf_counter() - began
    plain, heated = (1e6 * seconds[present] / len(t) for present in (False, True))
    print(f"a row: {plain:.1f} us without, {heated:.1f} us with temperatures")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measured_recordings(Path(sys.argv[1]))
    made_recordings()
    cost()
