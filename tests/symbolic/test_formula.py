"""Formulas from files: bounded before anything is computed, real and finite, and equal after writing and reading."""

from __future__ import annotations

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.boundary.errors import EffectError
from tirefmu.symbolic.added.formula import DEEPEST, LARGEST, LONGEST, formula, formula_text


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("A + exp(exp(exp(99)))", r"'exp\(exp\(99\)\)' is too large"),
        ("((9**99)**99)**99", "'9 \\*\\* 99' is not 0 and not between"),
        ("2**(3**(4**5))", "a power of 1024: it is too high"),
        ("T**(10**9)", "a power of 1e\\+09: it is too high"),
        ("((1e49*T)**99)**99", "not between"),
        ("T*1e40*1e40", "not between"),
        ("1e999", "not between"),
        ("9" * 1500, "not between"),
        ("1e-60*T", "not between"),
        ("T/0", "divides by 0"),
        ("T/0.0", "divides by 0"),
        ("0**-1", "divides by 0"),
        ("1/(T - T)", "divides by 0"),
        ("(0-2)**0.5", "has no real value"),
        ("sqrt(-1)", "has no real value"),
        ("sqrt(-T**2)", "has no real value"),
        ("log(T - T)", "has no real value"),
        ("(-1)**T", "has a variable power of a base that is not positive"),
        ("0**T", "has a variable power of a base that is not positive"),
        ("(" * 300 + "T" + ")" * 300, "is not a formula"),
        ("-" * 300 + "T", f"more than {DEEPEST} levels deep"),
        ("tanh(" * 50 + "T" + ")" * 50, "too large when expanded"),
        ("+".join(["sin(T)*cos(T)*A"] * 75), "more than 600 numbers, names and operations"),
        ("T" * (LONGEST + 1), f"more than {LONGEST} characters"),
        ("1or 2", "is not a formula"),
        ("1j*T", "is not allowed in a formula"),
        ("\uff34 + 1", "is not allowed in a formula"),
        ("T.real", "is not allowed in a formula"),
        ("[T for T in (1,)][0]", "is not allowed in a formula"),
        ("lambda: T", "is not allowed in a formula"),
        ("", "is not allowed in a formula"),
    ],
)
def test_formulas_without_a_bounded_real_value_are_rejected(text, reason):
    with pytest.raises(EffectError, match=reason) as caught:
        formula(text, "own.toml: [[acts]]")
    assert str(caught.value).startswith("own.toml: [[acts]]: ")
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1/3 + 1/7", "10/21"),
        ("-2**2", "-4"),
        ("sin(pi/4)*T", "0.7071067811865475*T"),
        ("sqrt(T**2)", "absolute(T)"),
        ("sqrt(2*T)", "1.4142135623730951*sqrt(T)"),
        ("0.1*T*0.7", "0.06999999999999999*T"),
        ("T**(1/2)", "sqrt(T)"),
        ("sqrt(2)", "1.4142135623730951"),
        ("0.0 - 0", "0"),
    ],
)
def test_numbers_are_computed_in_fractions_and_doubles(text, expected):
    assert formula_text(formula(text, "here")) == expected


def test_a_nested_formula_within_the_bounds_can_be_written_again():
    once = formula("tanh(" * 10 + "A*T" + ")" * 10, "here")
    assert formula(formula_text(once), "here") == once


def formula_or_line(text):
    """Return the formula of a text, or None if it is rejected in one line."""
    try:
        return formula(text, "here")
    except EffectError as error:
        message = str(error)
    assert message.startswith("here: ")
    assert message.isprintable()
    return None


numbers = st.one_of(st.integers(-20, 20).map(str), st.floats(-1e60, 1e60, allow_nan=False).map(repr), st.just("pi"))
leaves = st.one_of(numbers, st.sampled_from(["T", "A", "Fz"]))
formulas = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "**"]), inner).map(lambda x: f"({x[0]}){x[1]}({x[2]})"),
        st.tuples(st.sampled_from(["sin", "exp", "log", "sqrt", "tanh", "abs", "sgn1", "atan", "-"]), inner).map(
            lambda x: f"{x[0]}({x[1]})"
        ),
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(formulas)
def test_any_formula_is_rejected_in_one_line_or_survives_a_round_trip(text):
    once = formula_or_line(text)
    if once is None:
        return
    assert formula(formula_text(once), "here") == once
    for node in sp.preorder_traversal(once):
        assert node.is_Symbol or node.is_Number or node.free_symbols
        if node.is_Number and node != 0:
            assert 0.9 / LARGEST <= abs(float(node)) <= 1.1 * LARGEST


@settings(max_examples=150, deadline=None)
@given(st.text("TA019.e+-*/()_ sqrtlogpi", max_size=40))
def test_any_text_is_a_formula_or_an_error_of_one_line(text):
    formula_or_line(text)
