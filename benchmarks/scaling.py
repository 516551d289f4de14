"""The small tire on another ground, by scaling factors alone: what the UNICAMP paper concludes, tried.

    python benchmarks/scaling.py

Virtual bench, the paper's program, white noise of 2 N. A tire is fitted on the first ground; on a second one with 0.7
times the friction some points are measured, and factors fitted to them. Told is the rms of Fx and Fy together against
the noise-free truth at all points of the program.
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
#: A recipe that frees what another ground changes, and nothing else.
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
    """Run the paper's program; forces alone are measured."""
    recording = VirtualBench(tire, noise, seed).run(small_tire_program()).with_signs("iso")
    return replace(recording, table=recording.table.drop(columns=["Mx", "My", "Mz"]))


def distances(few: str) -> dict[str, dict[str, float]]:
    """Return the rms in N of every way to the second ground's tire, by the points that it was given."""
    truth = published("unicamp_small_tire")
    there = replace(truth, values={**truth.values, "LMUX": FRICTION, "LMUY": FRICTION})
    nominal = {"Fz0": truth.values["FNOMIN"], "R0": truth.values["UNLOADED_RADIUS"], "p0": truth.values["INFLPRES"]}
    effects = truth.has - {"pressure_stiffness", "pressure_friction"}  # one pressure
    first = fit([measured(truth, NOISE, 1)], truth.model, effects=effects, nominal=nominal).tire
    recording, exact = measured(there, NOISE, 2), measured(there, Noise.none(), 0).table

    def distance(tire: Tire) -> float:
        computed = tire.evaluate(exact, signs="iso")
        return float(np.sqrt(np.mean([(computed[force] - exact[force]) ** 2 for force in ("Fx", "Fy")])))

    table = recording.table
    parts = {
        "all 297 points": table["t"] >= 0.0,
        "99 points, one load": table["Fz"] == 110.0,
        "57 points of pure slip": (table["alpha"].abs() < 1e-6) | (table["kappa"].abs() < 1e-6),
    }
    told = {}
    for part, rows in parts.items():
        given = replace(recording, table=table[rows].reset_index(drop=True))
        told[part] = {
            "unchanged": distance(first),
            "four factors": distance(fit([given], truth.model, start=first, recipe=few).tire),
            "recipe scaling": distance(fit([given], truth.model, start=first, recipe="scaling").tire),
            "fitted anew": distance(fit([given], truth.model, effects=effects, nominal=nominal).tire),
        }
    return told


def main() -> None:
    """Tell the distances as a Markdown table."""
    with tempfile.TemporaryDirectory() as folder:
        few = Path(folder) / "few.toml"
        few.write_text(FEW, encoding="utf-8")
        told = distances(str(few))
    ways = list(next(iter(told.values())))
    print(f"| measured on the second ground | {' | '.join(ways)} |\n|---|{'---|' * len(ways)}")
    for part, row in told.items():
        print(f"| {part} | {' | '.join(f'{rms:.2f}' for rms in row.values())} |")


if __name__ == "__main__":
    main()
