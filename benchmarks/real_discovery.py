"""The diagnosis on measured recordings: it has to identify effects that were removed from MF6.1, or that MF6.1 lacks.

Every fourth sweep belongs to the hold-out set. A tire without some effects is fitted to the other sweeps, and the
diagnosis gets this tire and these sweeps. Baseline and improved tire are then compared on the hold-out set, without
any correction of its data. The recordings (cornering.mat, drivebrake.mat) are not part of the project.

    python benchmarks/real_discovery.py --data FOLDER [--cases pressure,camber,all-camber,combined,full]
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
from tirefmu.fitting import fit
from tirefmu.measurements import Recording, read_recording
from tirefmu.symbolic.models import model

#: Every n-th sweep is held out. n is coprime to the number of camber angles (three) and of loads in the test program.
EVERY = 4
#: Effects of camber in the public contract, and all effects of camber.
CAMBER = ("camber_thrust", "camber_stiffness", "camber_friction")
ALL_CAMBER = tuple(sorted(name for name in model("mf61").default_effects if name.startswith("camber")))
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
    "full": Case("cornering.mat", ("Fy",), (), "all held-out sweeps", lambda sweep: sweep["Fz"].notna()),
}  # fmt: skip


def run(case: Case, folder: Path) -> None:
    """Fit, diagnose and print the errors on held-out sweeps."""
    start = time.process_time()
    recording = read_recording(folder / case.file)
    others = [name for name in recording.measured() if name not in case.channels]
    recording = replace(recording, table=recording.table.drop(columns=others))
    holdout = held_out(recording)
    training = replace(recording, table=recording.table[~holdout].reset_index(drop=True))
    fitted = fit([training], "mf61", nominal=NOMINAL, without=case.without)
    print(f"  fitted without {', '.join(case.without) or 'nothing'}: {fitted.status}", flush=True)
    diagnosis = diagnose(training.table, signs=training.signs, tire=fitted.tire)
    print(f"  {diagnosis.verdict}")
    for one in diagnosis.found:
        values = [f"{name} {c.value:.4g} ({c.lower:.4g} to {c.upper:.4g})" for name, c in one.coefficients.items()]
        print(f"  {one.effect}: gain {100 * one.cv_gain:.1f} +- {100 * one.cv_gain_se:.1f} %; {', '.join(values)}")
    for name, confounded in diagnosis.confounded_with.items():
        print(f"  {name} is confounded with {', '.join(f'{other} ({r:.2f})' for other, r in confounded.items())}")
    for line in (*diagnosis.next_measurement, *map(str, diagnosis.extrapolation)):
        print(f"  {line}")
    print_errors(diagnosis, recording, holdout, case)
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
    options = parser.parse_args()
    if options.data is None:
        parser.error("--data or TIREFMU_DATA has to be the folder of the recordings")
    for name in options.cases.split(","):
        print(f"{name}: {CASES[name].file}", flush=True)
        run(CASES[name], Path(options.data))


if __name__ == "__main__":
    main()
