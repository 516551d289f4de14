"""Files that commands of the documentation read: recordings and tires of a virtual bench, logs.

Each file has one maker, called in a folder of its own; a page gets copies.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.io import savemat

from tirefmu.commands.cli import main
from tirefmu.measurements import Recording, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, write_table
from tirefmu.tires import Tire

DOCS = Path(__file__).parents[2] / "docs"
LOADS = (500.0, 1000.0, 1500.0)
VALUES = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.23, "NOMPRES": 83000.0, "INFLPRES": 83000.0, "LONGVL": 11.0}
EFFECTS = ("load_friction", "load_stiffness", "camber_thrust", "combined_Gxa", "combined_Gyk")
TRUTH = Tire("mf61", {**VALUES, "PDY2": -0.1, "PDX2": -0.1, "PKY6": -0.6}, effects=EFFECTS)
#: Of the car of `tirefmu drive --example`.
CAR = Tire("mf61", {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3}, effects=("load_friction", "load_stiffness"))
#: Columns of a TTC file, with the channel and the factor from its SI values.
TTC = {"ET": ("t", 1.0), "SA": ("alpha", 180 / np.pi), "IA": ("gamma", 180 / np.pi), "SL": ("kappa", 1.0),
       "FZ": ("Fz", 1.0), "FX": ("Fx", 1.0), "FY": ("Fy", 1.0), "MZ": ("Mz", 1.0), "P": ("p", 1e-3),
       "V": ("V", 3.6), "TSTC": ("T", 1.0)}  # fmt: skip


def recording(seed: int = 1, tire: Tire = TRUTH) -> Recording:
    """Return sweeps of both slips at three loads on the virtual bench, in ISO-W."""
    lateral = alpha_sweeps(LOADS, [0.0, 0.035], sample_rate=8.0)
    longitudinal = kappa_sweeps(LOADS, [0.0, -0.05], sample_rate=8.0)
    return VirtualBench(tire, seed=seed).run(concatenate([lateral, longitudinal])).with_signs("iso")


def table(path: Path) -> None:
    write_table(recording(sum(path.name.encode())).table, path)


def bench_file(path: Path, rows: Recording | None = None) -> None:
    """Write rows in a file like those of the FSAE TTC, in SI units."""
    table = (rows or recording(sum(path.name.encode()))).with_signs("sae").table
    columns = {name: (channel, scale) for name, (channel, scale) in TTC.items() if channel in table}
    savemat(path, {name: scale * table[[channel]].to_numpy() for name, (channel, scale) in columns.items()})


def tire(path: Path) -> None:
    """Save a tire whose coefficients differ from `TRUTH` by some percent, at random."""
    random = np.random.default_rng(sum(path.name.encode()))
    changed = {name: TRUTH.values[name] * random.normal(1.0, 0.05) for name in ("PDX1", "PDY1", "PKX1", "PKY1", "PCY1")}
    TRUTH.with_values(**changed).save(path)


def fitted(path: Path) -> None:
    """Fit my.tir to run.csv, with fit.json."""
    table(run := path.with_name("run.csv"))
    given = ["--model", "mf61", "--nominal", "Fz0=1000,R0=0.23", "--effects", ",".join(EFFECTS)]
    main(["fit", str(run), *given, "-o", str(path.with_name("my.tir")), "--json", str(path.with_name("fit.json")),
          "--quiet"])  # fmt: skip


def warm(path: Path) -> None:
    """Write a recording with the temperature of the tread."""
    effects = ("load_friction", "load_stiffness", "temp_friction", "temperature")
    tire = Tire("mf61", {**VALUES, "TREF": 40.0, "TMU1": 0.004, "THACT": 1.0}, effects=effects)
    rows = recording().table
    found = tire.evaluate(rows.drop(columns=["Fx", "Fy", "Mz"]))
    warmed = rows.assign(**{name: found[name] for name in ("Fx", "Fy", "Mz")}, T=found["T_surface"] - 273.15)
    bench_file(path, Recording(warmed, "iso", "warm"))


def drive_log(path: Path) -> None:
    """Write a drive of the car of `tirefmu drive --example`, as a single-track model without load transfer."""
    t = np.arange(0.0, 15.0, 0.01)
    steer = (0.01 + 0.005 * t) * np.sin(2 * np.pi * 0.4 * t)
    vy = yaw_rate = 0.0
    rows = []
    m, inertia, front, rear, speed = 1100.0, 1600.0, 1.15, 1.25, 17.0
    loads = 9.81 * m / (front + rear) / 2 * np.array([rear, front])
    for delta in steer:
        alpha = np.arctan([(vy + front * yaw_rate) / speed - delta, (vy - rear * yaw_rate) / speed])
        at_front, at_rear = 2 * CAR.forces(alpha=alpha, Fz=loads, code="numpy")["Fy"]
        ay = (at_front + at_rear) / m
        rows.append((yaw_rate, -yaw_rate * vy, ay, speed))
        vy += 0.01 * (ay - yaw_rate * speed)
        yaw_rate += 0.01 * (front * at_front - rear * at_rear) / inertia
    log = pd.DataFrame(rows, columns=["yaw_rate", "ax", "ay", "speed"])
    noise = np.random.default_rng(0).normal(0.0, (0.003, 0.05, 0.05, 0.03), log.shape)
    (log + noise).assign(t=t, steer=15.0 * steer).to_csv(path, index=False)


def folder_of(count: int, make, name: str):
    def fill(path: Path) -> None:
        path.mkdir()
        for i in range(count):
            make(path / name.format(i))

    return fill


MAKERS = {
    **dict.fromkeys(("my.tir", "run.csv", "fit.json"), fitted),
    **dict.fromkeys(("bench.csv", "run7.csv", "test.csv", "table.csv"), table),
    **dict.fromkeys(("cornering.mat", "drivebrake.mat", "B1464run30.mat", "B1464run45.mat"), bench_file),
    **dict.fromkeys(("front.tir", "rear.tir"), CAR.save),
    **dict.fromkeys(("tire.tir", "old.tir", "new.tir", "other.tir", "similar.tir"), tire),
    "run.mat": warm,
    "log.csv": drive_log,
    "crop.where": lambda path: path.write_text("abs(alpha) < 10 deg\n", encoding="utf-8"),
    "recordings": folder_of(2, table, "run{}.csv"),
    "similar": folder_of(3, tire, "tire{}.tir"),
    "docs": lambda path: shutil.copytree(DOCS / "effects", path / "effects"),
}


class MadeFiles:
    """A folder in which each file is made when it is first needed."""

    def __init__(self, folder: Path):
        self.folder = folder

    def copy(self, name: str, target: Path) -> None:
        """Copy a file or a folder of the folder, which is made first if it is not there."""
        if not (self.folder / name).exists():
            MAKERS[name](self.folder / name)
        source = self.folder / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, target / name)
