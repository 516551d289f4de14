"""TOML of users is read in one place, within limits of size and depth."""

from __future__ import annotations

import re
import tomllib
import tracemalloc
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tirefmu.applications.batch import read_jobs, read_study
from tirefmu.applications.project import read_project
from tirefmu.boundary.bounded_file import DEEPEST, MAX_BYTES, toml_content
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.diagnose_command import user_effect
from tirefmu.fitting import load_recipe
from tirefmu.symbolic.added import read_effect
from tirefmu.tires import published, read_tir, write_tir

ROOT = Path(__file__).parents[2]
#: All readers of files with TOML of users.
READERS = {
    "project": read_project,
    "recipe": lambda path: load_recipe(str(path), "mf96"),
    "effect": user_effect,
    "jobs": read_jobs,
    "study": read_study,
}
#: Files of 20 KB that fill the memory if they are parsed.
DEEP = {
    "key": "a." * 8000 + "b = 1",
    "spaced key": "a . " * 5000 + "b = 1",
    "quoted key": "'a'.\"b\"." * 2500 + "c = 1",
    "header": "[" + "a." * 8000 + "b]",
    "key in a table": "t = {" + "a." * 8000 + "b = 1}",
    "key after texts": 'x = ["""a"""", {' + "a." * 8000 + 'b = 1}, ""]',
    "arrays": "a = " + "[" * 4000,
    "tables": "a = " + "{a = " * 1600,
}
EFFECT = """
name = "own"
physics = "friction changes with camber"
[coefficients]
OWN1 = {description = "friction", unit = "1/rad", lower = -1.0, upper = 1.0}
[[acts]]
on = "mu_y"
factor = "1 + OWN1*gamma"
"""
#: Bytes that reading one of them may take.
MEMORY = 20_000_000


def peak(read):
    """Return the memory that a refusal takes, in bytes."""
    tracemalloc.start()
    try:
        with pytest.raises(TirefmuError, match=f"more than {DEEPEST} levels"):
            read()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_a_deep_file_is_refused_before_it_fills_the_memory(tmp_path, read, text):
    path = tmp_path / "deep.toml"
    path.write_text(text, encoding="utf-8")
    assert peak(lambda: read(path)) < MEMORY


def test_a_deep_effect_in_a_tire_is_refused(tmp_path):
    tire, path = published("trento_hoosier"), tmp_path / "tire.tir"
    effect = read_effect(EFFECT, "own.toml")
    write_tir(replace(tire, effects=[*tire.effects, effect.name], added=(effect,)), path)
    written = path.read_text(encoding="utf-8")
    name = f"name = \\u0022{effect.name}\\u0022"
    assert name in written
    path.write_text(written.replace(name, DEEP["key"]), encoding="utf-8")
    assert peak(lambda: read_tir(path)) < MEMORY


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_a_large_file_is_refused(tmp_path, read):
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * (MAX_BYTES + 1))
    with pytest.raises(TirefmuError, match="larger than 2 MB"):
        read(path)


def test_toml_is_parsed_in_one_module():
    packages = [path.parent for path in ROOT.glob("*/__init__.py") if path.parent.name != "tests"]
    files = [path for package in packages for path in package.rglob("*.py")]
    parsers = [path for path in files if re.search("^ *(import|from) tomllib", path.read_text(encoding="utf-8"), re.M)]
    assert [str(path.relative_to(ROOT)) for path in parsers] == [str(Path("boundary", "bounded_file.py"))]


#: Characters that begin, end or escape a text, a comment, a key, an array or a table.
SIGNS = "\"'\\#.[]{}=, a1\t"


def escaped(text):
    return text.replace("\\", "\\\\").replace('"', '\\"')


BASIC = st.text(SIGNS).map(lambda text: f'"{escaped(text)}"')
LITERAL = st.text(SIGNS.replace("'", "")).map(lambda text: f"'{text}'")
LINES, OWN_QUOTES = st.text(SIGNS + "\n"), st.integers(0, 2)  # up to two quotes may precede those that end a text
LONG_BASIC = st.builds(lambda text, more: f'"""{escaped(text)}' + '"' * (3 + more), LINES, OWN_QUOTES)
LONG_LITERAL = st.builds(lambda text, more: f"'''{text.replace(chr(39), '')}" + "'" * (3 + more), LINES, OWN_QUOTES)
KEYS = st.lists(st.one_of(st.sampled_from(["a", "b-1", "0"]), BASIC, LITERAL), min_size=1, max_size=DEEPEST + 2)
DOTS = st.sampled_from([".", " . ", "\t."])


@st.composite
def items(draw):
    """Return a text, a number or a table in a line, and its levels."""
    if draw(st.booleans()):
        return draw(st.one_of(BASIC, LITERAL, LONG_BASIC, LONG_LITERAL, st.just("-1.5"))), 0
    key = draw(KEYS)
    return f"{{{draw(DOTS).join(key)} = [{draw(LITERAL)}]}}", max(len(key), 2)


@st.composite
def statements(draw):
    """Return the header of a table, or a key with an array in arrays, and its levels."""
    key, comment = draw(KEYS), "# " + draw(st.text(SIGNS))
    written = draw(DOTS).join(key)
    if draw(st.booleans()):
        return f"[{written}] {comment}", len(key)
    levels, inside = draw(st.integers(1, DEEPEST + 1)), draw(st.lists(items(), max_size=3))
    array = "[" * levels + ", ".join(item for item, _ in inside) + "]" * levels
    return f"{written} = {array} {comment}", max(len(key), levels + max((depth for _, depth in inside), default=0))


@given(st.lists(statements(), min_size=1, max_size=3))
def test_what_is_not_too_deep_is_read_as_tomllib_does(lines):
    text, deepest = "\n".join(line for line, _ in lines), max(levels for _, levels in lines)
    try:
        content = tomllib.loads(text)
    except ValueError:  # two statements with the same key
        assume(False)
    if deepest <= DEEPEST:
        assert toml_content(text, "a.toml", TirefmuError) == content


@given(st.lists(statements(), min_size=1, max_size=3), st.text(SIGNS + "\n"))
def test_no_key_that_is_too_deep_reaches_the_parser(lines, rest):
    """Also where another text follows or the whole is no TOML: the parser stores keys up to its first error."""
    text = "\n".join(line for line, _ in lines) + rest
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tomllib._parser, "parse_key", partial(_parsed_key, tomllib._parser.parse_key))
        with suppress(TirefmuError):
            toml_content(text, "a.toml", TirefmuError)


def _parsed_key(parse_key, src, pos):
    pos, key = parse_key(src, pos)
    assert len(key) <= DEEPEST
    return pos, key
