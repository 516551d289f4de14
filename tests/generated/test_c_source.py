"""The C source: it compiles without a warning, is self-contained, and accesses only its own memory."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import tirefmu.generated
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.generate import files_on_demand
from tirefmu.tires.code.compiler import CompilerError, find_compiler
from tirefmu.tires.code.printed import code_file
from ..relatives import slow_but

FOLDER = Path(tirefmu.generated.__file__).parent / "c"
#: Without the rolling radius: one function of an FMU, included after the header of its model.
HEADERS = sorted(path.stem for path in FOLDER.glob("*.h") if not path.stem.endswith(("_rolling_radius", "_loaded_radius")))
NAMES = [Path(file).stem for model in MODELS for file in (f"{model}.c", *files_on_demand(model))
         if not file.endswith(".py")]  # fmt: skip
SOURCES = sorted(name for name in NAMES if "_batch_" not in name)
STRICT = ["-Wall", "-Wextra", "-Wshadow", "-Wpedantic", "-Wconversion", "-Wstrict-prototypes", "-Werror"]


def source_file(name):
    """Return the path of a C source: committed, or printed."""
    return code_file(MODELS[name.split("_")[0]], f"c/{name}.c")


def compilers():
    """Return the default C compiler of the machine and the other known compilers that it has."""
    try:
        commands = {Path(shutil.which(find_compiler()[0]) or "").resolve(): find_compiler()}
    except CompilerError:
        commands = {}
    for name in ("gcc", "clang"):
        if path := shutil.which(name):
            commands.setdefault(Path(path).resolve(), [path])
    return [pytest.param(command, id=Path(command[0]).name) for command in commands.values()]


#: Jacobians, the same statements as the values but many times as long, and kernels are compiled by one standard.
STANDARDS = [(source, standard) for source in sorted(NAMES) for standard in ("c99", "gnu17")
             if standard == "c99" or not re.search("_jacobians|_batch_", source)]  # fmt: skip


@pytest.mark.parametrize(("source", "standard"), slow_but([case for case in STANDARDS if "mf96" in case[0] or case == ("mf61", "c99")], STANDARDS))
@pytest.mark.parametrize("compiler", compilers())
def test_no_warning(compiler, source, standard, tmp_path):
    command = [*compiler, f"-std={standard}", "-O0", *STRICT, "-c", str(source_file(source))]
    done = subprocess.run([*command, "-o", str(tmp_path / "model.o")], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode == 0


@pytest.mark.parametrize("header", HEADERS)
def test_header_is_self_contained_and_may_be_included_twice(header, tmp_path):
    source = tmp_path / "use.c"
    source.write_text(
        f'#include "{header}.h"\n#include "{header}.h"\nint main(void) {{ return 0; }}\n', encoding="ascii"
    )
    command = [*find_compiler(), "-std=c99", *STRICT, f"-I{FOLDER}", "-c", str(source)]
    subprocess.run([*command, "-o", str(tmp_path / "use.o")], check=True)


@pytest.mark.parametrize("source", SOURCES)
def test_no_slow_power_no_state_no_allocation(source):
    text = source_file(source).read_text(encoding="ascii")
    assert not re.search(r"\bpow\([^,()]*, [0-9.-]+\)", text), "a power by a number is a product or a root"
    assert not re.search(r"\b(malloc|calloc|free)\(", text)
    assert not re.search(r"^static (?!inline|const|EXPANDED|CALLED|void \w+_general)", text, re.MULTILINE)
    first = text.index("/* Derivatives of the forces" if source.endswith("_jacobians") else "/* Every named quantity")
    routines = text[first:]
    allowed = {"const double", "const pair", "results", "for", "if", "else", "return inputs", "memset"}
    assert set(re.findall(r"\n    (\w+ \w+|\w+)", routines)) <= allowed
