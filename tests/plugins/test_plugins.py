"""Packages that add an effect, a model, a reader and a language: installed, used by commands, and what is refused."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples" / "plugins"
KINDS = ("effect", "language", "model", "reader")
HEAVY = pytest.mark.skipif("TIREFMU_PLUGINS" not in os.environ, reason="make plugins: prints and compiles models")
ROWS = '{"alpha": 0.1, "Fz": 900, "V": 20}\n{"alpha": -0.05, "Fz": 800, "V": 30}\n'


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Install the example packages into a folder of their own: the model only, where no test uses the others."""
    kinds = KINDS if os.environ.keys() & {"TIREFMU_SLOW", "TIREFMU_PLUGINS"} else ("model",)
    sources, target = tmp_path_factory.mktemp("sources") / "plugins", tmp_path_factory.mktemp("installed")
    shutil.copytree(EXAMPLES, sources)
    options = ["--quiet", "--no-index", "--no-build-isolation", "--no-deps", "--target", target]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, *(sources / k for k in kinds)], check=True)
    return target


def tirefmu(folder, *arguments, package=None):
    """Run a command where a package is installed."""
    environment = {**os.environ, "PYTHONPATH": str(package or "")}
    command = [sys.executable, "-P", "-m", "tirefmu", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment)


@pytest.mark.slow
def test_what_packages_add_is_listed_and_absent_without_them(installed, tmp_path):
    program = "from tirefmu.commands.cli import main; main(['effects']), main(['models'])"
    for package, listed in ((str(installed), True), ("", False)):
        run = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True, cwd=tmp_path,
                             env={**os.environ, "PYTHONPATH": package})  # fmt: skip
        assert all((name in run.stdout) == listed for name in ("speed_stiffness", "arctangent")), run.stderr


@pytest.mark.slow
def test_a_reader_and_a_language_of_packages_are_used(installed, tmp_path):
    (tmp_path / "run.jsonl").write_text(ROWS)
    arguments = ("evaluate", "trento_hoosier", "run.jsonl", "-o", "out.csv")
    done = tirefmu(tmp_path, *arguments, package=installed)
    assert (done.returncode, len((tmp_path / "out.csv").read_text().splitlines())) == (0, 3), done.stderr
    (tmp_path / "wrong.jsonl").write_text("{}\n[1]\n")
    wrong = tirefmu(tmp_path, "evaluate", "trento_hoosier", "wrong.jsonl", "-o", "out2.csv", package=installed)
    assert (wrong.returncode, wrong.stderr) == (2, "tirefmu: error: wrong.jsonl: line 2: not an object of numbers\n")
    done = tirefmu(tmp_path, "generate", "mf96", "--language", "markdown", "-o", "printed", package=installed)
    assert done.returncode == 0, done.stderr
    assert "| K_yalpha |" in (tmp_path / "printed" / "mf96.md").read_text()


@pytest.mark.parametrize("exported", [False, pytest.param(True, marks=HEAVY)])
def test_a_model_of_a_package_is_evaluated_exported_and_checked(installed, tmp_path, exported):
    program = "import tirefmu; tirefmu.Tire('arctangent', {'FNOMIN': 900.0, 'UNLOADED_RADIUS': 0.25}).save('my.tir')"
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    subprocess.run([sys.executable, "-P", "-c", program], check=True, cwd=tmp_path, env=environment)
    (tmp_path / "run.csv").write_text("kappa,alpha,Fz\n0.1,0.0,900\n0.0,0.1,900\n0.1,0.1,0\n")
    done = tirefmu(tmp_path, "evaluate", "my.tir", "run.csv", "-o", "out.csv", package=installed)
    assert done.returncode == 0, done.stderr
    if not exported:
        return
    built = tirefmu(tmp_path, "export", "my.tir", "-o", "my.fmu", "--proof", "run.csv", package=installed)
    assert built.returncode == 0, built.stderr
    repeated = tirefmu(tmp_path, "check", "my.fmu")  # without the package
    assert (repeated.returncode, "proof repeated" in repeated.stdout) == (0, True), repeated.stderr


@HEAVY
def test_a_tire_with_the_effect_of_a_package_needs_the_package_no_more(installed, tmp_path):
    golden = Path(__file__).parents[1] / "golden" / "MagicFormula61_Parameters.tir"
    program = f"""
import json, tirefmu
from tirefmu.symbolic.added import library
base = tirefmu.load({str(golden)!r})
tire = tirefmu.Tire("mf61", {{**base.values, "VK1": 0.3}}, effects=base.has | {{"speed_stiffness"}},
                    added=[library()["speed_stiffness"]])
tire.save("my.tir")
row = dict(alpha=0.02, Fz=4000.0, V=2 * base.values["LONGVL"])
print(json.dumps([tire.forces(**row)["Fy"].item(), base.forces(**row)["Fy"].item()]))
"""
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    run = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True, cwd=tmp_path,
                         env=environment)  # fmt: skip
    assert run.returncode == 0, run.stderr
    with_effect, without = json.loads(run.stdout)
    assert abs(with_effect / without - 1.0) > 0.05
    info = tirefmu(tmp_path, "info", "my.tir")
    assert (info.returncode, "speed_stiffness" in info.stdout) == (0, True), info.stderr


@HEAVY
def test_a_diagnosis_finds_the_effect_of_a_package(installed, tmp_path):
    golden = Path(__file__).parents[1] / "golden" / "MagicFormula61_Parameters.tir"
    program = f"""
import numpy as np, pandas as pd, tirefmu
from tirefmu.symbolic.added import library
base, rng = tirefmu.load({str(golden)!r}), np.random.default_rng(1)
n, parts = 250, []
for V in (10.0, 25.0):
    for Fz in (2000.0, 4000.0, 6000.0):
        for gamma in (0.0, 0.05):
            t, alpha = 7.0 * len(parts) + 0.02 * np.arange(n), 0.2 * np.sin(2.0 * np.pi * np.arange(n) / n)
            parts.append(pd.DataFrame(dict(t=t, alpha=alpha, gamma=gamma, Fz=Fz, V=V)))
table = pd.concat(parts, ignore_index=True)
# The effect by its law, not by its file: K_yalpha (V/V0) is that of a tire with a scaled stiffness.
for V, rows in table.groupby("V"):
    slower = base.with_values(LKY=1.0 + 0.3 * (V / base.values["LONGVL"] - 1.0))
    forces = slower.evaluate(rows, steady=True)
    for name in ("Fy", "Mz"):
        table.loc[rows.index, name] = forces[name] + rng.normal(0.0, 0.01 * forces[name].std(), len(rows))
table.to_csv("run.csv", index=False)
base.save("base.tir")
"""
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    subprocess.run([sys.executable, "-P", "-c", program], check=True, cwd=tmp_path, env=environment)
    arguments = ("diagnose", "run.csv", "--tire", "base.tir", "-o", "answer", "--quiet")
    run = tirefmu(tmp_path, *arguments, package=installed)
    answer = json.loads((tmp_path / "answer" / "diagnosis.json").read_text())
    (finding,) = answer["found"]
    assert finding["effect"] == "speed_stiffness", run.stderr
    assert finding["probability"] > 0.9
    assert abs(finding["coefficients"]["VK1"]["value"] - 0.3) < 0.03
    (fmu,) = (tmp_path / "answer").glob("improved*.fmu")
    assert tirefmu(tmp_path, "check", fmu, "run.csv").returncode == 0  # without the package


BROKEN = {
    "no import": ("effects", "broken = 'absent_package'", {}, "ModuleNotFoundError"),
    "not an effect": ("effects", "broken = 'broken'", {"snow.toml": 'name = "snow"\nphysics = "less"'}, "[[acts]]"),
    "a name in use": ("effects", "broken = 'broken'", {"temp_friction.toml": None}, "another effect temp_friction"),
    "not a model": ("models", "broken = 'broken:NUMBERS'", {}, "int is no Model"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_an_error_of_a_package_is_one_line_with_its_name(case, tmp_path):
    kind, entry, effects, message = BROKEN[case]
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "__init__.py").write_text("NUMBERS = (1,)\n")
    library = Path(__file__).parents[2] / "symbolic" / "effects"
    for name, text in effects.items():
        (tmp_path / "broken" / name).write_text(text or (library / name).read_text())
    metadata = tmp_path / "broken-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text(f"[tirefmu.{kind}]\n{entry.replace(chr(39), '')}\n")
    run = tirefmu(tmp_path, "effects", package=tmp_path)
    assert run.returncode == 2
    assert message in run.stderr
    assert "package broken" in run.stderr
    assert len(run.stderr.splitlines()) == 1
