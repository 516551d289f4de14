"""The Trento worksheet's job: its functions for MATLAB from one command, run in Octave against its results."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pandas as pd

from tirefmu.cli import main
from tirefmu.tires import Tire

from .conftest import tool

#: Columns of the worksheet and named quantities.
COLUMNS = {
    "kappa__x": "kappa_x", "Bx": "B_x", "Cx": "C_x", "Dx": "D_x", "Ex": "E_x", "SVx": "S_Vx", "Kxk": "K_xkappa",
    "SHx": "S_Hx", "mu__x": "mu_x", "alpha__y": "alpha_y", "By": "B_y", "Cy": "C_y", "Dy": "D_y", "Ey": "E_y",
    "SVy": "S_Vy", "Kya": "K_yalpha", "SHy": "S_Hy", "mu__y": "mu_y", "Br": "B_r", "Bt": "B_t", "Ct": "C_t",
    "Dr": "D_r", "Dt": "D_t", "Et": "E_t", "alpha__r": "alpha_r", "alpha__t": "alpha_t", "Gxa": "G_xa",
    "Gyk": "G_yk", "SVyk": "S_Vyk", "FX0": "F_x0", "FY0": "F_y0", "MZ0": "M_z0",
    "CorneringStiffness_x": "F_x0_slope", "CorneringStiffness_y": "F_y0_slope",
}  # fmt: skip

DRIVER = """
table = dlmread('rows.txt');
[kappa, alpha, gamma, Fz] = deal(table(:, 1), table(:, 2), table(:, 3), table(:, 4));
values = trento_coefficients();
[Fx, Fy, Mz] = trento_forces(kappa, alpha, gamma, Fz, values);
q = trento_quantities(kappa, alpha, gamma, Fz, values);
assert(isequal(Fy, trento_Fy(kappa, alpha, gamma, Fz)) && isequal(Mz, trento_Mz(kappa, alpha, gamma, Fz)));
s = trento_stiffness(kappa, alpha, gamma, Fz);
h = 1e-6;
slope = (trento_Fy(kappa, alpha + h, gamma, Fz) - trento_Fy(kappa, alpha - h, gamma, Fz))/(2*h);
assert(max(abs(slope - s.Fy.alpha)) < 1e-4*max(abs(slope)));
assert(isscalar(trento_Fy()) && isequal(size(trento_Fy([], zeros(2, 3))), [2 3]));
"""


def test_the_worksheets_functions_from_one_command(golden, tmp_path):
    octave = tool("octave-cli")
    names = {"FZ0": "FNOMIN", "R0": "UNLOADED_RADIUS"}
    parameters = json.loads((golden / "mf96_trento_params.json").read_text(encoding="utf-8"))
    values = {names.get(key, key.upper()): value for key, value in parameters.items()}
    tire = tmp_path / "trento.tir"
    Tire("mf96", values, signs="adapted-sae").save(tire)
    rows = pd.read_csv(golden / "mf96_trento.csv")
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
