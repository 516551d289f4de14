"""Transfer of a small tire to another surface by scaling factors alone: test of a conclusion of the UNICAMP paper.

    python benchmarks/scaling.py

Virtual bench, test program of the paper, white noise of 2 N. A tire is fitted on the first surface. On a second one
with 0.7 times the friction, some points are measured and factors are fitted to them. The result is the rms error of Fx
and Fy together against the exact forces at all points of the program.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from tirefmu.fitting import fit
from tirefmu.measurements import ChannelNoise, Noise, Recording, VirtualBench, small_tire_program
from tirefmu.tires import Tire, published

NOISE = Noise({name: ChannelNoise(constant=2.0) for name in ("Fx", "Fy")})
FRICTION = 0.7
#: A recipe that fits only the factors that depend on the surface.
FEW = """
[[stage]]
name = "friction and slip stiffness"
[stage.free]
LMUX = { guess = 1, lower = 0.1, upper = 10 }
LMUY = { guess = 1, lower = 0.1, upper = 10 }
LKX = { guess = 1, lower = 0.1, upper = 10 }
LKY = { guess = 1, lower = 0.1, upper = 10 }
"""


def measured(tire: Tire, noise: Noise, seed: int) -> Recording:
    """Return a recording of the program of the paper with Fx and Fy only."""
    recording = VirtualBench(tire, noise, seed).run(small_tire_program()).with_signs("iso")
    return replace(recording, table=recording.table.drop(columns=["Mx", "My", "Mz"]))


def rms_errors(few: str) -> dict[str, dict[str, float]]:
    """Return the rms error in N of each method for the second surface, by the measured points."""
    truth = published("unicamp_small_tire")
    second = replace(truth, values={**truth.values, "LMUX": FRICTION, "LMUY": FRICTION})
    nominal = {"Fz0": truth.values["FNOMIN"], "R0": truth.values["UNLOADED_RADIUS"], "p0": truth.values["INFLPRES"]}
    effects = truth.has - {"pressure_stiffness", "pressure_friction"}  # one pressure
    first = fit([measured(truth, NOISE, 1)], truth.model, effects=effects, nominal=nominal).tire
    recording, exact = measured(second, NOISE, 2), measured(second, Noise.none(), 0).table

    def rms_error(tire: Tire) -> float:
        computed = tire.evaluate(exact, signs="iso")
        return float(np.sqrt(np.mean([(computed[force] - exact[force]) ** 2 for force in ("Fx", "Fy")])))

    table = recording.table
    parts = {
        "all 297 points": table["t"] >= 0.0,
        "99 points, one load": table["Fz"] == 110.0,
        "57 points of pure slip": (table["alpha"].abs() < 1e-6) | (table["kappa"].abs() < 1e-6),
    }
    errors = {}
    for part, rows in parts.items():
        given = replace(recording, table=table[rows].reset_index(drop=True))
        errors[part] = {
            "unchanged": rms_error(first),
            "four factors": rms_error(fit([given], truth.model, start=first, recipe=few).tire),
            "recipe scaling": rms_error(fit([given], truth.model, start=first, recipe="scaling").tire),
            "new fit": rms_error(fit([given], truth.model, effects=effects, nominal=nominal).tire),
        }
    return errors


def main() -> None:
    """Print the errors as a Markdown table."""
    with tempfile.TemporaryDirectory() as folder:
        few = Path(folder) / "few.toml"
        few.write_text(FEW, encoding="utf-8")
        errors = rms_errors(str(few))
    methods = list(next(iter(errors.values())))
    print(f"| measured on the second surface | {' | '.join(methods)} |\n|---|{'---|' * len(methods)}")
    for part, row in errors.items():
        print(f"| {part} | {' | '.join(f'{rms:.2f}' for rms in row.values())} |")


if __name__ == "__main__":
    main()
