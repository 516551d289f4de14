"""Names of the diagnosis on a measured recording (cornering.mat, Fy), judged by what can be checked without the truth.

- splits: a random fifth of the sweeps is left out; names, and errors of both tires on these sweeps, for each fifth.
- removed: an effect is removed from MF6.1 on purpose, and is to be named.
- permuted: the temperatures of the sweeps are permuted; no effect of the temperature is to be named.
- twins: forces are those of the fitted tire plus its residuals, each sweep shifted in time by a random part of it and
  with a random sign; nothing is to be named.

    python benchmarks/measured_names.py --data FOLDER [--kinds splits,removed,permuted,twins] [--splits 0,1,2,3,4]
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tirefmu.diagnosis import Diagnosis, diagnose
from tirefmu.fitting import fit
from tirefmu.measurements import Recording, read_recording
from tirefmu.tires import Tire

#: Parts of the sweeps, one of which is left out.
PARTS = 5
NOMINAL = {"Fz0": 1700.0, "R0": 0.23, "p0": 83e3, "V0": 11.2}
#: Effects of MF6.1 that are removed on purpose.
REMOVED = (
    "load_friction", "load_stiffness", "pressure_friction", "pressure_stiffness", "camber_friction",
    "camber_stiffness", "camber_thrust", "plysteer",
)  # fmt: skip
KINDS = ("splits", "removed", "permuted", "twins")


def of_sweeps(recording: Recording, part: int) -> tuple[Recording, npt.NDArray[np.bool_]]:
    """Return a recording without a random fifth of its sweeps, and which rows are left out."""
    sweeps, left_out = recording.segments(), np.zeros(len(recording), dtype=bool)
    for sweep, number in zip(sweeps, np.random.default_rng(5).permutation(len(sweeps)), strict=True):
        left_out[sweep] = number % PARTS == part
    return replace(recording, table=recording.table[~left_out].reset_index(drop=True)), left_out


def permuted(recording: Recording, rng: np.random.Generator) -> Recording:
    """Return a recording in which each sweep has the temperatures of another one."""
    sweeps, table = recording.segments(), recording.table.copy()
    courses = [table["T"].to_numpy()[sweep] for sweep in sweeps]
    for sweep, other in zip(sweeps, rng.permutation(len(sweeps)), strict=True):
        places = [np.linspace(0.0, 1.0, len(course)) for course in (table["T"].to_numpy()[sweep], courses[other])]
        table.loc[table.index[sweep], "T"] = np.interp(*places, courses[other])
    return replace(recording, table=table)


def twin(recording: Recording, tire: Tire, rng: np.random.Generator) -> Recording:
    """Return a recording with the forces of a tire and its residuals without relation to the inputs."""
    table = recording.table.copy()
    computed = tire.evaluate(table, signs=recording.signs, code="batch")["Fy"].to_numpy()
    residual = table["Fy"].to_numpy() - computed
    for sweep in recording.segments():
        rows = residual[sweep]
        residual[sweep] = np.roll(rows, rng.integers(len(rows))) * rng.choice([-1.0, 1.0])
    return replace(recording, table=table.assign(Fy=computed + residual))


def described(diagnosis: Diagnosis) -> str:
    """Return names with their probabilities, and effects of which one is missing."""
    sure = [(name, share) for name, share in diagnosis.answer.probabilities.items() if share > 0.1]
    names = [f"{name} {share:.2f}" for name, share in sorted(sure, key=lambda pair: -pair[1])]
    names += [f"{' or '.join(each.effects)} {each.probability:.2f}" for each in diagnosis.one_of]
    return ", ".join(names) or "nothing"


def errors(diagnosis: Diagnosis, recording: Recording, rows: npt.NDArray[np.bool_]) -> str:
    """Return the root mean square errors of both tires in some rows."""
    sizes = []
    for tire in (diagnosis.base_tire, diagnosis.tire):
        computed = tire.evaluate(recording.table, signs=recording.signs, code="batch")
        sizes.append(float(np.sqrt(np.mean((recording.table["Fy"] - computed["Fy"])[rows] ** 2))))
    return "{:.1f} to {:.1f} N".format(*sizes)


def run(kind: str, recording: Recording, part: int) -> None:
    """Print the cases of a kind for one part."""
    training, left_out = of_sweeps(recording, part)
    rng = np.random.default_rng(part)
    for effect in REMOVED if kind == "removed" else ("",):
        start = time.process_time()
        fitted = fit([training], "mf61", nominal=NOMINAL, without=(effect,) if effect else ()).tire
        diagnosed = training
        if kind == "permuted":
            diagnosed = permuted(training, rng)
        if kind == "twins":
            diagnosed = twin(training, fitted, rng)
        diagnosis = diagnose(diagnosed.table, signs=diagnosed.signs, tire=fitted)
        error = f"; left out {errors(diagnosis, recording, left_out)}" if kind in ("splits", "removed") else ""
        what = f" {effect} ({diagnosis.answer.probabilities[effect]:.2f})" if effect else ""
        print(
            f"{kind} {part}{what}: {described(diagnosis)}{error}; {time.process_time() - start:.0f} CPU s", flush=True
        )


def main() -> None:
    """Run the requested kinds and parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("TIREFMU_DATA"), help="default: TIREFMU_DATA")
    parser.add_argument("--kinds", default=",".join(KINDS), help=f"of {', '.join(KINDS)}")
    parser.add_argument("--splits", default=",".join(map(str, range(PARTS))), help="which fifths are left out")
    options = parser.parse_args()
    if options.data is None:
        parser.error("--data or TIREFMU_DATA has to be the folder of the recordings")
    recording = read_recording(Path(options.data) / "cornering.mat")
    others = [name for name in recording.measured() if name != "Fy"]
    recording = replace(recording, table=recording.table.drop(columns=others))
    for kind in options.kinds.split(","):
        for part in map(int, options.splits.split(",")):
            run(kind, recording, part)


if __name__ == "__main__":
    main()
