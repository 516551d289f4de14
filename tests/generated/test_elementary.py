"""The elementary functions of the C code against many digits, for scalars and in the lanes of vector registers."""

from __future__ import annotations

import ctypes

import mpmath
import numpy as np
import pytest

from tirefmu.symbolic.printers.definitions import INCLUDES
from tirefmu.symbolic.printers.definitions import KERNEL, definitions
from tirefmu.tires.code.kernel import FLAGS
from tirefmu.tires.code.compiler import CompilerError, shared_library

#: Largest error in units in the last place that the header promises.
PROMISED = 3.0
RANGES = {
    "sin": ("angles", mpmath.sin),
    "cos": ("angles", mpmath.cos),
    "tan": ("angles", mpmath.tan),
    "atan": ("slopes", mpmath.atan),
    "exp": ("exponents", mpmath.exp),
    "log": ("positive", mpmath.log),
}
SCALAR = ("sin", "cos", "tan", "atan", "exp")
CASES = [("fast", name) for name in SCALAR] + [("lanes", name) for name in RANGES]
FUNCTION = """
void {kind}_all_{name}(const double x[], double y[], int n)
{{
    {loop}
}}
"""
LOOPS = {
    "fast": "for (int i = 0; i < n; i++)\n        y[i] = fast_{name}(x[i]);",
    "lanes": "for (int i = 0; i < n; i += LANES)\n"
    "        *(lanes_in_array *)(y + i) = lanes_{name}(*(const lanes_in_array *)(x + i));",
}


def built(folder, flags):
    functions = "\n".join(FUNCTION.format(kind=k, name=n, loop=LOOPS[k].format(name=n)) for k, n in CASES)
    source = folder / "elementary.c"
    source.write_text(
        "\n".join([INCLUDES, "#define WIDE 1", definitions(functions, KERNEL), functions]), encoding="ascii"
    )
    return ctypes.CDLL(str(shared_library("elementary", [source], flags=["-fvisibility=default", "-O2", *flags])))


@pytest.fixture(scope="module", params=FLAGS, ids=("all", "native", "plain")[: len(FLAGS)])
def library(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("elementary")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIREFMU_CACHE", str(folder / "cache"))
        try:
            return built(folder, request.param)
        except CompilerError:
            pytest.skip("this compiler does not take these flags")


def points(kind, n=512):
    rng = np.random.default_rng(3)
    drawn = {
        "angles": np.concatenate([rng.uniform(-8, 8, n // 2), rng.uniform(-1e6, 1e6, n // 2)]),
        "slopes": rng.choice([-1, 1], n)
        * 10 ** np.concatenate([rng.uniform(-1, 2, n // 2), rng.uniform(-9, 9, n // 2)]),
        "exponents": rng.uniform(-690, 690, n),
        "positive": np.concatenate([rng.uniform(0.5, 2.0, n // 2), 10 ** rng.uniform(-300, 300, n // 2)]),
    }
    return drawn[kind]


def applied(library, kind, name, x):
    y = np.empty_like(x)
    getattr(library, f"{kind}_all_{name}")(x.ctypes.data_as(ctypes.c_void_p), y.ctypes.data_as(ctypes.c_void_p), len(x))
    return y


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_error_in_units_in_the_last_place(library, kind, name):
    over, exact = RANGES[name]
    x = points(over)
    y = applied(library, kind, name, x)
    with mpmath.workprec(160):
        errors = [
            abs(mpmath.mpf(float(b)) - exact(mpmath.mpf(float(a)))) / mpmath.mpf(float(np.spacing(abs(b))))
            for a, b in zip(x, y, strict=True)
        ]
    assert max(errors) < PROMISED


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_nan_infinity_and_huge_arguments(library, kind, name):
    x = np.array([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e9, -1.0, 0.0])
    y = applied(library, kind, name, x)
    with np.errstate(all="ignore"):
        true = getattr(np, name)(x)
    assert np.isnan(y[0])
    right = np.isclose(y, true, rtol=1e-13, atol=0, equal_nan=True)
    if kind == "lanes":  # right, or NaN, which the caller computes again
        assert (right | np.isnan(y)).all()
    else:
        assert right.all()
