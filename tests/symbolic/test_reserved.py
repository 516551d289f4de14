"""Names from files: a name with another meaning in generated code or in a .tir file is rejected."""

from __future__ import annotations

import builtins
import re
import subprocess

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.symbolic.added import library
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.definitions import INCLUDES
from tirefmu.symbolic.reserved import LONGEST_NAME, no_coefficient, no_effect
from tirefmu.tires.code.compiler import CompilerError, find_compiler
from tirefmu.tires.code.printed import code_file
from tirefmu.tires.property_file.names import OWN_SECTIONS


@pytest.mark.parametrize("name", "PI NAN INFINITY N_INPUTS LANES BLOCK I DBL_MAX MF61_N_INPUTS FOR NUL COM1".split())  # noqa: SIM905
def test_names_with_another_meaning_are_rejected(name):
    assert no_coefficient(name)


@pytest.mark.parametrize(
    "name", ["GRÖSSE", "\u03911", "tmu", "1A", "_A", "A_", "A__B", "A-B", "A B", "", "A\n", "A" * 65]
)
def test_only_plain_words_are_accepted(name):
    assert no_coefficient(name)
    assert no_effect(name) or name == "tmu"


def test_ordinary_names_are_accepted():
    assert not [name for model in MODELS.values() for name in model.coefficients if no_coefficient(name)]
    for effect in library().values():
        assert not no_effect(effect.name)
        assert not [declaration.name for declaration in effect.declarations if no_coefficient(declaration.name)]
    assert not no_coefficient("A" * LONGEST_NAME)


@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_no_macro_of_the_c_library_is_a_coefficient(standard):
    try:
        command = [*find_compiler(), f"-std={standard}", "-dM", "-E", "-"]
    except CompilerError:
        pytest.skip("no C compiler")
    text = f"{INCLUDES}\n#include <stddef.h>\n"
    defined = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    macros = re.findall(r"^#define (\w+)", defined, re.MULTILINE)
    assert "DBL_MAX" in macros
    assert [name for name in macros if not no_coefficient(name)] == []


def test_no_name_that_generated_code_defines_is_a_coefficient():
    kernels = ("mf61_batch_forces.c", "mf61_batch_jacobian_parameters.c")
    for name in ("mf61.h", "mf61.c", "mf61_jacobians.c", "mf61_operations.h", *kernels):
        text = code_file(MODELS["mf61"], f"c/{name}").read_text(encoding="ascii")
        defined = re.findall(r"^#define (?:MF61_)?(\w+)", text, re.MULTILINE)
        assert defined
        assert [macro for macro in defined if not no_coefficient(macro)] == []
    module = code_file(MODELS["mf96"], "numpy/mf96.py").read_text(encoding="ascii")
    tables = re.findall(r"^([A-Z_]+) =", module, re.MULTILINE)
    assert [table for table in tables if not no_coefficient(table)] == []
    assert [name for name in dir(builtins) if not no_coefficient(name)] == []


def test_no_section_of_a_tir_file_is_an_effect():
    sections = [title.removeprefix("TIREFMU_") for title in OWN_SECTIONS if title != "TIREFMU"]
    assert len(sections) > 4
    assert [title for title in sections if not no_effect(title) or not no_effect(title.lower())] == []


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=70))
def test_every_accepted_name_is_an_ascii_identifier_in_capitals(name):
    if not no_coefficient(name):
        assert re.fullmatch("[A-Z][A-Z0-9_]{0,63}", name)
        assert name.isidentifier()
    if not no_effect(name):
        assert re.fullmatch("[A-Za-z][A-Za-z0-9_]{0,63}", name)
