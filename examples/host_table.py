"""Every kind of FMU in every installed program: python host_table.py [--write] runs hosts/*.py and compares.

One tire, and four together: two front and two rear tires of different values, each with its own inputs. The inputs are
constant for 1 s, so that the slips have settled: the forces are then those of `Tire.forces` for the slips and the load
that the FMU reports. Every kind that a program has an interface for is tried, also those that it does not read.

Programs that cannot be installed beside tirefmu have a Python of their own; TIREFMU_PYTHONS lists such Pythons.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from pathlib import Path

import tirefmu
from tirefmu.tires import Tire, published

TIRE = "trento_hoosier"
#: Constant inputs by kind, beside the start values, and the outputs that are read.
INPUTS = {
    "slip": {"kappa": 0.02, "alpha": 0.05}, "wheel": {"V_y": 0.75}, "hub": {"v_y": 0.75}, "hub-torque": {"v_y": 0.75},
}  # fmt: skip
OUTPUTS = {
    "slip": "Fx,Fy", "wheel": "Fx,Fy,kappa,alpha", "hub": "Fx,Fy,kappa,alpha,Fz", "hub-torque": "Fx,Fy,kappa,alpha,Fz",
}  # fmt: skip
#: Each tire of a car: front or rear, and the factor of its inputs.
CAR = {"FL": ("front", 1.0), "FR": ("front", 0.8), "RL": ("rear", 0.6), "RR": ("rear", 0.4)}
#: Largest error of a force relative to 1 N and its size.
TOLERANCE = 1e-6
PAGE = Path(__file__).parents[1] / "docs" / "simulation_programs.md"
BEGIN, END = "<!-- host table: begin -->\n", "<!-- host table: end -->\n"
CS, ME = KINDS = ("CoSimulation", "ModelExchange")
#: Kind of inputs, version of FMI, kind of FMU, number of tires.
Case = tuple[str, int, str, int]
CASES: tuple[Case, ...] = tuple(product(INPUTS, (2, 3), KINDS, (1, len(CAR))))


@dataclass(frozen=True, eq=False)
class Program:
    """A program: its script, its package, what it does not run and why, and a trap that a user must know."""

    script: str
    package: str
    title: str
    trap: str
    lacks: dict[str, str] = field(default_factory=dict)

    def reason(self, case: Case) -> str:
        """Return why the program does not run a case; empty if it should."""
        inputs, version, kind, _ = case
        names = (f"FMI {version}", kind, f"{inputs} {kind}", f"FMI {version} {kind}")
        return next((f"{name}: {self.lacks[name]}" for name in names if name in self.lacks), "")


NO_EXCHANGE = {ME: "it has no solver, its interface is that of Co-Simulation"}
NO_STATES = {f"slip {ME}": "an FMU without continuous states is refused"}
PROGRAMS = (
    Program("in_fmpy.py", "fmpy", "fmpy",
            "`output_interval=0.001`: simulate_fmu doubles the step until there are at most 1000 (16 ms for 10 s)"),
    Program("in_libcosim.py", "libcosimpy", "libcosim", "its observer shows 0 before the first step",
            {"FMI 3": "it reads FMI 1 and 2", **NO_EXCHANGE}),
    Program("in_ecos.py", "ecospy", "ecos", "times are sums of steps: count steps instead of comparing times",
            NO_EXCHANGE),
    Program("in_fmucontainer.py", "fmu-manipulation-toolbox", "fmucontainer",
            "parameters are on the container with `-auto-parameter` only", {ME: "it contains FMUs of Co-Simulation"}),
    Program("in_pathsim.py", "pathsim-fmi", "PathSim",
            "a port without connection is 0, also the load, the speed and the rotation matrix: connect every input",
            {**NO_STATES, **dict.fromkeys((f"hub {ME}", f"hub-torque {ME}"),
             "it sets every input to 0 first, which hub inputs refuse: no friction, no rotation matrix")}),
    Program("in_fmuloader.py", "fmuloader", "fmuloader",
            "the bare C interface: it reads no model description, and start values are those of the FMU",
            {ME: "the caller would be the solver: not tried"}),
    Program("in_cofmupy.py", "cofmupy", "CoFMuPy",
            "an input without a value in the configuration is 0, also the load and the speed; it needs fmpy 0.3.20",
            NO_EXCHANGE),
    Program("in_casadi.py", "casadi", "CasADi (DaeBuilder)",
            "parameters keep their values: set them with `DaeBuilder.set` before `create`; it refuses arrays",
            {CS: "it reads FMUs of Model Exchange"}),
    Program("in_jaxonomy.py", "jaxonomy", "jaxonomy",
            "its first step ends at 0; connect every input; it needs jax 0.9", NO_STATES),
    Program("in_syssimx.py", "syssimx", "SysSimX",
            "a port that is not set is 0, also the load and the speed: set every input before `initialize`",
            {"FMI 3": "it reads FMI 2", **NO_EXCHANGE}),
    Program("in_cosimtlk.py", "cosimtlk", "CoSim Toolkit",
            "`advance` compares sums of steps: count steps; it needs the package requests, too",
            {"FMI 3": "it reads FMI 2", **NO_EXCHANGE}),
    Program("in_sofirpy.py", "sofirpy", "sofirpy", "start values are its inputs: later values come from a model",
            {"FMI 3": "it reads FMI 2", **NO_EXCHANGE}),
)  # fmt: skip


@cache
def installed(program: Program) -> tuple[str, str]:
    """Return the Python that has a program, and its version; empty if there is none."""
    question = f"from importlib.metadata import version; print(version({program.package!r}))"
    for python in (sys.executable, *filter(None, os.environ.get("TIREFMU_PYTHONS", "").split(os.pathsep))):
        found = subprocess.run([python, "-c", question], capture_output=True, text=True, check=False).stdout.strip()
        if found:
            return python, found
    return "", ""


def tires() -> dict[str, Tire]:
    """Return the front and the rear tire."""
    front = published(TIRE).in_signs("iso")
    return {"front": front, "rear": replace(front, values={**front.values, "LMUY": 0.8}, name="rear")}


def export_all(folder: Path) -> dict[tuple[str, str, int], Path]:
    """Write the FMUs of all kinds of inputs, by tire, inputs and version."""
    return {
        (end, inputs, fmi): tirefmu.export(tire, folder / f"{end}_{inputs}_{fmi}.fmu", inputs=inputs, fmi=fmi)
        for end, tire in tires().items() for inputs in INPUTS for fmi in (2, 3)
    }  # fmt: skip


def error_of(program: Program, paths: dict[tuple[str, str, int], Path], case: Case) -> float:
    """Return the largest error of the forces in a program; infinite if it did not run."""
    inputs, fmi, kind, count = case
    given = {corner: {name: value * share for name, value in INPUTS[inputs].items()}
             for corner, (_, share) in list(CAR.items())[:count]}  # fmt: skip
    cars = {corner: (str(paths[CAR[corner][0], inputs, fmi]), values) for corner, values in given.items()}
    script = Path(__file__).parent / "hosts" / program.script
    command = [installed(program)[0], script, json.dumps(cars), kind, OUTPUTS[inputs]]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    answers = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not answers:
        return float("inf")
    shown = json.loads(answers[-1])
    return max(force_error(tires()[CAR[corner][0]], {**given[corner], **shown[corner]}) for corner in given)


def force_error(tire: Tire, shown: dict[str, float]) -> float:
    """Return the largest error of the forces that a program shows with slips and load."""
    slips = {name: shown[name] for name in ("kappa", "alpha", "Fz") if name in shown}
    expected = tire.forces(**({"Fz": tire.nominal("Fz"), "gamma": 0.0} | slips))
    return max(abs(shown[name] - float(expected[name])) / (1.0 + abs(float(expected[name]))) for name in ("Fx", "Fy"))


def row(program: Program, paths: dict[tuple[str, str, int], Path]) -> str:
    """Return the row of a program: what ran of one tire and of four, and why the rest did not."""
    tried = [case for case in CASES if case[2] not in program.lacks]
    errors = {case: error_of(program, paths, case) for case in tried}
    ran = {case: error for case, error in errors.items() if error < TOLERANCE}
    failed = [case for case in CASES if case not in ran]
    reasons = dict.fromkeys(program.reason(case) or f"{case} FAILS" for case in failed)
    stale = [f"{case} RUNS" for case in ran if program.reason(case)]
    counts = [sum(case[3] == count for case in ran) for count in (1, len(CAR))]
    cells = (
        f"{program.title} {installed(program)[1]}", *map(str, counts), f"{max(ran.values(), default=float('inf')):.0e}",
        "; ".join((*reasons, *stale)) or "-", f"`hosts/{program.script}`", program.trap,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def rows() -> Iterator[str]:
    """Yield a row of the table for each program that is installed."""
    with tempfile.TemporaryDirectory() as name:
        paths = export_all(Path(name))
        for program in PROGRAMS:
            if installed(program)[1]:
                yield row(program, paths)


def main() -> None:
    """Print the table, or write it into the page of the documentation."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE.name}")
    given = parser.parse_args()
    table = (
        "| program | one | four | largest error | does not run | script | known trap |\n|---|---|---|---|---|---|---|\n"
    )
    for line in rows():
        print(line, flush=True)
        table += f"{line}\n"
    if given.write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        PAGE.write_text(before + BEGIN + table + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
