"""The command line as a user runs it, and a small virtual bench to run it on."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
from math import radians

import pytest

from tirefmu.commands.cli import main
from tirefmu.commands.demo import bench_tire
from tirefmu.fmu import export
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, write_table
from tirefmu.tires import published

#: Few enough for a fit that takes a second.
EFFECTS = "load_friction,load_stiffness,camber_thrust,combined_Gxa,combined_Gyk"


@dataclass(frozen=True)
class Outcome:
    """The result of a command: exit code and printed text."""

    status: int
    out: str
    err: str

    @property
    def text(self):
        """Standard output as one line, without the breaks of long lines."""
        return " ".join(self.out.split())


def run(*arguments):
    """Run a command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([str(argument) for argument in arguments])
    return Outcome(status, out.getvalue(), err.getvalue())


@pytest.fixture(scope="session")
def command():
    return run


@pytest.fixture(scope="session")
def published_tir(tmp_path_factory):
    """Return the published tire as a file."""
    path = tmp_path_factory.mktemp("tires") / "trento.tir"
    published("trento_hoosier").save(path)
    return path


@pytest.fixture(scope="session")
def published_fmu(tmp_path_factory):
    """Return the FMU of the published tire."""
    return export(published("trento_hoosier"), tmp_path_factory.mktemp("fmus") / "trento.fmu")


@pytest.fixture(scope="session")
def bench_csv(once):
    """Return a recording of 800 rows, in ISO signs, with noise."""

    def write(folder):
        cambers, angles = [0.0, radians(2.0), radians(4.0)], [0.0, radians(3.0), radians(6.0)]
        lateral = alpha_sweeps([220.0, 700.0, 1120.0], cambers, sample_rate=4.0)
        drive_brake = kappa_sweeps([220.0, 700.0, 1120.0], angles, sample_rate=4.0)
        program = concatenate([lateral, drive_brake], signs="iso")
        write_table(VirtualBench(bench_tire(), Noise(), seed=3).run(program).table, folder / "bench.csv")
        return folder / "bench.csv"

    return once("bench", write)


@pytest.fixture(scope="session")
def validated(command, bench_csv, once):
    """Return what a fit with cross-validation in two folds prints, and its JSON file."""

    def fitted(folder):
        path = folder / "fit.json"
        options = ("--model", "mf96", "--effects", EFFECTS, "--nominal", "Fz0=220,R0=0.23", "--cross-validate", "2")
        outcome = command("fit", bench_csv, *options, "-o", path.with_suffix(".tir"), "--json", path)
        assert outcome.status == 0, outcome.err
        return outcome, json.loads(path.read_text(encoding="utf-8"))

    return once("validated", fitted)


@pytest.fixture(scope="session")
def chain(command, bench_csv, once):
    """Return the folder of a fit and its FMUs, and what each command printed."""

    def run_all(folder):
        outcomes = {
            "fit": command(
                "fit", bench_csv, "--model", "mf96", "--effects", EFFECTS, "--nominal", "Fz0=220,R0=0.23",
                "-o", folder / "fitted.tir", "--all",
                "--json", folder / "fit.json", "--report", folder / "report.html", "--figures", folder / "figures",
            )
        }  # fmt: skip
        for fmi in ("2", "3"):
            fmu = folder / f"fmi{fmi}.fmu"
            outcomes[f"export {fmi}"] = command("export", folder / "fitted.tir", "-o", fmu, "--fmi", fmi)
            outcomes[f"check {fmi}"] = command("check", fmu, bench_csv, "--json", folder / f"check{fmi}.json")
        return folder, outcomes

    return once("chain", run_all)
