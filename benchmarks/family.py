"""Fits with a family of made tires: coverage of 95 % bands and the error in combined slip, leaving one tire out.

The tires are made in plain NumPy: coefficients of one tire times correlated random factors that also follow the load.
The data of the tire that is left out have pure slip only. Run by `make family`.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.commands.demo import bench_tire
from tirefmu.fitting import fit
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, kappa_sweeps
from tirefmu.tires import Tire

#: Relative deviation of the coefficients, and how much of it they have in common by section.
DEVIATION, COMMON = 0.12, 0.5
COMBINED = ("RBX1", "RBX2", "RCX1", "RHX1", "RBY1", "RBY2", "RBY3", "RCY1", "RHY1")


def made_tires(count: int, seed: int) -> list[Tire]:
    """Return tires around one tire, with loads within a factor of 1.5 of its own."""
    base, random = bench_tire(), np.random.default_rng(seed)
    coefficients = base.symbolic_model.coefficients
    names = [name for name in coefficients if coefficients[name].fitted and base.values[name]]
    sections = [coefficients[name].section for name in names]
    tires = []
    for number in range(count):
        size = random.uniform(-1.0, 1.0)
        shared = {section: random.standard_normal() for section in sorted(set(sections))}
        factors = {
            name: 1.0 + DEVIATION * (
                COMMON * shared[section] + np.sqrt(1.0 - COMMON**2) * random.standard_normal() + 0.3 * size
            )
            for name, section in zip(names, sections, strict=True)
        }  # fmt: skip
        values = {name: value * factors.get(name, 1.0) for name, value in base.values.items()}
        values["FNOMIN"] = base.values["FNOMIN"] * 1.5**size
        tires.append(replace(base, values=values, name=f"tire {number}"))
    return tires


def pure_slip(tire: Tire, seed: int, *, sweeps: int = 0, inputs: bool = False) -> list[Recording]:
    """Return a cornering and a drive and brake test without combined slip, or three sweeps.

    The forces have random noise, and with `inputs` all channels. Offsets are not in the intervals of a fit.
    """
    loads = [220.0, 670.0, 1120.0]
    programs = (
        [alpha_sweeps(loads[:2], sample_rate=25.0), kappa_sweeps(loads[1:2], sample_rate=25.0)]
        if sweeps
        else [alpha_sweeps(loads, [0.0, radians(4)], sample_rate=25.0), kappa_sweeps(loads, sample_rate=25.0)]
    )
    noise = Noise().scaled(0.37)
    names = noise.channels if inputs else ("Fx", "Fy", "Mz")
    random = replace(noise, channels={n: replace(noise.channels[n], offset=0.0, drift=0.0) for n in names})
    return [VirtualBench(tire, random, seed=2 * seed + i).run(program) for i, program in enumerate(programs)]


def operating_points(random: np.random.Generator, *, combined: bool) -> pd.DataFrame:
    """Return random operating points."""
    n = 200
    alpha, kappa = random.uniform(-0.2, 0.2, n), random.uniform(-0.3, 0.3, n)
    if not combined:
        kappa = np.where(np.arange(n) % 2, 0.0, kappa)
        alpha = np.where(np.arange(n) % 2, alpha, 0.0)
    return pd.DataFrame({"alpha": alpha, "kappa": kappa, "Fz": random.uniform(220.0, 1120.0, n)})


def main() -> None:
    """Leave one tire out after another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tires", type=int, default=30)
    parser.add_argument("--fits", type=int, default=30, help="Tires that are left out.")
    parser.add_argument("--sweeps", type=int, default=0, help="3: fit three sweeps only.")
    parser.add_argument("--inputs", action="store_true", help="Noise of the inputs as on an FSAE TTC bench.")
    arguments = parser.parse_args()
    tires, random = made_tires(arguments.tires, 7), np.random.default_rng(1)
    inside: dict[str, list[float]] = {}
    errors: dict[str, list[float]] = {"family": [], "neutral": []}
    outside = 0
    for left_out, truth in enumerate(tires[: arguments.fits]):
        with tempfile.TemporaryDirectory() as folder:
            for number, tire in enumerate(tires):
                if number != left_out:
                    tire.save(Path(folder) / f"{number}.tir")
            nominal = {"Fz0": truth.values["FNOMIN"], "R0": truth.values["UNLOADED_RADIUS"]}
            recordings = pure_slip(truth, left_out, sweeps=arguments.sweeps, inputs=arguments.inputs)
            result = fit(recordings, "mf96", family=folder, nominal=nominal, rows="equal")
        outside += any(note.startswith("outside") for note in result.notes)
        for kind in ("pure", "combined"):
            table = operating_points(random, combined=kind == "combined")
            for channel in ("Fx", "Fy"):
                exact = truth.evaluate(table, signs="iso")[channel].to_numpy()
                band = result.interval(channel, table)
                hit = (band["lower"] <= exact) & (exact <= band["upper"])
                inside.setdefault(f"{kind} {channel}", []).append(float(hit.mean()))
                if kind == "combined":
                    neutral = without_combined(result.tire)
                    for name, tire in (("family", result.tire), ("neutral", neutral)):
                        error = tire.evaluate(table, signs="iso")[channel].to_numpy() - exact
                        errors[name].append(float(np.mean(error**2)))
    for name, shares in inside.items():
        print(f"{name}: {100 * np.mean(shares):.1f} % inside 95 % bands")
    family, neutral = (np.sqrt(np.mean(errors[name])) for name in ("family", "neutral"))
    print(f"combined slip: rms error {family:.0f} N, {neutral:.0f} N with neutral coefficients")
    print(f"{outside} of {left_out + 1} tires reported as outside", flush=True)


def without_combined(tire: Tire) -> Tire:
    """Return a tire whose combined slip has neutral coefficients."""
    declared = tire.symbolic_model.coefficients
    return replace(tire, values={**tire.values, **{n: declared[n].default for n in COMBINED if n in declared}})


if __name__ == "__main__":
    main()
