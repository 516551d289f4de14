"""Slip stiffness and errors of a fit by the weights of rows, and what limits K_xkappa: totals in docs/stiffness.md.

A cornering recording and a drive and brake recording of one tire. A fit with the weight of the channel alone comes
first; each other weighting repeats the final stages of the recipe from its result.

K_xkappa of the drive and brake recording differs from the data because of the weights, because both recordings are
fitted together although they contradict each other, and because of the slip lag of the sweeps. So the study also fits
that recording alone, and with its longitudinal slip delayed so that up- and down-sweeps agree.

    TIREFMU_DATA=FOLDER python benchmarks/row_weights.py [--model mf61] [--every 1]
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tirefmu.fitting import FitResult, fit
from tirefmu.measurements import Recording, read_recording
from tirefmu.tires import Tire

FloatArray = npt.NDArray[np.float64]
FILES = ("cornering.mat", "drivebrake.mat")
#: Weighting of rows, and weight of the slip stiffness, of each repetition.
WEIGHTINGS = {
    "errors relative to the load": ("load", 0.0),
    "slip stiffness, 10": ("condition", 10.0),
    "both": ("load", 10.0),
}
#: Half of the range of the longitudinal slip in which up- and down-sweeps are compared, and their fewest rows there.
NEAR_ZERO, FEWEST = 0.02, 20
FINAL_STAGES = """name = "final"
description = "final stages"
[[stage]]
name = "random rows"
channels = ["Fx", "Fy", "Mz"]
rows = 6000
weights = "noise"
[[stage]]
name = "all rows"
channels = ["Fx", "Fy", "Mz"]
weights = "noise"
"""


@dataclass(frozen=True)
class Repeated:
    """The final stages of a fit, from a start tire."""

    start: Tire
    recipe: Path

    def __call__(self, recordings: list[Recording], rows: str = "condition", stiffness: float = 0.0) -> FitResult:
        """Return the fit of recordings with a weighting."""
        recipe = str(self.recipe)
        return fit(recordings, start=self.start, recipe=recipe, rows=rows, stiffness_weight=stiffness)


def line_of(name: str, result: FitResult, seconds: float) -> str:
    """Return relative errors of slip stiffness by recording and load, and root mean square errors, in one line."""
    parts = [f"{name} ({result.status}, {seconds:.0f} s CPU)"]
    for source in dict.fromkeys(each.recording for each in result.findings.stiffnesses):
        own = [each for each in result.findings.stiffnesses if each.recording == source]
        for slip in dict.fromkeys(each.slip for each in own):
            errors = ", ".join(
                f"{each.load:.0f} N {each.off:+.1%} (+-{each.error / each.read:.1%})"
                for each in own
                if each.slip == slip
            )
            parts.append(f"    {source} slip stiffness over {slip}: {errors}")
    errors = ", ".join(f"{c.recording[0]} {c.channel} {c.rmse:.2f}" for c in result.channels)
    return "\n".join([*parts, f"    root mean square errors: {errors}"])


def delayed(recording: Recording, length: float) -> Recording:
    """Return the recording with the longitudinal slip of a distance rolled in m before; negative: after."""
    table = recording.table
    kappa, time_of, speed = (table[name].to_numpy(dtype=np.float64) for name in ("kappa", "t", "V"))
    slip = kappa.copy()
    for rows in recording.segments():
        distance = np.abs(speed[rows]).mean() * (time_of[rows] - time_of[rows][0])
        slip[rows] = np.interp(distance - length, distance, kappa[rows])
    return replace(recording, table=table.assign(kappa=slip))


def lag_of(recording: Recording) -> tuple[float, float]:
    """Return the relaxation length of the longitudinal slip in m from pairs of sweeps, and its standard error.

    A force that lags crosses zero later in slip when the slip rises than when it falls. Half of the difference, divided
    by the change of slip per distance rolled, is the relaxation length.
    """
    table = recording.table
    names = ("kappa", "alpha", "Fx", "t", "V")
    kappa, alpha, force, time_of, speed = (table[name].to_numpy(dtype=np.float64) for name in names)
    free = (np.abs(kappa) < NEAR_ZERO) & (np.abs(alpha) < np.radians(0.5))
    lengths = []
    for segment in recording.segments():
        rows = np.arange(segment.start, segment.stop)
        if len(rows) < FEWEST:
            continue
        interval = float(np.median(np.diff(time_of[rows])))
        rate = np.gradient(np.convolve(kappa[rows], np.full(9, 1 / 9), mode="same"), interval)
        rising, falling = (free[rows] & (sign * rate > 0.0) for sign in (1.0, -1.0))
        if min(rising.sum(), falling.sum()) >= FEWEST:
            zeros = [_zero_crossing(kappa[rows[side]], force[rows[side]]) for side in (rising, falling)]
            per_distance = float(np.median(np.abs(rate[rising | falling]) / np.abs(speed[rows][rising | falling])))
            lengths.append(0.5 * (zeros[0] - zeros[1]) / per_distance)
    return float(np.mean(lengths)), float(np.std(lengths, ddof=1) / np.sqrt(len(lengths)))


def _zero_crossing(slip: FloatArray, force: FloatArray) -> float:
    """Return the slip at which a straight line through the points is zero."""
    slope, offset = np.polyfit(slip, force, 1)
    return float(-offset / slope)


def main() -> None:
    """Run the study and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", default="mf61")
    parser.add_argument("--every", type=int, default=1, help="fit every n-th row only")
    given = parser.parse_args()
    folder = Path(os.environ["TIREFMU_DATA"])
    recordings = [read_recording(folder / name) for name in FILES]
    recordings = [replace(r, table=r.table.iloc[:: given.every].reset_index(drop=True)) for r in recordings]
    driving = recordings[1]

    length, error = lag_of(driving)
    print(f"relaxation length from up- and down-sweeps: {length:.4f} m, standard error {error:.4f} m", flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        recipe = Path(temporary) / "final.toml"
        recipe.write_text(FINAL_STAGES, encoding="utf-8")
        began = time.process_time()
        base = fit(recordings, given.model, stiffness_weight=0.0)
        print(line_of("channel only, whole recipe", base, time.process_time() - began), flush=True)
        again = Repeated(base.tire, recipe)
        cases = [
            *((name, recordings, rows, weight) for name, (rows, weight) in WEIGHTINGS.items()),
            ("drive and brake alone", [driving], "condition", 0.0),
            (f"drive and brake alone, slip delayed by {length:+.3f} m", [delayed(driving, length)], "condition", 0.0),
        ]  # fmt: skip
        for name, some, rows, weight in cases:
            began = time.process_time()
            result = again(some, rows, weight)
            print(line_of(name, result, time.process_time() - began), flush=True)


if __name__ == "__main__":
    main()
