"""Every kind of FMU in every installed program: python host_table.py [--write] runs hosts/*.py and compares.

The inputs are constant for 1 s, so that the slips have settled: the forces are then those of `Tire.forces` for the
slips and the load that the FMU reports.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import tirefmu
from tirefmu.tires import published

TIRE = "trento_hoosier"
#: Constant inputs by kind, beside the start values, and the outputs that are read.
INPUTS = {
    "slip": {"kappa": 0.02, "alpha": 0.05}, "wheel": {"V_y": 0.75}, "hub": {"v_y": 0.75}, "hub-torque": {"v_y": 0.75},
}  # fmt: skip
OUTPUTS = {
    "slip": "Fx,Fy", "wheel": "Fx,Fy,kappa,alpha", "hub": "Fx,Fy,kappa,alpha,Fz", "hub-torque": "Fx,Fy,kappa,alpha,Fz",
}  # fmt: skip
#: Largest error of a force relative to 1 N and its size.
TOLERANCE = 1e-6
PAGE = Path(__file__).parents[1] / "docs" / "simulation_programs.md"
BEGIN, END = "<!-- host table: begin -->\n", "<!-- host table: end -->\n"


@dataclass(frozen=True)
class Program:
    """A program: its script, its package, and what it can run; a trap that a user must know.

    `python` is a variable of the environment: the Python of a package that cannot be installed beside tirefmu.
    """

    script: str
    package: str
    title: str
    versions: tuple[int, ...]
    kinds: tuple[str, ...]
    trap: str
    python: str = ""


BOTH = ("CoSimulation", "ModelExchange")
PROGRAMS = (
    Program("in_fmpy.py", "fmpy", "fmpy", (2, 3), BOTH,
            "`output_interval=0.001`: simulate_fmu doubles the step until there are at most 1000 (16 ms for 10 s)"),
    Program("in_libcosim.py", "libcosimpy", "libcosim", (2,), BOTH[:1],
            "FMI 2 only; its observer shows 0 before the first step"),
    Program("in_ecos.py", "ecospy", "ecos", (2, 3), BOTH[:1],
            "times are sums of steps: count steps instead of comparing times"),
    Program("in_fmucontainer.py", "fmu-manipulation-toolbox", "fmucontainer", (2, 3), BOTH[:1],
            "parameters are on the container with `-auto-parameter` only"),
    Program("in_pathsim.py", "pathsim-fmi", "PathSim", (2, 3), BOTH,
            "a port without connection is 0, also the load, the speed and the rotation matrix: connect every input;"
            " Model Exchange runs with `wheel` inputs: it needs states, and sets every input to 0 first, which hub"
            " inputs refuse"),
    Program("in_fmuloader.py", "fmuloader", "fmuloader", (2, 3), BOTH[:1],
            "the bare C interface: it reads no model description, and start values are those of the FMU"),
    Program("in_cofmupy.py", "cofmupy", "CoFMuPy", (2, 3), BOTH[:1],
            "an input without a value in the configuration is 0, also the load and the speed; it needs fmpy 0.3.20,"
            " and so a Python of its own: its path is in TIREFMU_COFMUPY", "TIREFMU_COFMUPY"),
    Program("in_casadi.py", "casadi", "CasADi (DaeBuilder)", (2, 3), BOTH[1:],
            "parameters keep their values: set them with `DaeBuilder.set` before `create`; it refuses arrays"),
)  # fmt: skip


def interpreter(program: Program) -> str:
    """Return the Python that runs a program; empty if there is none."""
    return os.environ.get(program.python, "") if program.python else sys.executable


def installed(program: Program) -> str:
    """Return the version of a program; empty if it is not installed."""
    question = f"from importlib.metadata import version; print(version({program.package!r}))"
    if not interpreter(program):
        return ""
    return subprocess.run(
        [interpreter(program), "-c", question], capture_output=True, text=True, check=False
    ).stdout.strip()


def error_of(program: Program, path: Path, inputs: str, kind: str) -> float:
    """Return the largest error of the forces in a program; infinite if it did not run."""
    script = Path(__file__).parent / "hosts" / program.script
    command = [interpreter(program), script, path, kind, json.dumps(INPUTS[inputs]), OUTPUTS[inputs]]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    answers = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not answers:
        return float("inf")
    shown = {**INPUTS[inputs], **json.loads(answers[-1])}
    slips = {name: shown[name] for name in ("kappa", "alpha", "Fz") if name in shown}
    tire = published(TIRE).in_signs("iso")
    expected = tire.forces(**({"Fz": tire.nominal("Fz"), "gamma": 0.0} | slips))
    return max(abs(shown[name] - float(expected[name])) / (1.0 + abs(float(expected[name]))) for name in ("Fx", "Fy"))


def rows() -> list[str]:
    """Return a row of the table for each program that is installed."""
    lines = []
    with tempfile.TemporaryDirectory() as name:
        paths = {
            (inputs, fmi): tirefmu.export(TIRE, Path(name) / f"{inputs}_{fmi}.fmu", inputs=inputs, fmi=fmi)
            for inputs in INPUTS for fmi in (2, 3)
        }  # fmt: skip
        for program in filter(installed, PROGRAMS):
            errors = {
                (inputs, fmi, kind): error_of(program, paths[inputs, fmi], inputs, kind)
                for inputs in INPUTS for fmi in program.versions for kind in program.kinds
            }  # fmt: skip
            ran = {key: error for key, error in errors.items() if error < TOLERANCE}
            failed = ", ".join(f"{i} FMI {v} {k}" for i, v, k in sorted(errors.keys() - ran.keys())) or "-"
            script = f"`examples/hosts/{program.script}`"
            largest = max(ran.values(), default=float("inf"))
            cells = (f"{program.title} {installed(program)}", f"{len(ran)} of {len(errors)}", f"{largest:.0e}", failed)
            lines.append(f"| {' | '.join((*cells, script, program.trap))} |")
            print(lines[-1], flush=True)
    return lines


def main() -> None:
    """Print the table, or write it into the page of the documentation."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE.name}")
    given = parser.parse_args()
    head = ["| program | runs | largest error | did not run | script | known trap |", "|---|---|---|---|---|---|"]
    table = "\n".join([*head, *rows()]) + "\n"
    if given.write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        PAGE.write_text(before + BEGIN + table + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
