"""Pairs of elementary calls: the same bits as call by call, with vector types and without them."""

from __future__ import annotations

import ctypes
from pathlib import Path

import mpmath
import numpy as np
import pytest

import tirefmu.generated
from tirefmu.symbolic.models import model_named
from tirefmu.symbolic.printers.definitions import INCLUDES, definitions
from tirefmu.tires.code.compiler import shared_library
from tirefmu.tires.code.numpy_code import numpy_code

FOLDER = Path(tirefmu.generated.__file__).parent / "c"
#: Code for any processor, for this one, and for compilers without vector types. Each operation is rounded once.
BUILDS = {"plain": [], "native": ["-march=native"], "alone": ["-DONE_AT_A_TIME"]}
SINGLE = ("sin", "cos", "tan", "atan", "exp")
#: Among arguments of every size, those that go to math.h: huge angles, zeros, subnormal numbers, infinities, NaN.
SPECIAL = [0.0, -0.0, 5e-324, 1e-310, 1.0, -1.0, 1e7, 1.1e7, 1e300, -1e300, 700.0, -701.0, np.inf, -np.inf, np.nan]
LOOP = "for (int i = 0; i < n; i++)\n        results[i] = "
PAIRS = """
void in_pairs_{name}(const double x[], const double y[], double results[], int n)
{{
    for (int i = 0; i < n; i += 2) {{
        const pair values = fast_pair_{name}({arguments});
        for (int k = 0; k < 2; k++)
            results[i + k] = PAIR_AT(values, k);
    }}
}}
"""


def source():
    """Return functions that apply each elementary function to arrays: one number at a time, and in pairs."""
    head = "(const double x[], const double y[], double results[], int n)"
    parts = [f"void single_{name}{head}\n{{\n    (void)y;\n    {LOOP}fast_{name}(x[i]);\n}}" for name in SINGLE]
    parts.append(f"void single_pow{head}\n{{\n    {LOOP}fast_pow(x[i], y[i]);\n}}")
    parts.append(f"void single_shifted_sin{head}\n{{\n    {LOOP}y[i] == 0.0 ? fast_sin(x[i]) : fast_cos(x[i]);\n}}")
    for name in ("shifted_sin", "tan", "atan", "exp", "pow"):
        arrays = "xy" if name in ("shifted_sin", "pow") else "x"
        arguments = ", ".join(f"PAIR({array}[i], {array}[i + 1])" for array in arrays)
        parts.append(PAIRS.format(name=name, arguments=arguments))
    code = "\n".join(parts)
    return f"{INCLUDES}\n{definitions(code)}\n{code}"


def built(name, path, flags, headers=()):
    flags = ["-fvisibility=default", "-ffp-contract=off", "-O2", *flags]
    return ctypes.CDLL(str(shared_library(name, [path], headers=headers, flags=flags)))


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pairs")
    path = folder / "pairs.c"
    path.write_text(source(), encoding="ascii")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIREFMU_CACHE", str(folder / "cache"))
        yield {build: built("pairs", path, flags) for build, flags in BUILDS.items()}


def arguments(name):
    """Return numbers of every size, the special ones in both places of a pair."""
    rng = np.random.default_rng(7)
    drawn = rng.choice([-1.0, 1.0], 400) * 10 ** rng.uniform(-12, 12, 400)
    typical = rng.uniform(-20.0, 20.0, 400)
    special = np.concatenate([np.insert(rng.uniform(0.5, 2.0, 3), k, value) for value in SPECIAL for k in range(4)])
    x = np.concatenate([drawn, typical, special])
    y = rng.uniform(-3.0, 3.0, len(x)) if name == "pow" else rng.choice([0.0, 0.5], len(x))
    return (np.abs(x) if name == "pow" else x), y


def applied(library, kind, name, x, y):
    results = np.empty_like(x)
    pointers = (array.ctypes.data_as(ctypes.c_void_p) for array in (x, y, results))
    getattr(library, f"{kind}_{name}")(*pointers, len(x))
    return results


def bits(values):
    """Return the bits, with one NaN for all: its sign and payload are no results."""
    return np.where(np.isnan(values), np.nan, values).view(np.uint64)


@pytest.mark.parametrize("name", ["shifted_sin", "tan", "atan", "exp", "pow"])
def test_pairs_are_single_calls_to_the_last_bit(library, name):
    x, y = arguments(name)
    single = bits(applied(library["plain"], "single", name, x, y))
    for build, code in library.items():
        for kind in ("single", "in_pairs"):
            assert np.array_equal(bits(applied(code, kind, name, x, y)), single), (build, kind)


def test_error_of_a_power_in_units_in_the_last_place(library):
    rng = np.random.default_rng(8)
    x, y = 10 ** rng.uniform(-60.0, 6.0, 400), rng.uniform(-2.0, 2.0, 400)
    results = applied(library["plain"], "in_pairs", "pow", x, y)
    with mpmath.workprec(160):
        exact = [mpmath.mpf(a) ** mpmath.mpf(b) for a, b in zip(x.tolist(), y.tolist(), strict=True)]
        errors = [abs((mpmath.mpf(r) - e) / e) for r, e in zip(results.tolist(), exact, strict=True)]
    assert (np.array(errors, dtype=float) <= (3.0 + np.abs(y * np.log(x))) * np.finfo(float).eps).all()


def test_forces_are_the_same_with_and_without_vectors(tmp_path, monkeypatch):
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "cache"))
    symbolic_model = model_named("mf61")
    rng = np.random.default_rng(9)
    values = {name: declared.generic or 0.01 for name, declared in symbolic_model.coefficients.items()}
    values |= {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    parameters = np.array([values.get(name, 0.0) for name in symbolic_model.parameters])
    ranges = {"kappa": (-1.5, 1.5), "alpha": (-1.4, 1.4), "gamma": (-0.3, 0.3), "Fz": (-100.0, 9000.0),
              "p": (0.0, 3e5), "V": (-30.0, 30.0), "phit": (0.0, 0.0)}  # fmt: skip
    rows = np.stack([rng.uniform(*ranges[quantity.name], 300) for quantity in symbolic_model.inputs], axis=1)
    results = {}
    for build, flags in BUILDS.items():
        code = built("mf61", FOLDER / "mf61.c", ["-O1", *flags], [FOLDER / "mf61.h"])
        results[build] = np.empty((len(rows), len(symbolic_model.outputs)))
        for row, result in zip(rows, results[build], strict=True):
            code.mf61_forces(*(array.ctypes.data_as(ctypes.c_void_p) for array in (row, parameters, result)))
    for build, forces in results.items():
        assert np.array_equal(bits(forces), bits(results["plain"])), build
    with np.errstate(all="ignore"):
        exact = numpy_code(symbolic_model).forces(np.ascontiguousarray(rows.T), parameters).T
    assert results["plain"] == pytest.approx(exact, rel=1e-12, abs=1e-9, nan_ok=True)
