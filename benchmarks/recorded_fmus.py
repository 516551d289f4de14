"""FMUs of two tires over a measured recording: Co-Simulation, Model Exchange, and evaluation with held inputs.

    python benchmarks/recorded_fmus.py BEFORE.tir AFTER.tir TABLE [--rows 5000]

Printed are the errors of both tires, the largest difference of Co-Simulation from ``tirefmu evaluate --hold``, and that
of Model Exchange with CVode from Co-Simulation halfway between the rows, each relative to 1 + the value of direct
evaluation.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
from fmpy import simulate_fmu

from tirefmu import load
from tirefmu.fmu import export
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.measurements import Recording, read_recording
from tirefmu.tires import TABLE_INPUTS
from tirefmu.tires.tire import Tire

FloatArray = npt.NDArray[np.float64]

#: Relative tolerance of CVode.
TOLERANCE = 1e-10


def halved(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with a second row halfway to the next one, with the same inputs."""
    t = table["t"].to_numpy()
    middle = table.iloc[:-1].assign(t=0.5 * (t[:-1] + t[1:]))
    return pd.concat([table, middle]).sort_values("t", kind="stable").reset_index(drop=True)


def held(table: pd.DataFrame, names: list[str]) -> FloatArray:
    """Return inputs that jump at each row, as a structured array for fmpy: two rows at the same time."""
    rows = np.r_[0, np.repeat(np.arange(1, len(table)), 2)]
    signal = np.zeros(len(rows), dtype=[(name, float) for name in ("time", *names)])
    signal["time"] = table["t"].to_numpy()[rows]
    before = np.r_[0, np.repeat(np.arange(len(table) - 1), 2)] + np.r_[0, np.tile([0, 1], len(table) - 1)]
    for name in names:
        signal[name] = table[name].to_numpy()[before]
    return signal


def compared(tire: Tire, recording: Recording, folder: Path) -> tuple[pd.Series, float, float]:
    """Return errors by channel, and the largest relative differences of Co-Simulation and of Model Exchange."""
    path, outputs = export(tire, folder / f"{tire.name}.fmu", fmi=3), list(tire.outputs)
    table = halved(recording.table)
    with loaded(path) as slave:
        known = {one.name for one in slave.description.modelVariables if one.causality == "input"}
        names = [name for name in TABLE_INPUTS if name in known and name in table]
        time, rows = table["t"].to_numpy(), table[names].to_numpy(dtype=np.float64)
        stepped = slave.run(slice(0, len(table)), time, rows, names, outputs)
    direct = tire.evaluate(table[["t", *names]], hold=True)[outputs].to_numpy()
    solved = simulate_fmu(
        str(path), fmi_type="ModelExchange", solver="CVode", relative_tolerance=TOLERANCE, start_time=time[0],
        stop_time=time[-1], output_interval=0.5 * float(np.median(np.diff(recording.table["t"]))),
        input=held(recording.table, names), output=outputs,
    )  # fmt: skip
    inside = np.setdiff1d(np.round(time, 6), np.round(recording.table["t"], 6))
    of_steps, of_solver = (np.searchsorted(np.round(each, 6), inside) for each in (time, solved["time"]))
    found = np.flatnonzero(np.abs(solved["time"][np.minimum(of_solver, len(solved) - 1)] - inside) < 1e-5)
    by_solver = np.column_stack([solved[name][of_solver[found]] for name in outputs])
    scale = 1.0 + np.abs(direct)
    difference = float(np.max(np.abs(stepped - direct) / scale))
    by_kind = float(np.max(np.abs(by_solver - stepped[of_steps[found]]) / scale[of_steps[found]]))
    measured = [name for name in recording.measured() if name in outputs]
    error = table[measured] - pd.DataFrame(stepped, columns=outputs)[measured]
    print(f"  {tire.name}: {len(found)} instants compared with the solver", flush=True)
    return np.sqrt((error**2).mean()), difference, by_kind


def main() -> None:
    """Compare both tires."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("before", "after", "table"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--rows", type=int, default=5000, help="first rows of the table")
    options = parser.parse_args()
    recording = read_recording(options.table).with_signs("iso")
    table = recording.table.iloc[: options.rows]
    recording = replace(recording, table=table.assign(t=table["t"] - table["t"].iloc[0]).reset_index(drop=True))
    with tempfile.TemporaryDirectory() as folder:
        for name in ("before", "after"):
            tire = replace(load(getattr(options, name)).in_signs("iso"), name=name)
            error, stepped, solved = compared(tire, recording, Path(folder))
            errors = ", ".join(f"{channel} {size:.1f}" for channel, size in error.items())
            print(f"{name}: root mean square error {errors}")
            print(f"  Co-Simulation from direct evaluation {stepped:.1e}, Model Exchange from it {solved:.1e}")


if __name__ == "__main__":
    main()
