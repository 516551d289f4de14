"""A printout in any language: what it contains, what is refused, and texts of a file in its comments."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from itertools import chain, combinations

import numpy as np
import pytest

from tirefmu.applications.exports import generate, operating_conditions, printed, program_of, reference
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.languages import LANGUAGES, printer
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, PrintoutSelection

from ..relatives import slow_but
from .conftest import HOSTILE, command_of, wet_grip

PLAIN = "a plain text"


def test_special_operating_conditions_are_among_the_rows(mf61):
    rows = dict(zip(mf61.inputs, operating_conditions(mf61, 40), strict=True))
    assert (rows["Fz"] == 0).any()
    assert (rows["Fz"] < 0).any()
    assert (rows["V"] == 0).any()
    assert (rows["V"] < 0).any()
    assert ((rows["kappa"] == 0) & (rows["alpha"] == 0)).any()
    assert (rows["kappa"] == -1).any()
    assert (np.abs(rows["alpha"]) > 1).any()


@pytest.mark.parametrize("model", ["mf96", "mf52", "mf61"])
def test_few_rows_are_omitted_and_few_results_have_a_wider_tolerance(tire_of, model):
    """All special rows are compared. Only results that lose digits are compared less strictly than their size."""
    tire = tire_of(model).in_signs("iso")
    printout = program_of(tire, model, PrintoutSelection(("forces", "quantities")), rows=1)
    rows = operating_conditions(tire, 500)
    inputs, results, sizes = reference(tire, printout, rows)
    assert inputs.shape[1] >= 0.99 * rows.shape[1]
    np.testing.assert_array_equal(inputs[:, :13], rows[:, :13])
    labels = np.array([label for routine in printout.routines for label in routine.labels])
    typical = np.array([np.median(np.abs(x[x != 0])) if x.any() else 1.0 for x in results.T])
    assert set(labels[sizes > 1.5 * typical]) <= ({"rho", "R_l", "c_z"} if model == "mf52" else set())


def test_the_deflection_of_a_nearly_linear_tire_is_compared_within_its_rounding(tire_of, printout, assert_agrees):
    tire = tire_of("mf52")
    for bend in (1e-2, 1e-7):
        nearly_linear = replace(tire, values={**tire.values, "Q_FZ2": bend})
        folder = printout(nearly_linear, "numpy", "linear", functions=["quantities"])
        assert_agrees(command_of("numpy", folder), folder, ["quantities"])


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_printout_is_ascii_with_header_and_self_test(trento, language):
    files = printed(trento, language, rows=3, functions=["forces"])
    assert files == printed(trento, language, rows=3, functions=["forces"])
    assert all(text.isascii() for text in files.values())
    source = next(iter(files.values()))
    for part in ("Magic Formula 1996", "Fx, Fy, Mz", "tirefmu", "camber_thrust", "Units", "Signs", "Usage", "4.E20"):
        assert part in source, part
    assert any("selftest" in name for name in files)


@pytest.mark.parametrize("language", LANGUAGES)
def test_hostile_texts_change_comments_only(wet, language):
    """The lines of code are those of a tire with harmless texts."""
    texts = []
    for text in (HOSTILE, PLAIN):
        tire = replace(wet, name=text, added=(wet_grip(text),))
        texts.append(printed(tire, language, rows=2, functions=["forces", "quantities"], values="struct"))
    hostile, harmless = texts
    assert hostile.keys() == harmless.keys()
    for name in hostile:
        assert len(hostile[name].splitlines()) >= len(harmless[name].splitlines())
        assert tokens(hostile[name]) == tokens(harmless[name]), name


def tokens(text):
    """Return the lines of a file that are no comment, without remarks at their end; of LaTeX the commands."""
    if "\\begin{document}" in text:
        return re.findall(r"\\(?!text)[A-Za-z]+", re.sub(r"(?m)^%.*", "", text))
    text = re.sub(r' "[^"\n]*"(?=;|\n)', "", text)  # descriptions in Modelica
    lines = (re.split(r"\s+(?://|%|#|\$!) |\s*/\* ", line)[0].rstrip() for line in text.splitlines())
    return [line for line in lines if line and not re.match(r"\s*(//|%|#|\*|/\*|\$!)", line)]


@pytest.mark.parametrize(
    "language", slow_but(["cpp", "fortran", "modelica"], [language for language in LANGUAGES if language != "latex"])
)
@pytest.mark.parametrize(
    ("name", "functions", "values"), [("mf61", FUNCTIONS[:4], "struct"), ("wet", FUNCTIONS[::2], "inline")]
)
def test_lines_have_less_than_200_characters(request, language, name, functions, values):
    """Long formulas, Jacobians and lists are broken; the rows of a self-test's text file are data."""
    files = printed(request.getfixturevalue(name), language, functions=functions, values=values, rows=2)
    longest = {file: max(map(len, text.splitlines())) for file, text in files.items() if not file.endswith(".txt")}
    assert max(longest.values()) < 200, longest


def forces_here(language, text, names, inputs):
    """Return the forces of a printout that runs in this process: one array for each name."""
    module = {"__name__": "printout"}
    exec(text, module)
    if language == "numpy":
        found = module["forces"](**inputs)
        assert list(found) == list(names)
        return list(found.values())
    return module["function"]("forces")(np.stack([inputs[name] for name in module["INPUTS"]])).full()


@pytest.mark.parametrize("kind", slow_but(["mf96", "fiala", "motorcycle"], [*MODELS, "motorcycle"]))
def test_every_subset_of_the_outputs(tire_of, kind):
    """Small and large ones in one language in turn, with self-test; `make hosts`: each in all, of all models.

    What runs in this process has the forces of the tire. A motorcycle leans: of it each single force in all languages.
    """
    tire, hosts = tire_of("mf61" if kind == "motorcycle" else kind).in_signs("iso"), "TIREFMU_HOSTS" in os.environ
    functions, names, n = FUNCTIONS[: 3 if hosts else 2], list(LANGUAGES), len(tire.outputs)
    sizes = range(1, n + 1) if hosts else sorted({1, 2, n - 1, n})
    if kind == "motorcycle":
        tire, functions, sizes = replace(tire, ranges={**tire.ranges, "gamma": (-1.2, 1.2)}), ("forces",), [1]
    subsets = chain.from_iterable(combinations(tire.outputs, size) for size in sizes)
    ranges = {"alpha": 0.2, "kappa": 0.3, "gamma": 1.1, "phit": 0.1}
    rng, load = np.random.default_rng(8), tire.values["FNOMIN"]
    inputs = {name: rng.uniform(-1.0, 1.0, 9) * ranges[name] for name in tire.inputs if name in ranges}
    inputs |= {"Fz": rng.uniform(0.0, 1.5, 9) * load}
    inputs |= {name: np.full(9, tire.nominal(name)) for name in tire.inputs if name not in inputs}
    forces = tire.forces(code="numpy", **inputs)
    for i, only in enumerate(subsets):
        program = program_of(tire, tire.model, PrintoutSelection(functions, outputs=only), rows=2)
        labels = {routine.name: routine.labels for routine in program.routines}
        assert labels["forces"] == only
        assert not set(labels.get("quantities", ())) & set(tire.outputs)
        for language in names if hosts or kind == "motorcycle" else [names[i % len(names)]]:
            text = next(iter(printer(language)(program).values()))
            assert all(name in text for name in only)
            if language in ("numpy", "casadi"):
                for name, found in zip(only, forces_here(language, text, only, inputs), strict=True):
                    np.testing.assert_allclose(found, forces[name], rtol=1e-9, atol=1e-9 * load)


@pytest.mark.parametrize("only", [["Mz"], ["Fy", "Mx"], ["My"]])
def test_the_self_test_of_some_outputs(mf61, printout, assert_agrees, only):
    folder = printout(mf61, "numpy", "-".join(only), rows=5, only=only)
    assert_agrees(command_of("numpy", folder), folder, FUNCTIONS[:3])


def test_only_some_outputs(trento):
    whole, part = (printed(trento, "cpp", rows=2, only=only)["mf96.hpp"] for only in ((), ("Fy",)))
    assert "Scalar Mz" not in part
    assert "Scalar Fx" not in part
    assert len(part) < 0.6 * len(whole)


@pytest.mark.parametrize("language", ["numpy", "casadi", "jax", "torch"])
def test_a_tire_with_the_name_of_a_library_does_not_hide_it(trento, tmp_path, language):
    trento.save(tmp_path / f"{language}.tir")
    files = printed(tmp_path / f"{language}.tir", language, rows=1, functions=["forces"])
    modules = re.findall(r"(?m)^ *(?:import|from) (\w+)", "\n".join(files.values()))
    assert language in modules
    assert f"{language}.py" not in files


def test_a_tire_with_the_name_of_a_function_compiles(trento, tmp_path, assert_agrees):
    trento.save(tmp_path / "gamma.tir")
    command_of("cpp")
    generate(tmp_path / "gamma.tir", "cpp", tmp_path, functions=["forces"], rows=2)
    assert_agrees(command_of("cpp", tmp_path), tmp_path, ["forces"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"language": "fortran77"}, "unknown language 'fortran77'"),
        ({"functions": ["force"]}, "unknown function 'force': did you mean forces?"),
        ({"functions": []}, "no function"),
        ({"only": ["Mx"]}, "unknown output of mf96 'Mx': did you mean"),
        ({"values": "inlined"}, "unknown placement of values 'inlined': did you mean inline?"),
        ({"functions": ["jacobian_parameters"]}, "use --values struct or file"),
        ({"functions": ["states"]}, "states: the tire has none"),
    ],
)
def test_a_wrong_request_names_the_nearest(trento, tmp_path, arguments, message):
    with pytest.raises(TirefmuError, match=re.escape(message)):
        generate(trento, **{"language": "cpp", "folder": tmp_path / "out", **arguments})
    assert not (tmp_path / "out").exists()


# ------------------------------------------------------------------ the command


def test_the_command_prints_a_model_with_all_functions(tmp_path, capsys):
    out = tmp_path / "new" / "folder"
    arguments = ["generate", "brush", "--language", "cpp", "-o", str(out), "--functions", ",".join(FUNCTIONS[:4])]
    assert main([*arguments, "--json", str(tmp_path / "r.json"), "--quiet"]) == 0
    written = json.loads((tmp_path / "r.json").read_text())
    assert written["files"] == [str(out / name) for name in ("brush.hpp", "brush_selftest.cpp", "brush_selftest.txt")]
    assert "struct Coefficients" in (out / "brush.hpp").read_text()
    assert sorted(path.name for path in out.iterdir()) == sorted(path.rpartition("/")[2] for path in written["files"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["trento_hoosier"], "TIRE needs --language"),
        (["--language", "cpp"], "--language needs a TIRE"),
        (["trento_hoosier", "--check"], "takes no TIRE"),
        (["missing.tir", "--language", "cpp", "-o", "out"], "missing.tir: no such file"),
        (["trento", "--language", "cpp", "-o", "out"], "did you mean trento_hoosier?"),
        (["trento_hoosier", "--language", "c++", "-o", "out"], "unknown language 'c++'"),
    ],
)
def test_a_wrong_command_is_one_line(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["generate", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
