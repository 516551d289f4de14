"""The Trento worksheet's job: its functions for MATLAB from one command, run in Octave against its results."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from tirefmu.applications.exports import generate, printed
from tirefmu.commands.cli import main
from tirefmu.symbolic.printers.languages.program import FUNCTIONS
from tirefmu.tires import Tire

from ..golden import test_trento
from .conftest import command_of, tool, with_faults
from .self_tests import differences

#: Columns of the worksheet and named quantities.
COLUMNS = {theirs: ours for theirs, ours in test_trento.COLUMNS.items() if ours not in ("Fx", "Fy")}
#: Octave ignores arguments blocks with a warning, so all arguments are given.
DRIVER = """
warning('off');
table = dlmread('rows.txt');
in = struct('kappa', table(:, 1), 'alpha', table(:, 2), 'gamma', table(:, 3), 'Fz', table(:, 4));
values = trento_coefficients();
[Fx, Fy, Mz] = trento_forces(in, values);
q = trento_quantities(in, values);
assert(isequal(Fy, trento_Fy(in, values)) && isequal(Mz, trento_Mz(in, values)));
s = trento_stiffness(in, values);
h = 1e-6;
[left, right] = deal(in);
left.alpha = in.alpha - h;
right.alpha = in.alpha + h;
slope = (trento_Fy(right, values) - trento_Fy(left, values))/(2*h);
assert(max(abs(slope - s.Fy.alpha)) < 1e-4*max(abs(slope)));
in = trento_inputs();
assert(isscalar(trento_Fy(in, values)));
in.alpha = zeros(2, 3);
assert(isequal(size(trento_Fy(in, values)), [2 3]));
"""


def test_the_worksheets_functions_from_one_command(golden, tmp_path):
    octave = tool("octave-cli")
    names = {"FZ0": "FNOMIN", "R0": "UNLOADED_RADIUS"}
    parameters = json.loads((golden / "mf96_trento_params.json").read_text(encoding="utf-8"))
    values = {names.get(key, key.upper()): value for key, value in parameters.items()}
    tire = tmp_path / "trento.tir"
    Tire("mf96", values, signs="adapted-sae").save(tire)
    rows = pd.read_csv(golden / "mf96_trento.csv.xz")
    np.savetxt(tmp_path / "rows.txt", rows[["kappa", "alpha", "gamma", "Fz"]], fmt="%.17g")

    arguments = ["generate", str(tire), "--language", "matlab", "-o", str(tmp_path), "--values", "struct", "--quiet"]
    assert main(arguments) == 0
    written = ", ".join(f"q.{name}" for name in COLUMNS.values())
    (tmp_path / "driver.m").write_text(f"{DRIVER}dlmwrite('out.txt', [Fx, Fy, {written}], 'precision', '%.17g');\n")
    command = [octave, "--norc", "--no-history", "--quiet", "driver.m"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")

    ours = np.loadtxt(tmp_path / "out.txt", delimiter=",")
    forces, reference = ours[:, :2], rows[["FX", "FY"]].to_numpy() * [1, -1]  # the printout is in ISO
    np.testing.assert_allclose(forces, reference, rtol=1e-9, atol=1e-9)
    # The sign of some quantities depends on the convention.
    np.testing.assert_allclose(np.abs(ours[:, 2:]), np.abs(rows[list(COLUMNS)].to_numpy()), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("values", ["inline", "struct", "file"])
def test_functions_take_a_structure_that_an_arguments_block_declares(trento, values):
    """The functions read inputs and coefficients where they need them: no line only gives a value another name."""
    files = printed(trento, "matlab", values=values, rows=1)
    functions = {name: text for name, text in files.items() if "\n    arguments\n" in text}
    assert functions.keys() == {name for name in files if name.endswith(".m")} - {
        f"mf96_{name}.m" for name in ("inputs", "coefficients", "selftest")
    }
    given = "inputs" if values == "inline" else "inputs, c"
    for name, text in functions.items():
        assert re.match(rf"function (\w+|\[.*\]) = {name[:-2]}\({given}\)\n", text), name
        assert "        inputs (1,1) struct = mf96_inputs()\n" in text
        assert not re.search(r"^    (\w+) = (?:\w+\.)?\1;", text, re.MULTILINE), name


def test_the_code_is_matlab(trento, tmp_path):
    """Octave skips arguments blocks; this parser of MATLAB reads them."""
    pytest.importorskip("miss_hit_core")
    for values in ("inline", "struct", "file"):
        generate(trento, "matlab", tmp_path, functions=FUNCTIONS[:3], values=values, rows=1)
        command = [sys.executable, "-m", "miss_hit_core.mh_style", "--matlab", "2021a", "--no-style", "--brief", "."]
        run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert run.returncode == 0, run.stdout


def test_a_session_outlives_its_self_test(trento, printout):
    """The self-test is a function that ends with an error: it neither exits nor changes variables."""
    folder = printout(trento, "matlab", "session", functions=["forces"], rows=3)
    (stored,) = folder.glob("*_selftest.txt")
    *command, code = command_of("matlab", folder)
    assert differences([*command, code], folder)[0] == 0
    stored.write_text(with_faults(stored.read_text())[0])
    session = f"try, {code}, catch problem, disp('caught'), end, disp('alive'), disp(exist('expected'))"
    run = subprocess.run([*command, session], cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0
    assert run.stdout.split()[-3:] == ["caught", "alive", "0"]
