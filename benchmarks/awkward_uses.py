"""What tirefmu answers to awkward arrays, property files, fits and printed code: the second table of awkward_inputs.

Each use is a function of an empty folder that returns the answer.
"""

from __future__ import annotations

import contextlib
import io
import runpy
import subprocess
import warnings
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu import evaluate
from tirefmu.applications.driving.inputs.log import read_log
from tirefmu.applications.exports.printout import generate
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.tires import published

Use = Callable[[Path], str]
TIRE = published("trento_hoosier").in_signs("iso")
#: What the uses need that may not be installed: a package or a program.
NEEDS = {
    "code: JAX in single precision": "jax",
    "code: V = 0 with floating-point traps": "cc",
    "code: -ffast-math": "cc",
}
#: The text of a small tire; other lines follow.
SMALL = """[MODEL]
FITTYP = {fittyp}
TYRESIDE = '{side}'
[DIMENSION]
UNLOADED_RADIUS = {radius}
[VERTICAL]
FNOMIN = 4000
[LATERAL_COEFFICIENTS]
PCY1 = 1.3
PDY1 = 1
PKY1 = -20
PKY2 = 1.5
"""
TRAPS = """
#include <fenv.h>
#include <stdio.h>
#include "TIRE.h"
int main(void)
{
    double results[16];
    TIRE_inputs x = {0};
    x.Fz = 900.0;
    feclearexcept(FE_ALL_EXCEPT);
    TIRE_forces(&x, results);
    puts(fetestexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW) ? "an exception is raised" : "no exception is raised");
    return 0;
}
"""


def refused(**inputs: object) -> Use:
    """Return the use of `Tire.forces` with inputs."""

    def use(_: Path) -> str:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                side = TIRE.forces(**inputs)["Fy"]
            except TirefmuError as error:
                return f"refused: {error}"
        return f"warning: {caught[0].message}" if caught else f"evaluated: Fy {side}"

    return use


def command(words: str, *arguments: str, files: dict[str, str]) -> Use:
    """Return the use of a command on files: its lines that have one of some words ("|" between them)."""

    def use(folder: Path) -> str:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed), contextlib.chdir(folder):
            status = main(list(arguments))
        whole = printed.getvalue().replace("\n    ", " ")  # lines that are wrapped
        shown = (line for line in whole.splitlines() if any(word in line for word in words.split("|")))
        return "\n".join([f"exit {status}", *(" ".join(line.split()).removeprefix("- ") for line in shown)])

    return use


def tir(more: str = "", *, fittyp: int = 61, side: str = "LEFT", radius: float = 0.3) -> dict[str, str]:
    """Return a property file."""
    return {"a.tir": SMALL.format(fittyp=fittyp, side=side, radius=radius) + more}


def sweep(largest: float) -> dict[str, str]:
    """Return the table of a cornering test at three loads up to a slip angle in deg, with noise."""
    random, rows = np.random.default_rng(5), 300
    alpha = np.tile(np.radians(largest) * np.sin(np.linspace(0.0, 4.0 * np.pi, rows)), 3)
    load = np.repeat([1500.0, 3000.0, 4500.0], rows)
    side = -load * np.sin(1.4 * np.arctan(10.0 * alpha)) + random.normal(0.0, 12.0, 3 * rows)
    columns = {"t": 0.02 * np.arange(3 * rows), "alpha": alpha, "Fz": load, "Fy": side, "gamma": 0.0, "V": 16.7}
    return {"a.csv": pd.DataFrame(columns).round(6).to_csv(index=False)}


def fit(words: str, files: dict[str, str], *options: str) -> Use:
    """Return the use of a fit of MF6.1 to a table."""
    nominal = ("--nominal", "Fz0=3000,R0=0.32")
    return command(words, "fit", "a.csv", "--model", "mf61", *nominal, *options, "-o", "b.tir", files=files)


def beyond_90_deg(_: Path) -> str:
    """Return side forces at slip angles beyond 90 deg."""
    angles = [80.0, 95.0, 120.0, 179.0]
    forces = evaluate(TIRE, pd.DataFrame({"alpha [deg]": angles, "Fz [N]": 900.0}))["Fy"]
    return "; ".join(f"Fy {force:.0f} N at {angle:.0f} deg" for angle, force in zip(angles, forces, strict=True))


def whole_header(_: Path) -> str:
    """Return the steering angle of a log whose column is named whole, with its unit."""
    header = "steering_wheel [deg]"
    rows = pd.DataFrame({"t": np.arange(0.0, 10.0, 0.01), header: 90.0, "speed": 10.0, "yaw_rate": 0.1, "ay": 1.0})
    return f"{header!r} is read as {read_log(rows, {'steer': header}).values('steer')[0]:.4f} rad for 90"


def subsets(folder: Path) -> str:
    """Return how many subsets of the outputs are printed in C."""
    chosen = [part for size in range(1, len(TIRE.outputs) + 1) for part in combinations(TIRE.outputs, size)]
    written = [generate(TIRE, "c", folder, functions=["forces"], only=part, rows=1) for part in chosen]
    return f"{len(written)} of {len(chosen)} subsets are printed"


def gradients(folder: Path) -> str:
    """Return at how many points of the JAX printout derivatives are finite in single precision."""
    import jax

    generate(TIRE, "jax", folder, functions=["forces"], rows=1)
    (path,) = (path for path in folder.glob("*.py") if "selftest" not in path.name)
    module = runpy.run_path(str(path))
    points = np.float32([[0.0, 0.0, 0.0], [0.0, 0.0, 900.0], [0.0, 0.1, 0.0]])
    side = lambda x: module["forces"](kappa=x[0], alpha=x[1], Fz=x[2])["Fy"]  # noqa: E731
    found = [np.isfinite(jax.grad(side)(x)).all() for x in points]
    return f"{sum(found)} of {len(found)} gradients are finite, at zero slip and without load"


def compiled(folder: Path, option: str) -> subprocess.CompletedProcess[str]:
    """Compile the printed C of a tire with an option, and a program that states the exceptions at V = 0."""
    generate(TIRE, "c", folder, functions=["forces"], rows=1)
    (header,) = folder.glob("*.h")
    (folder / "main.c").write_text(TRAPS.replace("TIRE", header.stem), encoding="utf-8")
    arguments = ["cc", option, "main.c", "-lm", "-o", "main"]
    return subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)


def standstill(folder: Path) -> str:
    """Return whether the printed C raises a floating-point exception at V = 0."""
    compiled(folder, "-O2")
    return subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout.strip()


def fast_math(folder: Path) -> str:
    """Return how a compiler with -ffast-math ends."""
    (line,) = (line for line in compiled(folder, "-ffast-math").stderr.splitlines() if "error: #error" in line)
    return line[line.index("#error") :]


def uses() -> dict[str, Use]:
    """Return the awkward uses by their description."""
    ramp = np.linspace(-1.0, 1.0, 5)
    words = "not determined|not fitted"
    return {
        "array: slip angles in degrees": refused(alpha=12.0 * ramp),
        "array: camber in degrees": refused(gamma=[0.0, 2.0, 4.0]),
        "array: slips in percent": refused(kappa=20.0 * ramp),
        "array: slips in percent, up to 10": refused(kappa=10.0 * ramp),
        "array: slips in percent, up to 8, of one sign": refused(kappa=[0.0, 2.0, 5.0, 8.0]),
        "array: negative loads": refused(Fz=-900.0 * np.ones(3)),
        "array: loads far beyond the range": refused(Fz=[900.0, 90e3]),
        "array: shapes that do not broadcast": refused(alpha=np.zeros(3), Fz=np.full(2, 900.0)),
        "array: texts": refused(Fz=["900", "400"]),
        "slip angles beyond 90 deg": beyond_90_deg,
        "tire: TYRESIDE = 'SYMMETRIC' with shifts": command(
            "SYMMETRIC", "info", "a.tir", files=tir("PHY1 = 0.01\n", side="SYMMETRIC")
        ),
        "tire: a LEFT file for four corners": command(
            "mirror", "export", *4 * ["a.tir"], "--ssp", "car.ssp", files=tir("PHY1 = 0.01\n")
        ),
        "tire: radius in mm": command("in mm", "info", "a.tir", files=tir(radius=300)),
        "tire: E above 1": command("wrong sign|E_y  ", "info", "a.tir", files=tir("PEY1 = 4\n")),
        "tire: a weighting function above 1": command("G_xa", "info", "a.tir", files=tir("RHX1 = 0.05\n")),
        "tire: forces beyond the friction ellipse": command(
            "ellipse", "info", "a.tir", files=tir("RBX1 = 0.5\nRCX1 = 1\nRBY1 = 0.5\nRCY1 = 1\n")
        ),
        "tire: USE_MODE 3": command("USE_MODE", "export", "a.tir", "--kind", "ssv", "-o", "a.ssv", files=tir(
            "[MODEL]\nUSE_MODE = 3\n")),
        "tire: FITTYP 51": command("FITTYP", "info", "a.tir", files=tir(fittyp=51)),
        "tire: FITTYP 97": command("FITTYP", "info", "a.tir", files=tir(fittyp=97)),
        "fit: data that never reach the peak": fit(words, sweep(2.0)),
        "fit: cornering only": fit(words, sweep(12.0)),
        "fit: an effect with neutral values": fit(
            "does nothing", sweep(12.0), "--effects", "load_friction,load_stiffness,relax_mf", "--all"
        ),
        "log: a header named whole with its unit": whole_header,
        "code: every subset of the outputs": subsets,
        "code: JAX in single precision": gradients,
        "code: V = 0 with floating-point traps": standstill,
        "code: -ffast-math": fast_math,
    }  # fmt: skip
