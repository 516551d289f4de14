"""Text of an effect file in generated code: any text changes comments only."""

from __future__ import annotations

import ast
import re
import subprocess
from dataclasses import replace

import pytest
import sympy as sp
from hypothesis import example, given, settings

from tirefmu.boundary.errors import EffectError
from tirefmu.symbolic.added import AddedEffect, effect_text, read_effect
from tirefmu.symbolic.added.effect import Act
from tirefmu.symbolic.contract import Role
from tirefmu.symbolic.declarations import Coefficient, Section
from tirefmu.symbolic.model import Model, Source
from tirefmu.symbolic.models import model_named
from tirefmu.symbolic.notation import Chapter
from tirefmu.symbolic.printers.generate import render_model
from tirefmu.tires.code.compiler import CompilerError, find_compiler

from ..boundary.hostile import NASTY, hostile_texts

CODE = NASTY[1]
WORDS = "a plain text"


def small_model():
    """Return a model of three lines, which is printed quickly."""

    class Size(Section, title="SIZE"):
        FNOMIN = Coefficient("load", "N", neutral=None, start=1000.0)
        UNLOADED_RADIUS = Coefficient("radius", "m", neutral=None, start=0.3)
        PDY1 = Coefficient("friction", start=1.0)
        PKY1 = Coefficient("slip stiffness factor", start=1.0, flips=True)

    force = Chapter("Force")
    symbolic_model = model_named("mf96")
    kappa, alpha, load = (quantity.symbol for quantity in symbolic_model.inputs if quantity.name != "gamma")
    grip = force("1", "mu_y", Size.PDY1 + 0 * load, description="friction")
    force("2", "Fx", grip * kappa * load / Size.UNLOADED_RADIUS, "N", "longitudinal force")
    force("3", "Fy", Size.PKY1 * grip * sp.atan(alpha) * load, "N", "side force")
    roles = {"friction_x": Role("mu_y", ("PDY1",)), "friction_y": Role("mu_y", ("PDY1",))}
    return Model(
        "small",
        "A small model",
        symbolic_model.inputs,
        symbolic_model.outputs[:2],
        (Size,),
        Source((force,)),
        roles=roles,
    )


SMALL = small_model()


def effect(**given):
    """Return an effect with the given texts; the others are plain."""
    texts = {"description": WORDS, "unit": "1", "physics": WORDS, "source": WORDS} | given
    declaration = Coefficient(texts["description"], texts["unit"], -1.0, 1.0)
    declaration.name = "OWN1"
    acts = (Act("mu_y", "factor", "OWN1*T + 1"),)
    return AddedEffect("own", texts["physics"], texts["source"], (declaration,), acts)


def printed(**texts):
    return render_model(SMALL.extended([effect(**texts)]))


def without_comments(code):
    """Return C code as a compiler sees it: trigraphs replaced, lines spliced, then comments removed."""
    for sign, meant in zip("=/'()!<>-", "#\\^[]|{}~", strict=True):
        code = code.replace(f"??{sign}", meant)
    code, seen, i = code.replace("\\\n", ""), [], 0
    while i < len(code):
        two = code[i : i + 2]
        if two in ("/*", "//"):
            end = code.index("*/", i) + 2 if two == "/*" else (code.find("\n", i) + 1 or len(code)) - 1
            seen.append(" ")
            i = end
        elif code[i] in "\"'":
            end = re.compile(r"(?:\\.|[^\\])*?" + code[i], re.DOTALL).match(code, i + 1).end()
            seen.append(code[i:end])
            i = end
        else:
            seen.append(code[i])
            i += 1
    return "".join(seen).split()


def bare(code):
    """Return the syntax tree of Python code without its docstrings."""
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            node.body[0].value.value = ""
    return ast.dump(tree)


@pytest.fixture(scope="module")
def plain():
    return {name: without_comments(text) if "c/" in name else bare(text) for name, text in printed().items()}


@settings(max_examples=25, deadline=None)
@example(CODE)
@example("\n".join(NASTY))
@given(hostile_texts())
def test_text_changes_nothing_but_comments(plain, text):
    for name, code in printed(description=text, unit=text[:40], physics=text, source=text).items():
        assert code.isascii()
        assert (without_comments(code) if "c/" in name else bare(code)) == plain[name], name


def test_the_test_detects_what_a_compiler_would_detect():
    assert without_comments("a /* x */ b // y ??/\nz\n c") == ["a", "b", "c"]
    assert without_comments('a /* "*/ b "/* x */" c') == ["a", "b", '"/*', "x", '*/"', "c"]
    hostile = f"int a; /* {CODE} */"
    assert "system(" in " ".join(without_comments(hostile))


def test_hostile_text_compiles_without_a_warning(tmp_path):
    try:
        command = [*find_compiler(), "-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    except CompilerError:
        pytest.skip("no C compiler")
    for name, code in printed(description="".join(NASTY)[:600], unit=CODE[:40]).items():
        if "c/" in name:
            (tmp_path / name.removeprefix("c/")).write_text(code, encoding="ascii")
    sources = map(str, tmp_path.glob("*.c"))
    done = subprocess.run([*command, *sources], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@settings(max_examples=50, deadline=None)
@example(CODE)
@example("\n".join(NASTY))
@given(hostile_texts())
def test_a_file_with_any_text_reads_back_equal(text):
    written = effect_text(effect(description=text, unit=text[:40], physics=f"x{text}", source=f"x{text}"))
    text = re.sub("[\0\ud800-\udfff]", "\ufffd", text)  # which no file contains
    assert read_effect(written, "own.toml") == effect(
        description=text, unit=text[:40], physics=f"x{text}", source=f"x{text}"
    )


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"name": "mu_y"}, "effect mu_y: mu_y is a quantity of small already"),
        ({"name": "load_friction"}, "load_friction is an effect of small already"),
        ({"name": "with space"}, "name 'with space' is not a word of letters"),
        ({"name": "about"}, "name 'about' is a section of .tir files"),
        ({"name": "NUL"}, "name 'NUL' is a device of Windows"),
        ({"coefficient": "PDY1"}, "effect own: PDY1 is a coefficient of small already"),
        ({"coefficient": "T"}, "effect own: T is a quantity of small already"),
        ({"coefficient": "NAN"}, "coefficient 'NAN' is a macro of C"),
        ({"reads": "own"}, "reads 'own', which small has not before it"),
        ({"reads": "load_friction"}, "reads 'load_friction', which small has not before it"),
        ({"reads": "LIMITS"}, "reads 'LIMITS', which small has not before it"),
    ],
)
def test_a_name_with_another_meaning_is_rejected(changed, message):
    changed_effect = effect()
    if "coefficient" in changed:
        (declaration,) = changed_effect.declarations
        declaration.name = changed["coefficient"]
    if "reads" in changed:
        acts = (replace(changed_effect.acts[0], text=f"1 + {changed['reads']}"),)
        changed_effect = replace(changed_effect, acts=acts)
    with pytest.raises(EffectError, match=message):
        SMALL.extended([replace(changed_effect, name=changed.get("name", changed_effect.name))])


def test_two_effects_with_the_same_name_are_rejected():
    with pytest.raises(EffectError, match="two added effects have the name OWN"):
        SMALL.extended([effect(), replace(effect(), name="OWN")])


TEXT = effect_text(effect())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TEXT.replace(f'physics = "{WORDS}"', f'physics = "{"x" * 601}"'), "expected a text of 1 to 600 characters"),
        (TEXT.replace('unit = "1"', f'unit = "{"m" * 41}"'), "OWN1: unit has more than 40 characters"),
        (TEXT.replace("lower = -1.0", "lower = nan"), "OWN1.lower is nan: expected a number"),
        (TEXT.replace("lower = -1.0", "lower = -inf"), "OWN1.lower is -inf: expected a number"),
        (TEXT.replace("lower = -1.0", f"lower = -{'9' * 400}"), "expected a number"),
        (TEXT.replace("lower = -1.0", f"lower = -{'9' * 5000}"), "own.toml: "),
        (TEXT.replace("neutral = 0.0", "neutral = 2.0"), "OWN1: neutral 2.0 is not between lower -1.0 and upper 1.0"),
        (TEXT.replace("neutral = 0.0", "start = -2.0"), "OWN1: start -2.0 is not between"),
        (TEXT + TEXT[TEXT.index("\n[[acts]]") :] * 50, "expected a list of 1 to 50 tables"),
        (TEXT + "#" * 100_000, "has at most 100000 characters"),
        (TEXT.replace("OWN1 =", '"OWN\\u001b[2J" ='), "a word of capital letters"),
        (TEXT.replace("OWN1 =", "NAN ="), "coefficient 'NAN' is a macro of C"),
        (TEXT + '"a\\nb" = 1\n', "unknown key"),
        (TEXT + "a = " + "[" * 20_000, "own.toml: "),
        (TEXT.replace('"OWN1*T + 1"', '"OWN1*T/0"'), "own.toml: \\[\\[acts\\]\\]: 'OWN1 \\* T / 0' divides by 0"),
    ],
)
def test_a_file_beyond_the_bounds_is_one_line(text, message):
    assert text != TEXT
    with pytest.raises(EffectError, match=message) as caught:
        read_effect(text, "own.toml")
    assert str(caught.value).startswith("own.toml: ")
    assert str(caught.value).isprintable()


def test_a_formula_at_the_bounds_is_printed():
    deep = "sin(" * 75 + "OWN1*T" + ")" * 75
    changed_effect = read_effect(TEXT.replace("OWN1*T + 1", f"1 + {deep}"), "own.toml")
    assert render_model(SMALL.extended([changed_effect]))["c/small.c"].count("fast_sin(") > 75
