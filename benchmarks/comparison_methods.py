"""What regressions of the residual reach on the memory suite: sparse regression (PySINDy) and a Gaussian process.

The baseline model is fitted as a diagnosis does, then its residual is regressed on the slips, the load, the speed, the
inclination and the rates of slips and load. Both methods correct the forces; neither identifies an effect. Reported are
the reduction of the squared error on other manoeuvres, without noise, as for the diagnosis, and the share of the true
residuals there that are inside the method's 95 % intervals.

    python benchmarks/comparison_methods.py [--kinds single] [--every 1] [--table docs/discovery.md]
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from diagnosis.case import Case
from discovery import version_text
from discovery_suites import SUITES
from discovery_table import put_table, split_page

from tirefmu.diagnosis.diagnose import NOMINAL_COEFFICIENTS
from tirefmu.diagnosis.probing.baseline_fit import fit_baseline
from tirefmu.diagnosis.recording.signals import FORMULA_SIGNS, signals_of
from tirefmu.diagnosis.verdict.improved_tire import tire_of
from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.tires import Tire
from tirefmu.tires.signs import convert_signs

FloatArray = npt.NDArray[np.float64]
#: A method returns mean and standard deviation of the residual at other rows, shape (m,) each.
Method = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]

#: Polynomial degree of the library of the sparse regression; thresholds (in standard deviations of the noise), of which
#: the best on every fifth tenth of the recording is used; models of the ensemble.
DEGREE, THRESHOLDS, MODELS = 3, (0.1, 0.3, 1.0), 20
#: Rows of the Gaussian process, whose computing time grows with their cube.
GAUSSIAN_ROWS = 500
#: Slip at which a saturating feature has three quarters of its range.
SLIP = 0.06


@dataclass(frozen=True)
class Reached:
    """What a method reaches in a case."""

    case: str
    method: str
    closed: float
    covered: float
    seconds: float


def features(named: Mapping[str, FloatArray], t: FloatArray, tire: Tire) -> FloatArray:
    """Return the variables of the regressions, of order one, shape (n, 9)."""
    slip, kappa, load = np.tan(named["alpha"]), named["kappa"], named["Fz"] / tire.values["FNOMIN"]
    speed = named["V"] / tire.values["LONGVL"] - 1.0
    rates = [np.gradient(one, t) for one in (slip, kappa, load)]
    saturating = [np.tanh(slip / SLIP), np.tanh(kappa / SLIP), *(np.tanh(rate) for rate in rates)]
    return np.stack([*saturating, 5.0 * slip, load - 1.0, speed, 20.0 * named["gamma"]], axis=1)


def sparse_regression(x: FloatArray, y: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an ensemble of sequentially thresholded regressions on polynomials (PySINDy)."""
    import pysindy

    library = pysindy.PolynomialLibrary(degree=DEGREE)
    columns, others = (np.asarray(library.fit_transform(one)) for one in (x, at))
    held = np.arange(len(y)) * 10 // len(y) % 5 == 2

    def ensemble(rows: npt.NDArray[np.bool_], threshold: float) -> FloatArray:
        optimizer = pysindy.EnsembleOptimizer(
            pysindy.STLSQ(threshold=threshold, alpha=1.0), bagging=True, n_models=MODELS
        )
        optimizer.fit(columns[rows], y[rows, None])
        return np.array(optimizer.coef_list)[:, 0]

    def error(threshold: float) -> float:
        return float(np.mean((y[held] - columns[held] @ ensemble(~held, threshold).mean(axis=0)) ** 2))

    coefficients = ensemble(np.ones(len(y), dtype=bool), min(THRESHOLDS, key=error))
    predicted = others @ coefficients.T
    return predicted.mean(axis=1), predicted.std(axis=1)


def gaussian_process(x: FloatArray, y: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a Gaussian process with a length of its own for each variable (scikit-learn)."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    rows = np.random.default_rng(1).choice(len(y), min(GAUSSIAN_ROWS, len(y)), replace=False)
    kernel = ConstantKernel(1.0) * RBF(np.ones(x.shape[1]), (0.1, 1e3)) + WhiteKernel(1.0)
    model = GaussianProcessRegressor(kernel, normalize_y=True).fit(x[rows], y[rows])
    mean, deviation = model.predict(at, return_std=True)
    noise = model.kernel_.k2.noise_level * float(np.std(y[rows])) ** 2
    return mean, np.sqrt(np.maximum(deviation**2 - noise, 0.0))


METHODS: Mapping[str, Method] = {"PySINDy": sparse_regression, "Gaussian process": gaussian_process}


def reached(case: Case) -> list[Reached]:
    """Return what each method reaches in a case."""
    values = {name: value for key, value in case.nominal.items() for name in NOMINAL_COEFFICIENTS[key]}
    start = Tire(DEFAULT_MODEL, values, effects=case.effects, signs=FORMULA_SIGNS)
    signals = signals_of(case.table, start, case.signs)
    problem, solution = fit_baseline(start, signals, known=False)
    base = tire_of(start, problem, solution, ())
    test = convert_signs(case.test, case.signs, FORMULA_SIGNS)
    computed = base.evaluate(test.drop(columns=list(signals.channels)), signs=FORMULA_SIGNS)
    x = features(signals.named(), signals.t[signals.rows], base)
    inputs = {name: computed[name].to_numpy(dtype=np.float64) for name in base.inputs}
    at = features(inputs, test["t"].to_numpy(dtype=np.float64), base)
    noise = 1.0 / problem.inverse_noise.max(axis=1)
    found = []
    for name, method in METHODS.items():
        began, before, after, inside = time.process_time(), 0.0, 0.0, []
        for channel, residual, used, scale in zip(
            signals.channels, solution.residual, problem.inverse_noise > 0.0, noise, strict=True
        ):
            true = (test[channel] - computed[channel]).to_numpy(dtype=np.float64) / scale
            mean, deviation = method(x[used], residual[used] / scale, at)
            before, after = before + float(np.mean(true**2)), after + float(np.mean((true - mean) ** 2))
            inside.append(np.abs(true - mean) <= 1.96 * deviation)
        seconds = time.process_time() - began
        found.append(Reached(case.name, name, 1.0 - after / before, float(np.mean(inside)), seconds))
    return found


def table_of(results: list[Reached], source: str) -> str:
    """Return the table in Markdown."""
    cases = len({one.case for one in results})
    lines = [
        f"Computed by {source}: {cases} recordings.", "",
        "| method | reduction of the squared error: median | least | largest | inside the 95 % intervals: median"
        " | CPU seconds |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for name in METHODS:
        own = [one for one in results if one.method == name]
        closed, covered, seconds = (
            np.array([getattr(one, key) for one in own]) for key in ("closed", "covered", "seconds")
        )
        lines.append(
            f"| {name} | {np.median(closed):.3f} | {closed.min():.3f} | {closed.max():.3f}"
            f" | {100.0 * np.median(covered):.0f} % | {np.median(seconds):.1f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Run the methods and print a line per case and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", default="single", help="kinds of the memory suite, default: single")
    parser.add_argument("--every", type=int, default=1, help="every n-th case of a kind")
    parser.add_argument("--table", type=Path, help="a Markdown file in which the table is replaced")
    options = parser.parse_args()
    suite = SUITES["memory"]
    for kind in (kinds := options.kinds.split(",")):
        if kind not in suite.number_of_cases:
            parser.error(f"--kinds {kind}: not one of {', '.join(suite.number_of_cases)}")
    if options.table:
        split_page(options.table, "comparison")
    warnings.simplefilter("ignore")  # bounds of the kernel, empty regressions
    results = []
    for kind in kinds:
        for number in range(0, suite.number_of_cases[kind], options.every):
            for one in reached(suite.case_of(kind, number)):
                results.append(one)
                print(f"{kind}:{number} {one.method}: closed {one.closed:.3f}, {100 * one.covered:.0f} % inside,"
                      f" {one.seconds:.1f} s ({one.case})", flush=True)  # fmt: skip
    arguments = f" --kinds {options.kinds}" * (options.kinds != "single") + f" --every {options.every}" * (
        options.every != 1
    )
    table = table_of(results, f"`python benchmarks/comparison_methods.py{arguments}`, {version_text()}")
    print("\n" + table)
    if options.table:
        put_table(options.table, "comparison", table)


if __name__ == "__main__":
    main()
