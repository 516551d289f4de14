"""``tirefmu diagnose``: the files that it writes, and the agreement of the tires with the report."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from tirefmu.commands.cli import main
from tirefmu.diagnosis.diagnose import COMPARING
from tirefmu.tires import Tire, read_tir

from .test_printed_commands import accepted

EFFECTS = ("load_friction", "load_stiffness")
VALUES = {
    "FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "NOMPRES": 2e5, "INFLPRES": 2e5, "PCY1": 1.35, "PDY1": 1.1, "PDY2": -0.1,
    "PEY1": -0.6, "PKY1": 25.0, "PKY2": 1.9, "PVY3": 0.5, "PKY6": 1.3,
}  # fmt: skip


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Slow alpha sweeps at three loads and three inclinations of a tire with camber thrust, Fy only, with noise."""
    rng = np.random.default_rng(5)
    rows = []
    for load in (1500.0, 3000.0, 4500.0):
        for gamma in (-0.06, 0.0, 0.06):
            sweep = 0.15 * np.sin(np.linspace(0, 2 * np.pi, 260))
            rows.append(pd.DataFrame({"alpha": sweep, "gamma": gamma, "Fz": load}))
    table = pd.concat(rows, ignore_index=True).assign(kappa=0.0, p=2e5, V=16.7)
    table.insert(0, "t", np.arange(len(table)) * 0.02)
    tire = Tire("mf61", VALUES, effects=[*EFFECTS, "camber_thrust"], signs="adapted-sae")
    forces = tire.evaluate(table, signs="adapted-sae")
    table["Fy"] = forces["Fy"] + rng.normal(0, 20.0, len(table))
    path = tmp_path_factory.mktemp("recording") / "sweeps.csv"
    table.to_csv(path, index=False)
    return path


def test_a_hidden_effect_is_identified_and_written(recording, tmp_path, capsys):
    folder = tmp_path / "answer"
    arguments = ["diagnose", str(recording), "--signs", "adapted-sae", "--effects", ",".join(EFFECTS), "--nominal",
                 "Fz0=3000,R0=0.3,p0=200000,V0=16.7", "-o", str(folder), "--no-fmu"]  # fmt: skip
    assert main(arguments) == 0
    reported = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    captured = capsys.readouterr()
    printed = " ".join(captured.out.split())  # progress is on standard error
    assert printed.startswith(f"verdict: {reported['headline']} - Missing: camber_thrust (")
    assert all(sentence in printed for sentence in reported["verdict"].split(". "))
    command, options = accepted(captured.out.splitlines()[-1].removeprefix("next: "))
    assert (command, options["tires"]) == ("export", (folder / reported["tire"],))
    lines = captured.err.splitlines()
    stages = [line.partition(":")[0] for line in lines if line.endswith(" s") and ";" not in line]
    assert stages == [
        "fitting the baseline model", "comparing explanations", "fitting the best explanation", "writing the report",
    ]  # fmt: skip
    running = [line for line in lines if line.startswith(COMPARING) and ";" in line]
    assert all(" leads" in line for line in running)
    assert any(line.startswith(f"{COMPARING}: adding an effect to camber_thrust") for line in lines)
    assert reported["found"][0]["effect"] == "camber_thrust"
    assert reported["gap"]["holdout"]["Fy"]["after"] < 0.6 * reported["gap"]["holdout"]["Fy"]["before"]
    improved, base = read_tir(folder / reported["tire"]), read_tir(folder / reported["base_tire"])
    assert improved.has - base.has == {"camber_thrust"}
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert reported["headline"] in page
    assert "K_ygamma0 = " in page
    provenance = page.split("<h2>Provenance</h2>")[1]
    assert "tirefmu diagnose " in provenance
    assert "SHA-256 of the values" in provenance
