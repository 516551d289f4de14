"""The diagnosis on measured recordings: it has to identify effects that were removed from MF6.1, or that MF6.1 lacks.

Every fourth sweep belongs to the hold-out set. A tire without some effects is fitted to the other sweeps, and the
diagnosis gets this tire and these sweeps. Baseline and improved tire are then compared on the hold-out set, without
any correction of its data. The recordings (cornering.mat, drivebrake.mat) are not part of the project.

The cases full and no-temperature compare the two tires again: each is fitted, with its effects, to the recording
without some of its operating conditions, and predicts these, for all conditions in turn.

    python benchmarks/real_discovery.py --data FOLDER [--cases pressure,camber,all-camber,combined,full,no-temperature]
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.diagnosis import Diagnosis, diagnose
from tirefmu.diagnosis.diagnose import with_library
from tirefmu.diagnosis.least_squares import LeastSquares, Solution
from tirefmu.diagnosis.probing import fit_baseline
from tirefmu.diagnosis.signals import FORMULA_SIGNS, signals_of
from tirefmu.fitting import fit
from tirefmu.measurements import Recording, read_recording
from tirefmu.symbolic.models import model_named

#: Every n-th sweep is in the hold-out set. n is coprime to the number of camber angles (three) and of loads in the test
#: program.
EVERY = 4
#: Parts of the operating conditions that are excluded in turn.
PARTS = 15
#: The recording to which effects of the other one are carried over.
OTHER = "drivebrake.mat"
#: Effects of camber in the public contract, and all effects of camber.
CAMBER = ("camber_thrust", "camber_stiffness", "camber_friction")
ALL_CAMBER = tuple(sorted(name for name in model_named("mf61").default_effects if name.startswith("camber")))
COMBINED = ("combined_Gxa", "combined_Gyk", "kappa_sideforce_SVyk")
NOMINAL = {"Fz0": 1700.0, "R0": 0.23, "p0": 83e3, "V0": 11.2}


@dataclass(frozen=True)
class Case:
    """The effects that are removed, and the held-out sweeps on which they matter."""

    file: str
    channels: tuple[str, ...]
    without: tuple[str, ...]
    missed: str
    where: Callable[[pd.DataFrame], pd.Series]
    not_used: tuple[str, ...] = ()
    cross_validated: bool = False


CASES = {
    "pressure": Case(
        "cornering.mat", ("Fy",), ("pressure_stiffness", "pressure_friction"), "70 and 97 kPa",
        lambda sweep: abs(sweep["p"] - 83e3) > 6e3,
    ),
    "camber": Case("cornering.mat", ("Fy",), CAMBER, "gamma above 1 deg", lambda sweep: sweep["gamma"] > 0.017),
    "all-camber": Case("cornering.mat", ("Fy",), ALL_CAMBER, "gamma above 1 deg", lambda sweep: sweep["gamma"] > 0.017),
    "combined": Case(
        "drivebrake.mat", ("Fx", "Fy"), COMBINED, "alpha beyond 1 deg", lambda sweep: abs(sweep["alpha"]) > 0.017
    ),
    "full": Case(
        "cornering.mat", ("Fy",), (), "Fz below 700 N", lambda sweep: abs(sweep["Fz"]) < 700.0, cross_validated=True
    ),
    "no-temperature": Case(
        "cornering.mat", ("Fy",), (), "Fz below 700 N", lambda sweep: abs(sweep["Fz"]) < 700.0, ("T",), True
    ),
}  # fmt: skip


def run(name: str, folder: Path, tires: Path | None) -> None:
    """Fit, diagnose and print the errors on held-out sweeps; write the tires to a folder."""
    case = CASES[name]
    start = time.process_time()
    recording = read_recording(folder / case.file)
    others = [name for name in recording.measured() if name not in case.channels]
    recording = replace(recording, table=recording.table.drop(columns=[*others, *case.not_used]))
    holdout = held_out(recording)
    training = replace(recording, table=recording.table[~holdout].reset_index(drop=True))
    fitted = fit([training], "mf61", nominal=NOMINAL, without=case.without)
    print(f"  fitted without {', '.join(case.without) or 'nothing'}: {fitted.status}", flush=True)
    diagnosis = diagnose(training.table, signs=training.signs, tire=fitted.tire)
    print(f"  {diagnosis.verdict}")
    for one in diagnosis.found:
        values = [f"{name} {c.value:.4g} ({c.lower:.4g} to {c.upper:.4g})" for name, c in one.coefficients.items()]
        print(f"  {one.effect}: gain {100 * one.cv_gain:.1f} +- {100 * one.cv_gain_se:.1f} %; {', '.join(values)}")
    for effect, confounded in diagnosis.confounded_with.items():
        print(f"  {effect} is confounded with {', '.join(f'{other} ({r:.2f})' for other, r in confounded.items())}")
    for one in diagnosis.unknown:
        print(f"  unexplained: {one.formula} ({one.not_added_because or 'added'})")
    for line in (*diagnosis.next_measurement, *map(str, diagnosis.extrapolation)):
        print(f"  {line}")
    print_errors(diagnosis, recording, holdout, case)
    if case.cross_validated:
        print_cross_validated(diagnosis, recording, case.channels)
        print_carried_over(diagnosis, folder / OTHER, case.not_used)
    if tires is not None:
        for when, tire in (("before", diagnosis.base_tire), ("after", diagnosis.tire)):
            tire.save(tires / f"{name}_{when}.tir")
    print_correlates(recording.table)
    print(f"  {time.process_time() - start:.0f} s of CPU", flush=True)


def held_out(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return which rows are in held-out sweeps."""
    rows = np.zeros(len(recording), dtype=bool)
    for i, sweep in enumerate(recording.segments()):
        rows[sweep] = i % EVERY == EVERY - 1
    return rows


def print_errors(diagnosis: Diagnosis, recording: Recording, holdout: npt.NDArray[np.bool_], case: Case) -> None:
    """Print root mean square errors over all held-out sweeps, and over those on which the removed effects matter."""
    table = recording.table
    missed = holdout & case.where(table).to_numpy()
    computed = [
        tire.evaluate(table, signs=recording.signs, code="batch") for tire in (diagnosis.base_tire, diagnosis.tire)
    ]
    for channel in case.channels:
        for name, rows in (("held-out sweeps", holdout), (f"held-out sweeps, {case.missed}", missed)):
            before, after = (
                float(np.sqrt(np.mean((table[channel] - one[channel])[rows] ** 2))) for one in computed
            )  # fmt: skip
            floor = diagnosis.gap["train"][channel]["floor"]
            print(f"  {channel}, {name}: {before:.1f} N before, {after:.1f} N after, noise floor {floor:.1f} N")


def conditions(recording: Recording) -> npt.NDArray[np.int64]:
    """Return the number of the operating condition of each row: load, camber and pressure of its sweep."""
    table = recording.table
    sweep = np.empty(len(table), dtype=np.int64)
    for i, rows in enumerate(recording.segments()):
        sweep[rows] = i
    steps = {"Fz": 550.0, "gamma": 0.017, "p": 7e3}
    levels = pd.DataFrame({name: (table[name].groupby(sweep).mean() / step).round() for name, step in steps.items()})
    return levels.groupby(list(steps)).ngroup().to_numpy()[sweep]


def print_cross_validated(diagnosis: Diagnosis, recording: Recording, channels: tuple[str, ...]) -> None:
    """Print errors over all rows, each predicted by a tire that was fitted without the row's operating condition.

    The coefficients of a state's equation stay at the values of the diagnosis.
    """
    condition = conditions(recording)
    part = np.random.default_rng(0).permutation(condition.max() + 1)[condition] % PARTS
    tires = {"before": diagnosis.base_tire, "after": diagnosis.tire}
    squares = {name: np.zeros(len(channels)) for name in tires}
    for k in range(PARTS):
        training = replace(recording, table=recording.table[part != k].reset_index(drop=True))
        for name, tire in tires.items():
            fitted = fit([training], start=tire, effects=sorted(tire.has)).tire
            computed = fitted.evaluate(recording.table, signs=recording.signs, code="batch")
            error = (recording.table[list(channels)] - computed[list(channels)])[part == k]
            squares[name] += (error**2).sum().to_numpy()
    for i, channel in enumerate(channels):
        before, after = (np.sqrt(squares[name][i] / len(part)) for name in tires)
        print(f"  {channel}, all rows, {condition.max() + 1} conditions excluded in {PARTS} parts: "
              f"{before:.1f} N before, {after:.1f} N after")  # fmt: skip


def print_carried_over(diagnosis: Diagnosis, file: Path, not_used: tuple[str, ...]) -> None:
    """Print errors in another recording of a tire without and with each effect, as identified and fitted again.

    All other coefficients are fitted to that recording.
    """
    recording = read_recording(file)
    recording = replace(
        recording, table=recording.table.drop(columns=[c for c in ("Mz", "Mx", *not_used) if c in recording.table])
    )
    base = fit([recording], "mf61", nominal=NOMINAL).tire
    start = with_library(base)
    signals = signals_of(recording.table, start, recording.signs)
    problem, without = fit_baseline(start, signals, fitted=True)
    print(f"  {file.name}, without: {errors_text(problem, without)}")
    found = diagnosis.in_signs(FORMULA_SIGNS).found
    for one in (one for one in found if one.effect in start.symbolic_model.effects):
        parameters = without.parameters.copy()
        for coefficient, interval in one.coefficients.items():
            parameters[problem.simulator.index[coefficient]] = interval.value
        order = problem.simulator.names.index
        both = tuple(sorted({*without.free, *one.coefficients}, key=order))
        carried, fitted = (problem.solve(parameters, free, iterations=12) for free in (without.free, both))
        print(f"  {file.name}, {one.effect} as found: {errors_text(problem, carried)}")
        print(f"  {file.name}, {one.effect} fitted: {errors_text(problem, fitted)}")


def errors_text(problem: LeastSquares, solution: Solution) -> str:
    """Return the root mean square error of each channel on training rows and on the hold-out set."""
    signals, texts = problem.simulator.signals, []
    for i, channel in enumerate(signals.channels):
        sizes = [
            float(np.sqrt(np.mean(solution.residual[i][rows] ** 2)))
            for rows in (problem.inverse_noise[i] > 0.0, signals.present[i] & signals.holdout)
        ]
        texts.append(f"{channel} {sizes[0]:.1f} N, hold-out {sizes[1]:.1f} N")
    return "; ".join(texts)


def print_correlates(table: pd.DataFrame) -> None:
    """Print the coefficient of determination of the temperature by each other input."""
    if "T" not in table:
        return
    found = []
    seconds = table.groupby((table["t"].diff() > 1.0).cumsum())["t"].transform(lambda t: t - t.iloc[0])
    for name, values in (("time", table["t"]), ("time in the sweep", seconds), ("p", table["p"]), ("Fz", table["Fz"])):
        found.append(f"{name} {np.corrcoef(values, table['T'])[0, 1] ** 2:.2f}")
    print(f"  correlates of T in this recording (R2): {', '.join(found)}")


def main() -> None:
    """Run the requested cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("TIREFMU_DATA"), help="default: TIREFMU_DATA")
    parser.add_argument("--cases", default=",".join(CASES), help=f"of {', '.join(CASES)}")
    parser.add_argument(
        "--tires", type=Path, help="existing folder for the tires before and after: CASE_before.tir, ..."
    )
    options = parser.parse_args()
    if options.data is None:
        parser.error("--data or TIREFMU_DATA has to be the folder of the recordings")
    for name in options.cases.split(","):
        print(f"{name}: {CASES[name].file}", flush=True)
        run(name, Path(options.data), options.tires)


if __name__ == "__main__":
    main()
