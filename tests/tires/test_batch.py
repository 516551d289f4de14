"""The batch kernels: the same numbers as NumPy, whatever the rows and the machine."""

from __future__ import annotations

import re
from importlib import import_module
from importlib.resources import files

import numpy as np
import pytest

from tirefmu.symbolic.added import read_effect
from tirefmu.symbolic.models import MODELS
from tirefmu.tires.code import (
    MANY_ROWS,
    WeightedRows,
    chosen_derivatives,
    code_for,
    fastest_code,
    kernel,
    normal_equations,
    numpy_code,
    selection,
)
from tirefmu.tires.code.compiler import CompilerError
from tirefmu.tires.code.normal_equations import STEP, TILE

#: Rows of a block in the kernels.
BLOCK = 64
#: Rounding of the terms of a force, relative to the largest force.
ROUNDING = 1e-12


@pytest.fixture(params=MODELS)
def model(request):
    return request.param


@pytest.fixture
def parameters(model):
    return values_of(MODELS[model])


def values_of(symbolic_model, **values):
    """Return parameters of a generic tire, whose other coefficients are 0.01, with the default options."""
    given = {name: declared.generic or 0.01 for name, declared in symbolic_model.coefficients.items()}
    given |= {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, **values}
    return np.array([given.get(name, 0.0) for name in symbolic_model.parameters])


def rows_of(model, n, seed=1):
    """Return n rows without turn slip."""
    rng = np.random.default_rng(seed)
    ranges = {"kappa": (-0.4, 0.4), "alpha": (-0.4, 0.4), "gamma": (-0.1, 0.1), "Fz": (100.0, 8000.0)}
    ranges |= {"p": (1.5e5, 3e5), "V": (5.0, 40.0), "phit": (0.0, 0.0)}
    return np.stack([rng.uniform(*ranges[quantity.name], n) for quantity in MODELS[model].inputs])


def row_of(model, name):
    return [quantity.name for quantity in MODELS[model].inputs].index(name)


def by_force(model, result):
    """Return a result as (n_forces, ...), rows last."""
    return result.reshape(len(MODELS[model].outputs), -1)


def assert_same(model, answer, expected):
    assert np.array_equal(np.isnan(answer), np.isnan(expected))
    for mine, theirs in zip(by_force(model, answer), by_force(model, expected), strict=True):
        there = np.isfinite(theirs)
        assert np.array_equal(mine[~there], theirs[~there], equal_nan=True)
        error = np.abs(mine[there] - theirs[there])
        assert np.max(error, initial=0.0) <= ROUNDING * np.max(np.abs(theirs[there]), initial=0.0)


@pytest.mark.parametrize("n", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 1000])
def test_forces_of_any_number_of_rows(model, parameters, n):
    rows = rows_of(model, n)
    expected = code_for(model, "numpy").forces(rows, parameters)
    assert code_for(model, "batch").forces(rows, parameters).shape == expected.shape == (len(MODELS[model].outputs), n)
    assert_same(model, code_for(model, "batch").forces(rows, parameters), expected)


@pytest.mark.parametrize("name", ["mf96", "mf61"])
def test_inputs_in_any_memory_are_read_and_not_changed(name):
    """The address of an array is found in two ways: those that cannot be written have the slower one."""
    coefficients, rows = values_of(MODELS[name]), rows_of(name, BLOCK + 3)
    expected = code_for(name, "batch").forces(rows, coefficients)
    fixed = rows.copy()
    fixed.flags.writeable = False
    frozen = coefficients.copy()
    frozen.flags.writeable = False
    for given in (fixed, np.asfortranarray(rows), np.repeat(rows, 2, axis=1)[:, ::2], rows.astype(np.float32)):
        answer = code_for(name, "batch").forces(given, frozen)
        tolerance = 1e-3 if given.dtype == np.float32 else 0.0
        np.testing.assert_allclose(answer, expected, rtol=tolerance, atol=tolerance * np.abs(expected).max())


@pytest.mark.parametrize("routine", ["jacobian_inputs", "jacobian_parameters"])
def test_jacobians(model, parameters, routine):
    rows = rows_of(model, 300)
    answer = getattr(code_for(model, "batch"), routine)(rows, parameters)
    expected = getattr(code_for(model, "numpy"), routine)(rows, parameters)
    assert answer.shape == expected.shape
    assert np.isfinite(expected).all()
    # The rounding of a derivative is that of the force divided by the size of the argument.
    inputs = np.maximum(np.abs(rows).max(axis=1), 1e-3)
    sizes = inputs if routine == "jacobian_inputs" else np.maximum(np.abs(parameters[: expected.shape[2]]), 1e-3)
    forces = np.abs(code_for(model, "numpy").forces(rows, parameters)).max(axis=1)
    terms = np.maximum(np.abs(expected).max(axis=0) * sizes, forces[:, None])
    assert np.max(np.abs(answer - expected) * sizes / terms) < ROUNDING


def test_derivatives_by_inputs_do_not_depend_on_the_chunks(monkeypatch):
    model, symbolic_model = "mf61", MODELS["mf61"]
    rows, values = rows_of(model, 300), values_of(symbolic_model)
    rows[row_of(model, "alpha"), [5, 150]] = np.nan, 1e9  # no result, and outside the range of the kernel
    whole = code_for(model, "batch").jacobian_inputs(rows, values)
    monkeypatch.setattr(import_module("tirefmu.tires.code.batch_code"), "ROWS_IN_CACHE", 64)
    np.testing.assert_array_equal(code_for(model, "batch").jacobian_inputs(rows, values), whole)
    assert whole.shape == (300, len(symbolic_model.outputs), len(symbolic_model.inputs))
    assert code_for(model, "batch").jacobian_inputs(rows[:, :0], values).shape == (0, *whole.shape[1:])


def test_a_coefficient_that_acts_by_its_sign_alone_has_derivatives_of_zero():
    """Its line reads it: every language has its entries, in the same order."""
    text = (
        'name = "sided"\nphysics = "p"\nsource = "s"\n[coefficients]\nSIDED1 = {description = "d", unit = "1"}\n'
        '[[acts]]\non = "friction_y"\nfactor = "1 + 0.1*sgn(SIDED1)"\n'
    )
    symbolic_model = MODELS["brush"].extended([read_effect(text, "sided.toml")])
    parameters, rows = values_of(symbolic_model, SIDED1=0.3), rows_of("brush", 20)
    numpy, *others = (code_for(symbolic_model, name) for name in ("numpy", "c", "batch"))
    (places,) = np.nonzero(numpy.entries[1] == list(symbolic_model.coefficients).index("SIDED1"))
    expected = numpy.jacobian_entries(rows, parameters)
    assert len(places) == len(symbolic_model.outputs)  # each force depends on it in combined slip
    assert not expected[places].any()
    for code in others:
        np.testing.assert_array_equal(code.entries, numpy.entries)
        np.testing.assert_allclose(code.jacobian_entries(rows, parameters), expected, rtol=1e-9, atol=1e-9)


def test_the_entries_are_all_nonzero_derivatives(model, parameters):
    rows = rows_of(model, 200)
    kernels, numpy = code_for(model, "batch"), code_for(model, "numpy")
    dense, (force, coefficient) = kernels.jacobian_parameters(rows, parameters), kernels.entries
    np.testing.assert_array_equal(kernels.jacobian_entries(rows, parameters), dense[:, force, coefficient].T)
    elsewhere = np.ones(dense.shape[1:], dtype=bool)
    elsewhere[force, coefficient] = False
    assert not dense[:, elsewhere].any()
    assert not numpy.jacobian_parameters(rows, parameters)[:, elsewhere].any()
    np.testing.assert_array_equal(numpy.entries, kernels.entries)


@pytest.mark.parametrize("language", ["numpy", "c", "batch"])
def test_chunks_are_the_entries_in_turn(model, parameters, language):
    code, rows = code_for(model, language), rows_of(model, 150)
    # Not a row for a kernel; NumPy would use another routine, with other rounding, for the chunks without it.
    if MODELS[model].on_demand and language != "numpy":
        rows[row_of(model, "phit"), 140] = 0.1
    for inputs in (rows, rows[:, :130]):
        chunks = [(part, entries.copy()) for part, entries in code.jacobian_chunks(inputs, parameters, 64)]
        assert [part.stop - part.start for part, _ in chunks] == [64, 64, inputs.shape[1] - 128]
        whole = code.jacobian_entries(inputs, parameters)
        np.testing.assert_array_equal(np.concatenate([entries for _, entries in chunks], axis=1), whole)
        chosen = np.arange(len(whole))[-2::-3]
        np.testing.assert_array_equal(chosen_derivatives(code, inputs, parameters, chosen), whole[chosen])


def test_rows_outside_the_range_of_the_kernels(model, parameters):
    rows = rows_of(model, 3 * BLOCK)
    strange = [np.nan, np.inf, -np.inf, 0.0, -0.0, 1e-310]  # a huge angle would only show rounding
    for position, value in enumerate(strange):
        for k in range(len(rows)):
            rows[k, 7 * position + k] = value
    if MODELS[model].on_demand:
        rows[row_of(model, "phit"), -5:] = 0.1
    assert_same(
        model, code_for(model, "batch").forces(rows, parameters), code_for(model, "numpy").forces(rows, parameters)
    )


@pytest.mark.parametrize("n", [1, 4 * BLOCK + 1])
def test_normal_equations_are_sums_over_rows(model, parameters, n):
    """Also of a row beyond the range of the kernels; a row without a weight has no influence, whatever it contains."""
    rows, code = rows_of(model, n), code_for(model, "batch")
    rng, n_forces = np.random.default_rng(2), len(MODELS[model].outputs)
    roots = np.where(np.arange(n) % 7 == 5, 0.0, rng.uniform(0.5, 2.0, (n_forces, n)))
    roots[-1] = 0.0  # a force that was not measured
    roots[0, 4 * BLOCK :] = 0.0  # a force without weight in the second panel
    residuals = roots * rng.normal(size=(n_forces, n))
    rows[row_of(model, "alpha"), 6::90] = 2e7
    rows[row_of(model, "Fz"), 5::70] = residuals[:, 5::70] = np.nan
    entries = [np.flatnonzero(code.entries[0] == force)[1::2] for force in range(n_forces)]
    sums = normal_equations(code, WeightedRows(rows, entries, roots, residuals), parameters)
    jacobian = np.where(
        np.isnan(rows[row_of(model, "Fz")]), 0.0, code_for(model, "c").jacobian_entries(rows, parameters)
    )
    for (gradient, matrix), chosen, root, residual in zip(sums, entries, roots, residuals, strict=True):
        weighted, r = jacobian[chosen] * root, np.where(root > 0, residual, 0.0)
        lengths = np.sqrt(np.sum(weighted**2, axis=1))
        error = ROUNDING * np.max(lengths, initial=0.0)  # of a derivative
        assert (np.abs(matrix - weighted @ weighted.T) <= error * np.add.outer(lengths, lengths)).all()
        assert (np.abs(gradient - weighted @ r) <= error * np.sqrt(r @ r)).all()


def test_the_memory_of_the_normal_equations_has_the_size_that_the_kernel_uses():
    printers, sizes = files("tirefmu.symbolic.printers"), {}
    for header in ("blocks.h", "normal_equations.h"):
        text = (printers / header).read_text(encoding="ascii")
        for name, expression in re.findall(r"^#define (\w+) (.+)$", text, re.MULTILINE):
            sizes[name] = eval(expression, {}, sizes)
    assert (sizes["STEP"], sizes["TILE_ROWS"] * sizes["TILE_COLUMNS"]) == (STEP, TILE)
    assert sizes["BLOCK"] == BLOCK


@pytest.mark.parametrize("name", [name for name in MODELS if MODELS[name].options])
def test_options_and_turn_slip_everywhere(name):
    model = MODELS[name]
    rows = rows_of(name, 100)
    given = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    given = {key: declared.generic for key, declared in model.coefficients.items()} | given
    for option in model.options:
        values = np.array([given.get(key, float(key == option.parameter)) for key in model.parameters])
        assert_same(name, code_for(name, "batch").forces(rows, values), code_for(name, "numpy").forces(rows, values))


def test_numpy_in_chunks_is_numpy(model, parameters, monkeypatch):
    rows = rows_of(model, 100)
    whole = code_for(model, "numpy").forces(rows, parameters)
    monkeypatch.setattr(numpy_code, "CHUNK", 7)
    np.testing.assert_array_equal(code_for(model, "numpy").forces(rows, parameters), whole)


def test_the_fastest_code(monkeypatch):
    assert fastest_code("mf96", 10) is code_for("mf96", "numpy")
    assert fastest_code("mf96", MANY_ROWS) is code_for("mf96", "batch")

    def none(*arguments):
        raise CompilerError("no C compiler found")

    monkeypatch.setattr(selection, "batch_code", none)
    selection._code_for.cache_clear()
    assert fastest_code("mf96", MANY_ROWS) is code_for("mf96", "numpy")
    selection._code_for.cache_clear()


@pytest.mark.parametrize("model", ["mf96"], indirect=True)
def test_flags_that_the_compiler_rejects_are_omitted(monkeypatch, tmp_path, parameters, model):
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path))
    monkeypatch.setattr(kernel, "FLAGS", (("-no-such-flag-as-this",), kernel.FUSED))
    built = kernel.Kernel(MODELS[model], "forces", len(MODELS[model].outputs))
    rows = rows_of(model, 70)
    results, undone = built(rows, parameters)
    assert not undone.any()
    assert_same(model, results, code_for(model, "numpy").forces(rows, parameters))


@pytest.mark.parametrize("factor", [3e6, 1e9, -1e9, 1e300])
def test_rows_with_huge_angles_are_computed_one_by_one(factor):
    model = MODELS["mf61"]
    parameters = values_of(model, PCX1=factor, RCY1=factor)
    rows = rows_of("mf61", 100)
    batch, one_by_one = (code_for(model, language).forces(rows, parameters) for language in ("batch", "c"))
    assert np.array_equal(batch, one_by_one, equal_nan=True) or abs(factor) < 1e7
    # At 3e6 the angles are known to 1e-9.
    difference = np.abs(batch - one_by_one).max(axis=1)
    assert (difference <= 1e-8 * np.abs(one_by_one).max(axis=1)).all()
