"""Selections select what they state, in units, and everything else is one clear error."""

import contextlib
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import Recording, recordings_from, selected
from tirefmu.measurements.row_selection.expression import KEYWORDS, NAMES, parse_range, parse_selection

ROWS = 600


@pytest.fixture(scope="module")
def bench():
    """Two sweeps of slip angle at 100 Hz with a pause of 20 s, at two pressures and loads, in SAE signs."""
    clock = np.arange(ROWS) / 100.0 + np.where(np.arange(ROWS) < 300, 100.0, 120.0)
    second = np.arange(ROWS) >= 300
    alpha = np.tile(0.2 * np.sin(2.0 * np.pi * np.arange(300) / 300.0), 2)
    table = {"t": clock, "alpha": alpha, "Fz": np.where(second, -900.0, -500.0), "p": np.where(second, 83e3, 97e3)}
    return Recording(pd.DataFrame({**table, "V": 40.0 / 3.6, "T": 50.0, "Fy": 1.0, "Mx": np.nan}), "sae", "run.mat")


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("t > 120 and p in 70..90 kPa", lambda t: (t["t"] > 120) & (t["p"] == 83e3)),
        ("t > 2 min", lambda t: t["t"] > 120),
        ("p in 70 kPa..90 kPa or t <= 101", lambda t: (t["p"] == 83e3) | (t["t"] <= 101)),
        ("not p in 12..13 psi", lambda t: t["p"] == 97e3),
        ("p not in 0.8..0.9 bar", lambda t: t["p"] == 97e3),
        ("Fz in 880 +- 100 N", lambda t: t["Fz"] == -900),  # the load, in every convention
        ("Fz in (0.5 +- 0.01 kN, 900 +- 1 N)", lambda t: t["Fz"] < 0),
        ("abs(alpha) < 3 deg", lambda t: np.degrees(t["alpha"].abs()) < 3),
        ("-3 deg < alpha <= 0 rad", lambda t: (np.degrees(t["alpha"]) > -3) & (t["alpha"] <= 0)),
        ("-3 <= alpha < 3 deg", lambda t: (np.degrees(t["alpha"]) >= -3) & (np.degrees(t["alpha"]) < 3)),
        ("120 < t", lambda t: t["t"] > 120),
        ("V in 40 +- 0.1 km/h and T in 122 +- 1 deg F", lambda t: t["t"] > 0),
        ("T in 50 +- 1 C", lambda t: t["t"] > 0),
        ("segment == 2", lambda t: t["t"] > 110),
        ("segment != 2", lambda t: t["t"] < 110),
        ("sample in 11..20", lambda t: (t.index >= 10) & (t.index < 20)),
        ("sample in (1, 3, 599..600)", lambda t: t.index.isin([0, 2, 598, 599])),
        ("sweep = 2", lambda t: t["t"] > 110),
        ('file == "run.mat" and segment == 1', lambda t: t["t"] < 110),
        ("file != 'other.mat' and segment == 1", lambda t: t["t"] < 110),
        ("t > 120  # the second\n and (t < 121 or t > 122)", lambda t: (t["t"] > 120) & ~t["t"].between(121, 122)),
        # "and" binds more than "or"; "not" more than both.
        ("segment == 1 or segment == 2 and t < 0", lambda t: t["t"] < 110),
        ("not segment == 1 and t > 0", lambda t: t["t"] > 110),
    ],
)
def test_rows_are_those_of_the_expression(bench, expression, expected):
    chosen = np.asarray(expected(bench.table))
    assert chosen.any()
    got = selected(bench, expression)
    pd.testing.assert_frame_equal(got.table, bench.table[chosen].reset_index(drop=True))
    assert got.about["selected"] == f"{chosen.sum()} of {ROWS} rows selected"


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("", "a name is expected at the end"),
        ("t >", "a number is expected at the end"),
        ("t 120", "a comparison (< <= > >= == in) is expected at '120'"),
        ("t > 120 p", "t: unknown unit 'p'"),
        ("t > 120 s p", "'and', 'or' or the end is expected at 'p'"),
        ("t > 120 kPa", "t: unit 'kPa' measures pressure, not time"),
        ("p > 3 kpsi", "p: unknown unit 'kpsi': did you mean psi?"),
        ("pressure > 3", "unknown name 'pressure': did you mean p?"),
        ("SA > 3", "unknown name 'SA': did you mean alpha?"),
        ("segmet == 3", "unknown name 'segmet': did you mean segment?"),
        ("gamma == 0", "gamma is measured and equals no number exactly: write 'gamma in 0 +- 1 UNIT'"),
        ("p in 90..70 kPa", "the range of p ends before it begins"),
        ("p in 90 +- -2", "the tolerance -2 is negative"),
        ("p in 90 kPa", "a range such as '70..90 kPa' or '220 +- 100 N' is expected at the end"),
        ("p in (70..90 kPa", "',' or ')' is expected at the end"),
        ("(t > 1", "')' is expected at the end"),
        ("not", "a name is expected at the end"),
        ("p not > 3", "'in' is expected at '> 3'"),
        ("segment == 1.5", "segment is compared with whole numbers"),
        ("segment == 1 s", "segment is compared with whole numbers"),
        ("1 < t > 3", "< and > in one comparison"),
        ("file == run", "the name of a file, such as \"run.mat\" is expected at 'run'"),
        ("file > 3", 'a file is compared like file == "run.mat"'),
        ("t > 1e999", "a number is too large"),
        ("p < 1e307 bar", "a value in bar is too large"),
        ("p in 1 +- 1e307 bar", "a value in bar is too large"),
        ("Mx > 1", "selects none of 600 rows of run.mat: Mx has no number"),
        ("x" * 900 + " > 1", "unknown name 'xxxxxxxxxxxxxxxxxxx...xxxxxxxxxxxxxxxxxx': known are"),
        ("\0.where", "cannot be read (embedded null byte)"),
        ("t > $3", "'$3' has no meaning here"),
        ("__import__('os').system('true')", "has no meaning here"),
        ("__import__ > 1", "unknown name '__import__'"),
        ("t.__class__", "'.__class__' has no meaning here"),
        ("t > 1 s if t else 2", "'and', 'or' or the end is expected at 'if t else 2'"),
        ("(" * 60 + "t > 1" + ")" * 60, "more than 50 nested brackets"),
        ("t > 1 or " * 2000 + "t > 1", "at most 10000 are read"),
        ("kappa > 0", "run.mat has no channel kappa; it has t, alpha, Fz, p, V, T, Fy, Mx"),
        ("p in 70..90", "selects none of 600 rows of run.mat: p is 83000 to 97000 Pa"),
        ('file == "other.mat"', "selects none of 600 rows of run.mat"),
    ],
)
def test_an_invalid_expression_is_one_clear_line(bench, expression, message):
    with pytest.raises(DataError) as caught:
        selected(bench, expression)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("where")


def test_long_chains_are_read(bench):
    assert len(selected(bench, " or ".join(["segment == 1"] * 600)).table) == 300


WORDS = (*NAMES, *KEYWORDS, "abs", "(", ")", "[", ",", "<", ">=", "==", "!=", "..", "+-", "-", "1", "2.5", "1e308")
WORDS = (*WORDS, "kPa", "bar", "deg", "deg F", '"run.mat"', "#", "\n")


@given(st.text(max_size=60) | st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join))
@example("sample in")
@example("sweep in (1,")
def test_any_text_is_a_selection_or_an_error(text):
    with contextlib.suppress(DataError):
        parse_selection(text)


def test_an_expression_in_a_file(bench, tmp_path):
    path = tmp_path / "crop.where"
    path.write_text("segment == 2  # the second sweep\nand p in 70..90 kPa\n", encoding="utf-8")
    assert len(selected(bench, str(path)).table) == 300
    with pytest.raises(DataError, match=r"where: .*none\.txt: cannot be read \(No such file"):
        selected(bench, str(tmp_path / "none.txt"))
    path.write_bytes(b"t > \xff\xfe")
    with pytest.raises(DataError, match="not a text file"):
        selected(bench, str(path))


def test_each_of_several_tables_has_rows_of_its_own():
    table = pd.DataFrame({"t": np.arange(5.0), "Fz": 900.0})
    both = [Recording(table, "iso", f"{name}.csv") for name in "ab"]
    first, second = recordings_from(both, where='file == "a.csv" and t < 2 or file == "b.csv" and t >= 2')
    assert (first.table["t"].tolist(), second.table["t"].tolist()) == ([0.0, 1.0], [2.0, 3.0, 4.0])


@given(st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)).map(sorted))
def test_both_limits_are_included(limits):
    low, high = (number / 1000.0 for number in limits)
    rows = Recording(pd.DataFrame({"t": [low, high], "Fz": 900.0}), "iso", "a.csv")
    assert len(selected(rows, f"t in {low!r}..{high!r}")) == 2


def test_ranges_of_recipes():
    assert parse_range("3 +- 0.5 deg", "alpha") == (3.0 * np.radians(1.0), 0.5 * np.radians(1.0))
    assert parse_range("3 +- 1 %", "kappa") == (0.03, 0.01)
    assert parse_range("220 N +- 0.1 kN", "Fz") == (220.0, 100.0)
    assert parse_range("50 +- 9 deg F", "T") == pytest.approx((10.0, 5.0))
    with pytest.raises(DataError, match="Fz: unit 'deg' measures angle, not force"):
        parse_range("220 +- 100 deg", "Fz")


def test_every_expression_of_the_documentation_is_valid():
    text = (Path(__file__).parents[3] / "docs" / "data_desk.md").read_text(encoding="utf-8")
    commands = re.findall(r"""--where ("[^"]+"|'[^']+')""", text)
    examples = [example for row in re.findall(r"^\| .*", text, re.M) for example in re.findall("`([^`]+)`", row)[-3:]]
    assert len(commands) >= 5
    for expression in [command[1:-1] for command in commands] + [each for each in examples if " " in each]:
        if not expression.startswith(("< <=", "--where")):
            parse_selection(expression)
