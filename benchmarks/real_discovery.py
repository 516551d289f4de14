"""The diagnosis on measured recordings: effects taken out of MF6.1 are found again, and what MF6.1 lacks is named.

Every fourth sweep is held out of everything. On the others a tire is fitted without some effects, and the diagnosis,
which is not told, has that tire and those sweeps. Base and improved tire are then held against the held-out sweeps,
with nothing taken out of them. The recordings (cornering.mat, drivebrake.mat) are not part of the project.

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
from tirefmu.symbolic import model

#: Every how-manieth sweep is held out; prime to the three cambers and the loads of the program.
EVERY = 4
#: Camber by the contract's names; and everything that camber does.
CAMBER = ("camber_thrust", "camber_stiffness", "camber_friction")
ALL_CAMBER = tuple(sorted(name for name in model("mf61").default_effects if name.startswith("camber")))
COMBINED = ("combined_Gxa", "combined_Gyk", "kappa_sideforce_SVyk")
NOMINAL = {"Fz0": 1700.0, "R0": 0.23, "p0": 83e3, "V0": 11.2}


@dataclass(frozen=True)
class Case:
    """What is taken out of the tire, and on which held-out sweeps it should be missed."""

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
    """Fit, diagnose and print what held-out sweeps say."""
    began = time.process_time()
    recording = read_recording(folder / case.file)
    others = [name for name in recording.measured() if name not in case.channels]
    recording = replace(recording, table=recording.table.drop(columns=others))
    kept = held_out(recording)
    training = replace(recording, table=recording.table[~kept].reset_index(drop=True))
    fitted = fit([training], "mf61", nominal=NOMINAL, without=case.without)
    print(f"  fitted without {', '.join(case.without) or 'nothing'}: {fitted.status}", flush=True)
    answer = diagnose(training.table, signs=training.signs, tire=fitted.tire)
    print(f"  {answer.verdict}")
    for one in answer.found:
        told = [f"{name} {c.value:.4g} ({c.lower:.4g} to {c.upper:.4g})" for name, c in one.coefficients.items()]
        print(f"  {one.effect}: gain {100 * one.cv_gain:.1f} +- {100 * one.cv_gain_se:.1f} %; {', '.join(told)}")
    for name, looks in answer.confounded_with.items():
        print(f"  {name} looks like {', '.join(f'{other} ({r:.2f})' for other, r in looks.items())}")
    for line in (*answer.next_measurement, *map(str, answer.reach)):
        print(f"  {line}")
    print_gaps(answer, recording, kept, case)
    print_company(recording.table)
    print(f"  {time.process_time() - began:.0f} s of CPU", flush=True)


def held_out(recording: Recording) -> npt.NDArray[np.bool_]:
    """Return which rows lie in held-out sweeps."""
    rows = np.zeros(len(recording), dtype=bool)
    for i, sweep in enumerate(recording.segments()):
        rows[sweep] = i % EVERY == EVERY - 1
    return rows


def print_gaps(answer: Diagnosis, recording: Recording, kept: npt.NDArray[np.bool_], case: Case) -> None:
    """Print root mean squares over the held-out sweeps, those where the effect should be missed apart."""
    table = recording.table
    missed = kept & case.where(table).to_numpy()
    computed = [tire.evaluate(table, signs=recording.signs, code="batch") for tire in (answer.base_tire, answer.tire)]
    for channel in case.channels:
        for name, rows in (("held-out sweeps", kept), (f"held-out sweeps, {case.missed}", missed)):
            before, after = (
                float(np.sqrt(np.mean((table[channel] - one[channel])[rows] ** 2))) for one in computed
            )  # fmt: skip
            floor = answer.gap["train"][channel]["floor"]
            print(f"  {channel}, {name}: {before:.1f} N before, {after:.1f} N after, noise floor {floor:.1f} N")


def print_company(table: pd.DataFrame) -> None:
    """Print how much of the temperature other inputs could stand in for: R2 of straight lines."""
    if "T" not in table:
        return
    told = []
    seconds = table.groupby((table["t"].diff() > 1.0).cumsum())["t"].transform(lambda t: t - t.iloc[0])
    for name, values in (("time", table["t"]), ("time in the sweep", seconds), ("p", table["p"]), ("Fz", table["Fz"])):
        told.append(f"{name} {np.corrcoef(values, table['T'])[0, 1] ** 2:.2f}")
    print(f"  what follows T in this recording (R2): {', '.join(told)}")


def main() -> None:
    """Run the cases that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("TIREFMU_DATA"), help="default: TIREFMU_DATA")
    parser.add_argument("--cases", default=",".join(CASES), help=f"of {', '.join(CASES)}")
    asked = parser.parse_args()
    if asked.data is None:
        parser.error("--data or TIREFMU_DATA has to name the folder of the recordings")
    for name in asked.cases.split(","):
        print(f"{name}: {CASES[name].file}", flush=True)
        run(CASES[name], Path(asked.data))


if __name__ == "__main__":
    main()
