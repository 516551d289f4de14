"""The laws of states: exact, whatever the size of the step, and equal in every language."""

from __future__ import annotations

import ctypes
import subprocess
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tirefmu.generated.numpy import state_laws as laws
from tirefmu.symbolic.laws import LAWS
from tirefmu.symbolic.printers.line_functions import line_function_files
from tirefmu.tires.code.casadi_code import ARRAYS
from tirefmu.tires.code.compiler import find_compiler

RANDOM = np.random.default_rng(4)


def solved(rate, x, end):
    return solve_ivp(rate, (0.0, end), [x], method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]


@pytest.mark.parametrize("way", [0.0, 1e-9, 0.01, 0.3, 4.0])
def test_a_lag_is_the_solution_of_its_equation(way):
    x, u, half, end = 0.3, 1.0, 0.2, -0.7
    straight = solved(lambda t, y: way * (u + (end - u) * t - y), x, 1.0)
    assert laws.lag(x, u, end, way) == pytest.approx(straight, rel=1e-10)
    assert laws.lag_held(x, u, way) == pytest.approx(laws.lag(x, u, u, way), rel=1e-14)
    slope, bend = 4 * half - 3 * u - end, 2 * (u - 2 * half + end)
    curved = solved(lambda t, y: way * (u + slope * t + bend * t * t - y), x, 1.0)
    assert laws.lag_curved(x, u, half, end, way) == pytest.approx(curved, rel=1e-10)
    added = solved(lambda t, y: 0.4 * (u + slope * t + bend * t * t), x, 1.0)
    assert laws.sum_curved(x, u, half, end, 0.4) == pytest.approx(added, rel=1e-12)


def test_a_lag_keeps_its_value_on_no_way_and_has_its_target_after_an_infinite_one():
    assert laws.lag_held(0.3, -0.7, 0.0) == 0.3
    assert laws.lag_held(0.3, -0.7, np.inf) == -0.7


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.3, 40.0])
@pytest.mark.parametrize("way", [1e-6, 0.01, 0.4, 3.0])
def test_an_oscillator_is_the_matrix_exponential(way, ratio):
    """Any damping, short and long steps, with a target on a parabola; the speed is compared per step."""
    x, v, u, half, end, h = 0.3, 2.0, 1.0, 0.2, -0.7, 0.01
    slope, bend, loss = 4 * half - 3 * u - end, 2 * (u - 2 * half + end), 2.0 * ratio * way
    matrix = np.zeros((5, 5))
    matrix[0, 1] = matrix[2, 3] = matrix[3, 4] = 1.0
    matrix[1, :3] = -(way**2), -loss, way**2
    exact = expm(matrix) @ [x, v * h, u, slope, 2 * bend]
    ends = [law(x, v, u, half, end, way, loss, h) for law in (laws.oscillator, laws.oscillator_speed)]
    np.testing.assert_allclose(ends, [exact[0], exact[1] / h], rtol=1e-12, atol=1e-13 * (1.0 + way) / h)


@pytest.mark.parametrize("ratio", [0.0, 1.0, 40.0])
def test_an_oscillator_at_rest_has_all_digits_after_a_short_step(ratio):
    u, half, end, way, h = 1.0, 0.2, -0.7, 1e-9, 0.01
    slope, bend = 4 * half - 3 * u - end, 2 * (u - 2 * half + end)
    given = (0.0, 0.0, u, half, end, way, 2.0 * ratio * way, h)
    assert laws.oscillator(*given) == pytest.approx(way**2 * (u / 2 + slope / 6 + bend / 12), rel=1e-6)
    assert laws.oscillator_speed(*given) == pytest.approx(way**2 * (u + slope / 2 + bend / 3) / h, rel=1e-6)


def test_an_oscillator_without_a_step_remains():
    assert laws.oscillator(0.3, 2.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0) == 0.3
    assert laws.oscillator_speed(0.3, 2.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0) == 2.0


def test_the_series_of_a_short_step_continues_the_formula():
    arguments = (0.3, 1.0, 0.2, -0.7)
    below, above = laws.lag_curved(*arguments, 0.05 - 1e-12), laws.lag_curved(*arguments, 0.05 + 1e-12)
    assert below == pytest.approx(above, abs=2e-12)


def test_without_a_length_a_state_has_its_target():
    assert laws.lag(0.3, 1.0, -0.7, np.inf) == -0.7
    assert laws.lag_curved(0.3, 1.0, 0.2, -0.7, np.inf) == pytest.approx(-0.7, rel=1e-14)


#: Paths that turn, also through the limits of play.
TURNS = (0.0, 0.1, 0.08, -0.05, 0.0)


@pytest.mark.parametrize("law", [laws.dahl, laws.play])
def test_a_state_depends_on_the_path_alone(law):
    """One step against 25 along each part of a path that turns: only the turns count."""
    z, fine, width, follower = -0.2, -0.2, 0.03, 0.2 * 0.03
    for start, end in pairwise(TURNS):
        z = law(z, start, end, width)
        for a, b in pairwise(np.linspace(start, end, 26)):
            fine = law(fine, a, b, width)
        follower = min(max(follower, end - width), end + width)
        assert z == pytest.approx(fine, abs=1e-14)
        if law is laws.play:  # the follower of a backlash
            assert end - width * z == pytest.approx(follower, abs=1e-15)
    assert -1.0 < z < 1.0


@pytest.mark.parametrize(("law", "of_size", "z", "width"),
                         [(laws.dahl, laws.dahl_size, 0.2, 0.03), (laws.play, laws.play_size, -0.8, 0.15)])  # fmt: skip
@pytest.mark.parametrize(("path", "turns"), [
    (((0.1, 0.0), (-0.2, 0.0)), True), (((0.1, 0.05), (-0.08, 0.02)), True), (((0.01, 0.02), (0.02, 0.03)), False),
])  # fmt: skip
def test_the_size_of_a_slip_is_split_where_it_is_least(law, of_size, z, width, path, turns):
    """A path through or past zero in one step is the path in many: the size falls first, then grows."""
    fine = z
    for p, q in pairwise(np.linspace(*path, 401)):
        fine = of_size(fine, *p, *q, width)
    once = of_size(z, *path[0], *path[1], width)
    assert once == pytest.approx(float(fine), abs=1e-12)
    one_way = law(z, *(np.hypot(*end) for end in path), width)
    assert (abs(once - one_way) > 0.01) == turns


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Return the laws of the C header as a library."""
    folder = tmp_path_factory.mktemp("laws")
    (folder / "state_laws.h").write_text(line_function_files()["c/state_laws.h"], encoding="ascii")
    called = [
        f"double call_{law.name}({', '.join('double ' + a for a in law.arguments)})"
        f" {{ return state_{law.name}({', '.join(law.arguments)}); }}"
        for law in LAWS.values()
    ]
    (folder / "laws.c").write_text('#include "state_laws.h"\n' + "\n".join(called), encoding="ascii")
    command = [*find_compiler(), "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]
    subprocess.run([*command, "laws.c", "-o", "laws.so", "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "laws.so"))


@pytest.mark.parametrize("name", LAWS)
def test_the_languages_agree(compiled, name):
    n = len(LAWS[name].arguments)
    in_c = getattr(compiled, f"call_{name}")
    in_c.restype, in_c.argtypes = ctypes.c_double, [ctypes.c_double] * n
    symbols = [ca.SX.sym(argument) for argument in LAWS[name].arguments]
    function = ca.Function(name, symbols, [getattr(laws, name)(*symbols, xp=ARRAYS)])
    for _ in range(40):
        values = [*RANDOM.uniform(-0.2, 0.2, n - 1), RANDOM.choice([0.0, 1e-4, 0.03, 0.9]) or 0.02]
        if name.startswith("oscillator"):  # every branch: short and long steps, much damping
            values[-3:] = *(RANDOM.uniform(0.0, 3.0, 2) ** 2), 0.02
        expected = float(getattr(laws, name)(*values))
        assert in_c(*values) == pytest.approx(expected, rel=1e-13, abs=1e-15)
        assert float(function(*values)) == pytest.approx(expected, rel=1e-13, abs=1e-15)
