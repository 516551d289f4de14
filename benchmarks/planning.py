"""Planned programs on the virtual bench: bench time, predicted and achieved intervals, for tires of three sizes.

For each tire the program of the Trento report, with the loads of the tire, is compared with a plan of half of its bench
time. Achieved intervals are the scatter of fits of noisy recordings. Run by `make planning`.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from math import radians

import numpy as np
import pandas as pd

from tirefmu.applications.planning.bench_file import Bench, Limits
from tirefmu.applications.planning.plan import plan
from tirefmu.commands.demo import bench_tire
from tirefmu.fitting import fit
from tirefmu.measurements import Noise, Program, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, recording_from
from tirefmu.tires import Tire, published, read_tir
from tirefmu.tires.evaluation import quantities

GOLDEN = "tests/golden/MagicFormula61_Parameters.tir"


@dataclass(frozen=True)
class Case:
    """A tire and the ranges of its test: loads, N, the largest slip angle, deg, and the largest kappa."""

    tire: Tire
    loads: tuple[float, float]
    angle: float = 12.0
    slip: float = 0.3


def trento_like(case: Case) -> Program:
    """Return the sweeps of `trento_program` with its loads and slips mapped to the ranges of another tire."""
    loads = case.loads
    held = {name: case.tire.nominal(name) for name in ("p", "V") if name in case.tire.inputs}
    shares = np.array([0.0, 0.244, 0.533, 0.756, 1.0])  # of 220, 440, 700, 900, 1120 N
    levels = (loads[0] + shares * (loads[1] - loads[0])).tolist()
    cambers = [radians(angle) for angle in range(5)]
    lateral = alpha_sweeps(levels, cambers, amplitude=radians(case.angle), sample_rate=50.0, held=held)
    slips = [radians(angle) for angle in (0, 3, 6)]
    drive_brake = kappa_sweeps(
        [levels[0], *levels[2:]], slips, cambers[::2], lowest=-case.slip, highest=case.slip, sample_rate=50.0, held=held
    )
    return concatenate([lateral, drive_brake], name="today")


def bench_of(case: Case) -> Bench:
    """Return a bench with the ranges, rates and pauses of that program."""
    angle = radians(case.angle)
    limits = {
        "Fz": Limits(*case.loads, 5.0, levels=5), "alpha": Limits(-angle, angle, 5.0, radians(8)),
        "kappa": Limits(-case.slip, case.slip, 5.0, 0.4), "gamma": Limits(0.0, radians(4), 5.0, levels=3),
    }  # fmt: skip
    return Bench(limits, Noise().scaled(case.loads[1] / 3000.0))


def achieved(tire: Tire, bench: Bench, program: Program, prediction: object, seeds: int) -> dict[str, float]:
    """Return 1.96 times the standard deviation of fits, relative to the scales of the targets."""
    errors: dict[str, list[np.ndarray]] = {target.name: [] for target in prediction.targets}
    for seed in range(seeds):
        recording = VirtualBench(tire, bench.noise, seed=seed).run(program)
        fitted = fit([recording], start=tire, rows="equal", stiffness_weight=0.0).tire.in_signs("adapted-sae")
        for target in prediction.targets:
            inputs = dict(zip(tire.inputs, target.inputs, strict=True))
            name = target.name
            if name in tire.outputs:
                values = fitted.forces(**inputs)[name]
            else:
                values = quantities(fitted, inputs)[tire.symbolic_model.quantity(name)]
            error = (values - target.values[0]) / target.scales[0]
            errors[name].append(error)
    return {name: 1.96 * float(np.sqrt(np.mean(np.var(values, axis=0, ddof=1)))) for name, values in errors.items()}


def compared(name: str, case: Case, seeds: int) -> None:
    """Print time, predicted and achieved intervals of both programs for a tire."""
    tire, bench, today = replace(case.tire.in_signs("adapted-sae"), name=name), bench_of(case), trento_like(case)
    minutes = float(np.ptp(today.table["t"])) / 120.0
    result = plan(tire, bench, minutes=minutes, today=recording_from(today.table))
    rows = []
    parts = {"today": (today, result.today), "plan": (result.program.virtual, result.prediction)}
    for label, (program, prediction) in parts.items():
        real = achieved(tire, bench, program, prediction, seeds) if seeds else {}
        for target in prediction.targets:
            alone = 196.0 * float(np.sqrt(np.sum(target.squares[0] * prediction.covariances[0])))
            rows.append([label, target.name, alone, 100.0 * real.get(target.name, np.nan)])
    table = pd.DataFrame(rows, columns=["program", "target", "predicted", "achieved"])
    table = table.pivot(index="target", columns="program", values=["predicted", "achieved"])
    print(f"{name}: {2.0 * minutes:.1f} min today, {result.program.seconds / 60.0:.1f} min planned")
    print(table.round(3).to_string(), flush=True)


def main() -> None:
    """Compare the programs for the tires of three sizes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, help="Fits of each program; 0: predictions only.")
    parser.add_argument("--only", help="One of race, small, car.")
    arguments = parser.parse_args()
    cases = {
        "race": Case(bench_tire(), (220.0, 1120.0)),
        "small": Case(published("unicamp_small_tire"), (60.0, 160.0), 20.0, 1.0),
        "car": Case(read_tir(GOLDEN), (2000.0, 8000.0)),
    }
    for name, case in cases.items():
        if arguments.only in (None, name):
            compared(name, case, arguments.seeds)


if __name__ == "__main__":
    main()
