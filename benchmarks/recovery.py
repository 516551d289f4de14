"""Recovery of known coefficients by a fit: predictions, coverage of intervals, results from many initial values.

Complete tires of MF96, MF5.2 and MF6.1 (`tests/fitting/known_tires.py`) on the virtual bench with noise in Fx, Fy and
Mz, white and correlated over time.

- Predictions: root mean square difference from the exact forces relative to the noise, and coverage of the 95 %
  intervals, over fits from generic values to new noise. Finite intervals of coefficients that are not at a bound count.
  The range is that of the coverage of single fits.
- Coverage of the 95 % intervals of forces, slip stiffnesses and friction at loads and slips (`FitResult.interval`).
- Initial values: the true tire with every coefficient multiplied by 1 +- 30 % or 60 % at random is the start tire. A
  result is good if no channel differs from the best fit by more than a tenth of the noise.

With `--bootstrap N` also the coverage of the intervals of coefficients from a bootstrap of N replicates. With
`--results` each fit is stored as it finishes, and what the file has is not computed again; `--write` writes all stored
coverages into docs/recovery.md.

    python benchmarks/recovery.py [--quick] [--models mf96,mf52,mf61] [--noise white,correlated] [--seeds 100]
        [--starts 50] [--bootstrap N] [--results FILE [--write]] [--processes 2]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "fitting"))
from known_tires import CHANNELS, NOMINAL, SIZES, known_tire, moved, recorded
from recovery_table import PREDICTED, RecoveryTask, Refit, store, stored, write

from tirefmu.fitting import FitResult, fit
from tirefmu.fitting.resampling.bootstrap import bootstrap_of, replicate_tasks, replicates_of
from tirefmu.measurements import Recording
from tirefmu.tires import Tire

FloatArray = npt.NDArray[np.float64]
MODELS = ("mf96", "mf52", "mf61")
#: s, correlation time of the noise. The sample interval is 0.1 to 0.3 s.
CORRELATIONS = {"white": 0.0, "correlated": 1.0}
SHARES = (0.3, 0.6)
#: Operating conditions at which intervals are compared with the true tire, in adapted SAE.
CONDITIONS = pd.DataFrame(
    [
        {"Fz": load, "alpha": alpha, "kappa": kappa, "gamma": 0.02, "p": NOMINAL["p0"], "V": NOMINAL["V0"]}
        for load in (500.0, 1100.0, 1700.0, 2600.0)
        for alpha, kappa in ((0.01, 0.0), (0.04, 0.0), (0.15, 0.0), (0.0, 0.03), (0.0, 0.15), (0.05, 0.1))
    ]
)
#: Largest difference of a good result from the best one, relative to the noise.
GOOD = 0.1


def predicted(tire: Tire, recording: Recording) -> FloatArray:
    """Return the outputs of a tire at the inputs of a recording, divided by the noise, shape (n_channels, n)."""
    converted = tire.in_signs("adapted-sae")
    table = recording.with_signs("adapted-sae").table
    forces = converted.forces(**{name: table[name].to_numpy() for name in converted.inputs if name in table})
    return np.stack([forces[name] / SIZES[name] for name in CHANNELS])


def difference_of(one: Tire, other: Tire, recording: Recording) -> float:
    """Return the largest root mean square difference of a channel, relative to its noise."""
    difference = predicted(one, recording) - predicted(other, recording)
    return float(np.sqrt(np.mean(difference**2, axis=1)).max())


def coverage_of(result: FitResult, truth: Tire) -> tuple[int, int]:
    """Return the number of finite intervals that contain the true value, and the number of finite intervals."""
    tire, inside, counted = truth.in_signs(result.signs), 0, 0
    for coefficient in result.coefficients:
        if coefficient.determined and not coefficient.at_bound and np.isfinite(coefficient.interval):
            counted += 1
            inside += abs(coefficient.value - tire.values[coefficient.name]) <= coefficient.interval
    return inside, counted


def predictions_covered(result: FitResult, truth: Tire) -> dict[str, int]:
    """Return the number of intervals of each quantity that contain the true value."""
    true = truth.in_signs("adapted-sae").evaluate(CONDITIONS, signs="adapted-sae")
    covered = {}
    for quantity in PREDICTED:
        found = result.interval(quantity, CONDITIONS, signs="adapted-sae")
        inside = (found["lower"] <= true[quantity]) & (true[quantity] <= found["upper"])
        covered[quantity] = int(inside.sum())
    return covered


def bootstrap_coverage_of(result: FitResult, truth: Tire) -> tuple[int, int]:
    """Return the number of intervals of a bootstrap that contain the true value, and the number of intervals."""
    tire, inside, counted = truth.in_signs(result.signs), 0, 0
    bounded = {coefficient.name for coefficient in result.coefficients if coefficient.at_bound}
    for interval in result.bootstrap.intervals if result.bootstrap else ():
        if np.isfinite(interval.lower) and interval.name not in bounded:
            counted += 1
            inside += interval.lower <= tire.values[interval.name] <= interval.upper
    return inside, counted


def refitted(task: RecoveryTask) -> Refit:
    """Fit a recording of the known tire with the noise of a seed, from generic values."""
    truth = known_tire(task.model)
    recording = recorded(truth, task.rows, seed=task.seed, correlation_time=CORRELATIONS[task.noise])
    start = time.process_time()
    with threadpool_limits(limits=1, user_api="blas"):
        result = fit([recording], task.model, nominal=NOMINAL, sensor_errors=False)
        seconds = time.process_time() - start
        if task.replicates:
            tasks = replicate_tasks(result, [recording], task.replicates, task.seed)
            result = bootstrap_of(result, tasks, np.concatenate([replicates_of(task) for task in tasks]))
    return Refit(
        task, result.ok, difference_of(result.tire, truth, recording), *coverage_of(result, truth), seconds,
        len(CONDITIONS), predictions_covered(result, truth), *bootstrap_coverage_of(result, truth),
    )  # fmt: skip


def from_truth(model: str, rows: int) -> Tire:
    """Return the tire of the fit that starts from the true values, which is the reference result."""
    truth = known_tire(model)
    with threadpool_limits(limits=1, user_api="blas"):
        return fit([recorded(truth, rows)], model, start=truth).tire


def ended(model: str, share: float, rows: int, best: Tire, seed: int) -> tuple[float, bool]:
    """Return the difference of a result from the best one, for perturbed initial values, and whether the fit is ok."""
    truth = known_tire(model)
    recording = recorded(truth, rows)
    with threadpool_limits(limits=1, user_api="blas"):
        result = fit([recording], model, start=moved(truth, share, seed))
    return difference_of(result.tire, best, recording), result.ok


def print_refits(name: str, runs: Iterable[Refit]) -> None:
    """Print a line of the first table, and the coverages of its fits."""
    done = list(runs)
    shares = [run.covered / run.intervals for run in done]
    total = sum(run.covered for run in done) / sum(run.intervals for run in done)
    missed = [run.missed for run in done]
    print(
        f"{name:18}{len(done):6}{sum(run.ok for run in done):6}{np.median(missed):10.3f}{max(missed):8.3f}"
        f"{100 * total:10.1f} %{100 * min(shares):8.0f} .. {100 * max(shares):.0f} %"
        f"{np.median([run.intervals for run in done]):8.0f}{np.median([run.seconds for run in done]):8.2f}",
        flush=True,
    )
    predicted_shares = {
        quantity: sum(run.predictions_covered[quantity] for run in done) / (len(done) * len(CONDITIONS))
        for quantity in PREDICTED
    }
    if percentiles := sum(run.bootstrap_intervals for run in done):
        print(f"    coverage of the bootstrap: {sum(run.bootstrap_covered for run in done) / percentiles:.1%}")
    print("    coverage of predictions: " + ", ".join(f"{q} {share:.1%}" for q, share in predicted_shares.items()))


def all_refits(pool: ProcessPoolExecutor, tasks: Sequence[RecoveryTask], path: Path | None) -> list[Refit]:
    """Return the results of tasks in their order; those of the file are not computed again."""
    known = {refit.task: refit for refit in stored(path)}
    for future in as_completed([pool.submit(refitted, task) for task in tasks if task not in known]):
        refit = future.result()
        store(path, refit)
        known[refit.task] = refit
    return [known[task] for task in tasks]


def print_ends(name: str, ends: Iterable[tuple[float, bool]]) -> None:
    """Print a line of the second table."""
    done = list(ends)
    good = sum(ok and distance <= GOOD for distance, ok in done)
    far = max(distance for distance, _ in done)
    print(f"{name:18}{len(done):6}{good:6}{far:10.3f}", flush=True)


def main() -> None:
    """Run the requested fits and print two tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="8 seeds, 5 starts")
    parser.add_argument("--models", default=",".join(MODELS))
    parser.add_argument("--noise", default=",".join(CORRELATIONS))
    parser.add_argument("--seeds", type=int, default=100, help="refits of each model and kind of noise")
    parser.add_argument("--starts", type=int, default=50, help="of each model and size")
    parser.add_argument("--rows", type=int, default=6000)
    parser.add_argument("--bootstrap", type=int, default=0, help="replicates; 0: no bootstrap")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--results", type=Path, help="file of the single fits: continued if it exists")
    parser.add_argument(
        "--write",
        action="store_true",
        help="write the coverages of that file into docs/recovery.md; other lines of its table stay",
    )
    given = parser.parse_args()
    if given.write and not given.results:
        parser.error("--write writes what a file of --results has")
    seeds, starts = (8, 5) if given.quick else (given.seeds, given.starts)
    models = given.models.split(",")
    with ProcessPoolExecutor(given.processes) as pool:
        if seeds:
            print(f"{'':18}{'fits':>6}{'ok':>6}{'missed':>10}{'most':>8}{'coverage':>12}{'range':>15}"
                  f"{'intervals':>10}{'CPU s':>6}")  # fmt: skip
        for model in models if seeds else ():
            for kind in given.noise.split(","):
                tasks = [RecoveryTask(model, kind, given.rows, seed, given.bootstrap) for seed in range(seeds)]
                print_refits(f"{model}, {kind}", all_refits(pool, tasks, given.results))
        if starts:
            print(f"\n{'':18}{'starts':>6}{'good':>6}{'farthest':>10}")
        for model in models if starts else ():
            best = pool.submit(from_truth, model, given.rows).result()
            for share in SHARES:
                found = pool.map(partial(ended, model, share, given.rows, best), range(starts))
                print_ends(f"{model}, +-{100 * share:.0f} %", found)
    if given.write:
        write(list(stored(given.results)))


if __name__ == "__main__":
    main()
