"""No statement of printed C divides by zero, is invalid or overflows, also in programs that trap such exceptions."""

from __future__ import annotations

import subprocess
from itertools import product
from pathlib import Path

import pytest

from tirefmu.applications.exports import generate
from tirefmu.symbolic.models import MODELS
from tirefmu.tires.code.printed import code_file

from ..relatives import slow_but
from .conftest import tool
from .special_points import special_points, symmetric

PROGRAM = """
#include <fenv.h>
#include <stdio.h>
#include "{header}"

#define CALL(name, ...)                                                                             \\
    feclearexcept(FE_ALL_EXCEPT);                                                                   \\
    __VA_ARGS__;                                                                                    \\
    raised = fetestexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);                                 \\
    if (raised)                                                                                     \\
        printf("row %d, %s:%s%s%s\\n", n, name, raised & FE_DIVBYZERO ? " divide by zero" : "",      \\
               raised & FE_INVALID ? " invalid" : "", raised & FE_OVERFLOW ? " overflow" : "");

int main(void)
{{
    static double results[4096], x[{columns}];
    int n, i, raised;

    for (n = 0;; n++) {{
        for (i = 0; i < {columns}; i++)
            if (scanf("%lf", x + i) != 1)
                return 0;
        {calls}
    }}
}}
"""


def exceptions(folder, sources, calls, table, level):
    """Compile a program that calls functions with each row of a table; return a line for each that raises."""
    header = sources[0].with_suffix(".h")
    calls = "\n        ".join(f'CALL("{name}", {call})' for name, call in calls.items())
    (folder / "main.c").write_text(PROGRAM.format(header=header.name, calls=calls, columns=len(table[0])))
    more = [f"-I{header.parent}", *(source for source in sources if source.suffix == ".c"), "main.c"]
    command = [tool("cc"), "-std=c99", level, "-Wall", "-Wextra", "-Werror", *more, "-lm", "-o", "main"]
    subprocess.run(command, cwd=folder, check=True)
    rows = "\n".join(" ".join(repr(float(value)) for value in row) for row in table)
    done = subprocess.run([folder / "main"], input=rows, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


@pytest.mark.parametrize(("level", "kind"), [("-O0", "given"), ("-O2", "symmetric")])
@pytest.mark.parametrize("model", slow_but(["mf96", "mf61"], MODELS))
def test_printout(tire_of, tmp_path, model, level, kind):
    tire = tire_of(model).in_signs("iso")
    tire = symmetric(tire) if kind == "symmetric" else tire
    generate(tire, "c", tmp_path, rows=1)
    functions = ("forces", "quantities", "jacobian_inputs")
    calls = {name: f"{model}_{name}((const {model}_inputs *) x, results)" for name in functions}
    found = exceptions(tmp_path, [tmp_path / f"{model}.h"], calls, special_points(tire).T.tolist(), level)
    assert not found, found[:5]


@pytest.mark.parametrize("level", ["-O0", "-O2"])
@pytest.mark.parametrize("model", slow_but(["mf96"], MODELS))
def test_code_of_fmus(tire_of, tmp_path, model, level):
    """With every combination of options; the Jacobians at -O0 only, since they take long to compile."""
    tire = symmetric(tire_of(model).in_signs("iso"))
    options = {option.parameter: option.name for option in tire.symbolic_model.options if option.name != "signs"}
    table = []
    for chosen in product((0.0, 1.0), repeat=len(options)):
        parameters = dict(zip(tire.symbolic_model.parameters, tire.parameters(), strict=True))
        values = list((parameters | dict(zip(options, chosen, strict=True))).values())
        table += [[*row, *values] for row in special_points(tire).T]
    functions, names = ["forces", "quantities"], [model]
    if level == "-O0":
        functions, names = [*functions, "jacobian_inputs"], [model, f"{model}_jacobians"]
    sources = [Path(code_file(tire.symbolic_model, f"c/{name}.c")) for name in names]
    calls = {name: f"{model}_{name}(x, x + {len(tire.inputs)}, results)" for name in functions}
    found = exceptions(tmp_path, sources, calls, table, level)
    assert not found, found[:5]


@pytest.mark.parametrize("language", ["c", "cpp"])
def test_no_printout_compiles_without_nan(tire_of, tmp_path, language):
    """A load of NaN would give no force."""
    generate(tire_of("brush"), language, tmp_path, functions=["forces"], rows=1)
    refuses_fast_math(tmp_path / f"brush_selftest.{language}", {"c": "cc", "cpp": "c++"}[language])


@pytest.mark.parametrize("model", MODELS)
def test_no_code_of_an_fmu_compiles_without_nan(model):
    refuses_fast_math(code_file(MODELS[model], f"c/{model}.c"), "cc")


def refuses_fast_math(source, compiler):
    for option in ("-ffast-math", "-ffinite-math-only"):
        command = [tool(compiler), option, "-fsyntax-only", str(source)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode
        assert "NaN has to stay NaN" in done.stderr
