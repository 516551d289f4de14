"""The result of a fit does not depend on rounding errors: other processors are emulated in several ways.

`TIREFMU_PERTURB=1` (make perturb) adds instruction sets, noise, all channels, the measured recordings and a diagnosis.
"""

from __future__ import annotations

import os
import platform
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tirefmu.diagnosis import diagnose
from tirefmu.fitting import fit
from tirefmu.fitting.problem import influence, weighted_residuals, weights
from tirefmu.measurements import Noise, Recording, read_recording
from tirefmu.tires.code import kernel, selection
from tirefmu.tires.code.normal_equations import equations_by_chunks

from ..diagnosis.suite import make_case
from ..relatives import slow_but

LARGE = os.environ.get("TIREFMU_PERTURB") == "1"
#: Largest difference of predictions, relative to the root mean square residual: a tenth of a standard error of each
#: coefficient changes them by a tenth of sqrt(n coefficients / n independent rows) of the noise, 0.02 here.
SHARE = 0.02


def features():
    """Return the instruction sets of x86 that this processor has."""
    described = Path("/proc/cpuinfo")
    if platform.machine() not in ("x86_64", "AMD64") or not described.is_file():
        return []
    flags = described.read_text(encoding="utf-8").partition("flags")[2].partition("\n")[0].split()
    return ["x86-64", *(["x86-64-v3"] if "avx2" in flags else []), *(["x86-64-v4"] if "avx512vl" in flags else [])]


@contextmanager
def kernels(machine):
    """Build the kernels for another instruction set."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "FLAGS", kernel.flags(machine))
        selection._code_for.cache_clear()
        yield
    selection._code_for.cache_clear()


@contextmanager
def chunks(rows):
    """Sum over chunks of rows, with the matrix products of NumPy instead of the kernel's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(weighted_residuals, "normal_equations", partial(equations_by_chunks, size=rows))
        for module in (weighted_residuals, influence):
            patch.setattr(module, "CHUNK", rows)
        yield


def last_digits(recordings):
    """Return recordings with every number changed by a relative 1e-15, up or down."""
    rng = np.random.default_rng(5)
    changed = []
    for recording in recordings:
        numbers = recording.table.drop(columns="t", errors="ignore").select_dtypes("float64")
        factors = 1.0 + 1e-15 * rng.choice([-1.0, 1.0], numbers.shape)
        changed.append(replace(recording, table=recording.table.assign(**(numbers * factors))))
    return changed


def perturbed(how, recordings, run):
    """Return the result of a run with a perturbation."""
    if how == "last digits":
        return run(last_digits(recordings))
    if how == "files in another order":
        return run(recordings[::-1])
    if how.startswith("chunks"):
        with chunks(int(how.split()[-1])):
            return run(recordings)
    with kernels(how):
        return run(recordings)


#: Perturbations of digits only, and with the order of the recordings.
DIGITS = ("last digits", "chunks of 100", *(("chunks of 1000", *features()) if LARGE else ()))
WAYS = (*DIGITS, "files in another order")


def findings(result):
    """Return the qualitative results of a fit."""
    return {
        "status": result.status,
        "stages": [(stage.name, stage.converged) for stage in result.stages],
        "at a bound": sorted(c.name for c in result.coefficients if c.at_bound),
        "determined": sorted(c.name for c in result.coefficients if c.determined),
        "satisfied": sorted(margin.name for margin in result.margins if margin.margin >= -1e-6),
        "active": sorted(margin.name for margin in result.margins if abs(margin.margin) < 1e-5),
        "directions": sorted(sorted(direction.coefficients) for direction in result.directions),
    }


def agree(result, reference, recordings):
    """Compare qualitative results and predictions of two fits."""
    assert findings(result) == findings(reference)
    for recording in recordings:
        one, other = (each.tire.evaluate(recording.table, signs=recording.signs) for each in (result, reference))
        for channel in reference.channels:
            if channel.recording == recording.source:
                name, root = channel.channel, np.sqrt(np.mean(np.square(recording.table[channel.channel])))
                apart = float(np.sqrt(np.mean(np.square(one[name] - other[name]))))
                assert apart <= SHARE * max(channel.rmse, weights.MIN_NOISE * root), name


@pytest.fixture(scope="module", params=["exact", *(["noisy"] if LARGE else [])])
def small(request, known, make):
    """Return two recordings of one tire, a function that fits them, and its result."""
    noise = Noise() if request.param == "noisy" else None
    made = make.bench if LARGE else make.sideways
    parts = [made(make.other_tire(1), cambers=cambers, noise=noise) for cambers in ((0.0, 2.0), (4.0,))]
    recordings = [replace(part, source=name) for part, name in zip(parts, ("upright", "inclined"), strict=True)]

    def run(given):
        return fit(given, effects=make.effects, nominal=make.nominal, screening=False)

    return recordings, run, run(recordings)


@pytest.mark.parametrize("how", slow_but(("last digits", "files in another order"), WAYS))
def test_a_perturbed_fit_has_the_same_result(small, how):
    recordings, run, reference = small
    assert reference.status == "converged"
    agree(perturbed(how, recordings, run), reference, recordings)


@pytest.fixture(scope="module")
def measured(data_folder):
    recordings = [read_recording(data_folder / name) for name in ("cornering.mat", "drivebrake.mat")]
    return recordings, fit(recordings, "mf61")


@pytest.mark.skipif(not LARGE, reason="TIREFMU_PERTURB=1")
@pytest.mark.parametrize("how", WAYS)
def test_a_perturbed_fit_of_measured_recordings_has_the_same_result(measured, how):
    recordings, reference = measured
    result = perturbed(how, recordings, lambda given: fit(given, "mf61"))
    agree(result, reference, recordings)


@pytest.fixture(scope="module")
def diagnosed():
    """Return a recording of a tire with an effect that the baseline model does not have, and its diagnosis."""
    case = make_case(1, ("camber_thrust",))

    def run(given):
        found = diagnose(given[0].table, signs=case.signs, effects=case.effects, nominal=case.nominal)
        verdict = found.verdict.split("(")[0]  # numbers follow
        return verdict, [each.effect for each in found.found]

    recordings = [Recording(case.table, case.signs, "made")]
    return recordings, run, run(recordings)


@pytest.mark.skipif(not LARGE, reason="TIREFMU_PERTURB=1")
@pytest.mark.parametrize("how", DIGITS)
def test_a_perturbed_diagnosis_has_the_same_result(diagnosed, how):
    recordings, run, reference = diagnosed
    assert reference[1]
    assert perturbed(how, recordings, run) == reference
