"""What ``import tirefmu`` offers, and what it does not load."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import version
from inspect import signature

import pytest

import tirefmu
from tirefmu.symbolic.models import MODELS, model_named, whole_library
from tirefmu.tires.code.printed import printed_folder

#: The public contract.
NAMES = {
    "CheckResult", "Diagnosis", "Drive", "FitResult", "ProofResult", "Recording", "Tire", "TirefmuError",
    "VirtualBench", "add_proof", "bootstrap", "check", "compare", "convert", "diagnose", "diagnose_many", "draw",
    "drive", "evaluate", "explore", "export", "fit", "fit_many", "inspect", "lint", "load", "plan", "published",
    "read_recording", "repeat_proof", "study",
}  # fmt: skip


def test_every_public_name_is_the_class_or_function_of_that_name():
    assert set(tirefmu.__all__) == NAMES
    assert tirefmu.__all__ == sorted(tirefmu.__all__)
    for name in NAMES - {"load"}:
        assert getattr(tirefmu, name).__name__ == name


def test_what_is_listed_is_what_is_public():
    assert dir(tirefmu) == tirefmu.__all__
    code = "import tirefmu; print(*dir(tirefmu)); import tirefmu.fitting.fit, tirefmu.diagnosis; print(tirefmu.fit)"
    reported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    names, function = reported.stdout.splitlines()
    assert names.split() == tirefmu.__all__
    assert "function fit" in function


def test_a_star_import_brings_them_all():
    names = {}
    exec("from tirefmu import *", names)
    assert set(tirefmu.__all__) <= set(names)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'tirefmu' has no attribute 'fitt'"):
        _ = tirefmu.fitt
    assert not hasattr(tirefmu, "undeclared")


FUNCTIONS = sorted(name for name in NAMES - {"load", "published"} if name[0].islower())


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_signature_of_a_function_names_every_option_and_a_wrong_one_gets_the_nearest(name):
    function = getattr(tirefmu, name)
    parameters = signature(function).parameters.values()
    assert not [p for p in parameters if p.kind in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
    option = max((p.name for p in parameters if p.default is not p.empty), key=len)
    with pytest.raises(TypeError, match=f"{option}s.*did you mean {option}") as raised:
        function(**{f"{option}s": None})
    assert isinstance(raised.value, tirefmu.TirefmuError)


def test_the_version_is_the_packages():
    assert tirefmu.__version__ == version("tirefmu")


def test_load_reads_what_a_tire_saved(tmp_path):
    tire = tirefmu.published("trento_hoosier")
    tire.save(tmp_path / "tire.tir")
    loaded = tirefmu.load(tmp_path / "tire.tir")
    assert loaded.signs == "iso"
    assert dict(loaded.in_signs("adapted-sae").values) == dict(tire.values)
    with pytest.raises(tirefmu.TirefmuError, match=r"missing\.tir"):
        tirefmu.load(tmp_path / "missing.tir")


LARGE = ("casadi", "fmpy", "matplotlib", "scipy", "pythonfmu")
#: Not needed to show a help text or to reject a command either.
LOADED_LATER = (*LARGE, "numpy", "pandas", "sympy", "rich", "tirefmu.symbolic.models", "tirefmu.tires.tire")
#: None of these commands starts.
NO_COMMAND = """
import sys, tirefmu, tirefmu.tires
from tirefmu.commands.cli import main
for arguments in ([], ["fit", "--help"], ["fit", "missing.csv", "-o", "new.tir"], ["info", "missing.tir"], ["inof"],
                  ["check", "missing.fmu", "missing.csv"], ["diagnose", "missing.csv", "-o", "new"],
                  ["draw", "missing.tir", "-o", "new"], ["evaluate", "missing.tir", "missing.csv", "-o", "new.csv"],
                  ["export", "missing.tir", "-o", "new.fmu"], ["export", "missing.tir", "-o", "no folder/new.fmu"]):
    assert main(arguments) == (0 if arguments in ([], ["fit", "--help"]) else 2), arguments
"""


#: What needs the structure of a model only (`tirefmu.symbolic.model.structure`).
NO_EQUATIONS = """
import sys, tirefmu
from tirefmu.commands.cli import main
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.sources import sources
with open("inputs.csv", "w") as file:
    file.write("alpha,Fz\\n" + "".join(f"{0.004 * i - 0.1},{900 + i}\\n" for i in range(50)))
assert main(["info", "unicamp_small_tire", "--quiet"]) == 0
assert "pandas" not in sys.modules
assert main(["evaluate", "trento_hoosier", "inputs.csv", "-o", "bench.csv", "--quiet"]) == 0
assert "scipy" not in sys.modules
fitted = tirefmu.fit("bench.csv", "fiala", nominal={"Fz0": 900.0, "R0": 0.2}, recipe="joint", iterations=1)
assert not {"matplotlib", "scipy.stats", "scipy.signal"} & sys.modules.keys()
fitted.tire.save("tire.tir")
for inputs in ("slip", "wheel"):
    assert sources(3, interface(tirefmu.load("tire.tir"), inputs=inputs), "{1}")
"""


#: A recording without a missing effect: nothing is added to the model but the library.
DIAGNOSIS = """
import sys, numpy as np, pandas as pd, tirefmu
tire = tirefmu.Tire("fiala", {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.25, "CALPHA": 15000.0, "UMAX": 1.2, "UMIN": 1.0})
t = 0.05 * np.arange(800)
bench = pd.DataFrame({"t": t, "alpha": 0.15 * np.sin(t), "Fz": np.repeat([900.0, 1200.0, 1500.0, 1800.0], 200)})
bench["Fy"] = tire.forces(alpha=bench["alpha"], Fz=bench["Fz"])["Fy"] + np.random.default_rng(0).normal(0, 5, 800)
answer = tirefmu.diagnose(bench, tire=tire, candidates=["wear_drift", "temp_friction"])
assert not answer.found
"""


def print_all(model):
    """Print a model and its Jacobians, so that a process finds them."""
    for jacobians in (False, True):
        printed_folder(model, jacobians=jacobians)


def loaded_by(code, names):
    """Return which of the modules a program loads."""
    code += f"\nimport sys; print('loaded', *[name for name in {names!r} if name in sys.modules])"
    reported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return reported.stdout.splitlines()[-1].split()[1:]


def test_importing_and_errors_load_no_large_library(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert loaded_by(NO_COMMAND, LOADED_LATER) == []


@pytest.mark.slow
def test_a_tire_is_evaluated_fitted_and_exported_without_its_equations(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    print_all(MODELS["fiala"])  # a clone prints the Jacobians at their first use
    assert loaded_by(NO_EQUATIONS, ("sympy",)) == []


@pytest.mark.slow
def test_a_diagnosis_needs_no_equations():
    print_all(MODELS["fiala"])
    print_all(model_named("fiala", whole_library(MODELS["fiala"])))
    assert loaded_by(DIAGNOSIS, ("sympy", "matplotlib", "fmpy")) == []


def test_a_tire_is_evaluated_without_large_libraries_and_a_diagnosis_starts_without_figures_and_fmus():
    evaluated = f"""
import sys, tirefmu
tirefmu.published('trento_hoosier').forces(alpha=0.1, Fz=700.0)
assert not sys.modules.keys() & {LARGE}
tirefmu.diagnose
"""
    names = ("matplotlib", "fmpy", "sympy", "casadi", "scipy.stats", "scipy.signal")
    assert loaded_by(evaluated, names) == []
