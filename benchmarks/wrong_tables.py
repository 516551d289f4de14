"""Wrong tables: how many are refused, how often the right option is named, and how many right tables are refused.

60 tables with one fault each, 20 kinds at 3 made tires, and 40 right tables in the three sign conventions, with and
without camber, with few loads, and with few channels. Each is written as a CSV file and read and tested as by the
commands. While the thresholds were chosen, only the first half of the kinds was run on these tires (`--part seen`); the
second half was run once, at the end. Some of its kinds are also in unit tests, on another table. With TIREFMU_DATA
the measured recordings are tested in each sign convention as well.

    python benchmarks/wrong_tables.py                    # all kinds
    python benchmarks/wrong_tables.py --part seen        # the kinds that were used while building
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.boundary.errors import TirefmuError
from tirefmu.measurements import Recording, check_columns, read_recording, recording_from
from tirefmu.measurements.units import POUND
from tirefmu.tires.signs import SIGNS, convert_signs

#: Change of a table in ISO, and texts of which the message has to contain one.
Change = Callable[[pd.DataFrame], pd.DataFrame]


@dataclass(frozen=True)
class Fault:
    """A kind of wrong table. `advice`: the options and headers of which a message names one."""

    change: Change
    advice: tuple[str, ...]


def scaled(header: str, factor: float) -> Change:
    """Return the change of a column's numbers and, if it has a unit in brackets, of its header."""
    name = header.partition(" [")[0]

    def change(table: pd.DataFrame) -> pd.DataFrame:
        return table.assign(**{name: factor * table[name]}).rename(columns={name: header})

    return change


def exchanged(first: str, second: str) -> Change:
    """Return the exchange of two columns."""
    return lambda table: table.rename(columns={first: second, second: first})


def mirrored(name: str) -> Change:
    """Return the reversal of a column."""
    return lambda table: table.assign(**{name: -table[name]})


#: The kinds that were used while thresholds were chosen.
SEEN: Mapping[str, Fault] = {
    "Fz in lbf": Fault(scaled("Fz", 1.0 / POUND), ("Fz=lbf",)),
    "Mz in N mm": Fault(scaled("Mz", 1e3), ("Mz=Nmm",)),
    "alpha mirrored": Fault(mirrored("alpha"), ("alpha=-alpha",)),
    "Fy mirrored": Fault(mirrored("Fy"), ("Fy=-Fy",)),
    "alpha and kappa exchanged": Fault(exchanged("alpha", "kappa"), ("alpha=kappa,kappa=alpha",)),
    "no Fy": Fault(lambda table: table.drop(columns="Fy"), ("Fy=NAME",)),
    "alpha in rad, header deg": Fault(scaled("alpha [deg]", 1.0), ("alpha=rad",)),
    "camber in rad, header deg": Fault(scaled("gamma [deg]", 1.0), ("gamma=rad",)),
    "pressure in psi, header kPa": Fault(scaled("p [kPa]", 1.0 / 6894.757), ("p=psi",)),
    "Fx is a copy of Fy": Fault(lambda table: table.assign(Fx=table["Fy"]), ("Fx=", "Fy=NAME")),
}
#: The kinds that were kept back.
KEPT_BACK: Mapping[str, Fault] = {
    "Fz in kgf": Fault(scaled("Fz", 1.0 / 9.80665), ("Fz=kgf",)),
    "Fx in lbf": Fault(scaled("Fx", 1.0 / POUND), ("Fx=lbf",)),
    "Fx and Fy in kN": Fault(lambda t: t.assign(Fx=1e-3 * t["Fx"], Fy=1e-3 * t["Fy"]), ("Fx=kN,Fy=kN",)),
    "camber mirrored": Fault(mirrored("gamma"), ("gamma=-gamma",)),
    "Mz mirrored": Fault(mirrored("Mz"), ("Mz=-Mz",)),
    "Fx and Fy exchanged": Fault(exchanged("Fx", "Fy"), ("Fx=Fy,Fy=Fx",)),
    "Mx and Mz exchanged": Fault(exchanged("Mx", "Mz"), ("Mx=Mz,Mz=Mx",)),
    "kappa a fraction, header %": Fault(scaled("kappa [%]", 1.0), ("kappa=1",)),
    "Mz is zero": Fault(lambda table: table.assign(Mz=0.0), ("Mz=NAME",)),
    "adapted SAE read as ISO": Fault(lambda t: convert_signs(t, "iso", "adapted-sae"), ("--signs adapted-sae",)),
}


@dataclass(frozen=True)
class MadeTire:
    """A tire of simple formulas, not those of the package. Loads in N; slopes per load."""

    loads: tuple[float, ...]
    friction: float
    stiffness: float
    radius: float
    pressure: float

    def table(self, seed: int = 0) -> pd.DataFrame:
        """Return sweeps of both slips at each load and camber, with noise, in ISO."""
        random = np.random.default_rng(seed)
        up_and_down = np.concatenate(
            [np.linspace(0.0, 1.0, 40), np.linspace(1.0, -1.0, 80), np.linspace(-1.0, 0.0, 40)]
        )
        parts = []
        for load in self.loads:
            for camber in np.radians([0.0, 2.0, 4.0]):
                parts.append(self._rows(0.2 * up_and_down, 0.0 * up_and_down, load, camber))
            parts.append(self._rows(0.0 * up_and_down, 0.2 * up_and_down, load, 0.0))
        table = pd.concat(parts, ignore_index=True)
        table.insert(0, "t", np.arange(len(table)) / 20.0 + 5.0 * (np.arange(len(table)) // len(up_and_down)))
        heavy = max(self.loads)
        for name, size in {"Fz": 4e-3, "Fx": 6e-3, "Fy": 6e-3, "Mz": 3e-4, "Mx": 3e-4}.items():
            table[name] += random.normal(0.0, size * heavy, len(table))
        for name, size in {"alpha": 2e-4, "kappa": 1e-3, "gamma": 1e-4}.items():
            table[name] += random.normal(0.0, size, len(table))
        return table

    def _rows(self, alpha: np.ndarray, kappa: np.ndarray, load: float, camber: float) -> pd.DataFrame:
        mean = float(np.mean(self.loads))
        grip = self.friction * load * (1.0 - 0.12 * (load / mean - 1.0))
        slope = self.stiffness * load * (1.0 - 0.2 * (load / mean - 1.0))
        slip = alpha + 0.003 + 0.08 * camber
        side = -grip * np.tanh(slope * slip / grip)
        half = 0.35 * self.radius * np.sqrt(load / mean)
        trail = 0.3 * half * np.exp(-((slope * slip / grip / 1.6) ** 2))
        along = grip * np.tanh(1.2 * slope * kappa / grip) * np.exp(-0.3 * np.abs(kappa))
        return pd.DataFrame(
            {
                "kappa": kappa, "alpha": alpha, "gamma": camber, "Fz": load, "p": self.pressure, "V": 11.0,
                "Fx": along - 0.01 * load, "Fy": side, "Mz": -trail * side + 0.001 * load * self.radius,
                "Mx": 0.12 * self.radius * side - 0.3 * self.radius * load * camber,
            }
        )  # fmt: skip


#: A racing tire, that of a car, that of a truck.
TIRES = {
    "racing": MadeTire((250.0, 600.0, 1100.0), 2.3, 34.0, 0.22, 85e3),
    "car": MadeTire((1800.0, 3600.0, 5400.0), 1.05, 17.0, 0.31, 220e3),
    "truck": MadeTire((9e3, 18e3, 30e3), 0.8, 7.5, 0.5, 750e3),
}


def right_tables() -> Iterator[tuple[str, pd.DataFrame, str]]:
    """Yield name, table and signs of 40 right tables."""
    parts: dict[str, Change] = {
        "whole": lambda table: table,
        "no camber": lambda table: table[table["gamma"].abs() < 0.01],
        "side force only": lambda table: table.loc[table["kappa"].abs() < 0.005, ["t", "alpha", "gamma", "Fz", "Fy"]],
        "one load": lambda table: table[(table["Fz"] / table["Fz"].min() < 1.5)],
    }
    for number, (name, tire) in enumerate(TIRES.items()):
        for part, change in parts.items():
            for signs in SIGNS:
                table = change(tire.table(seed=10 + number)).reset_index(drop=True)
                yield f"{name}, {part}, {signs}", convert_signs(table, "iso", signs), signs
    for seed, part in enumerate(parts):
        yield f"another tire, {part}", parts[part](MadeTire((400.0, 900.0), 1.6, 22.0, 0.25, 1e5).table(seed)), "iso"


def refusal(table: pd.DataFrame, signs: str = "iso") -> str:
    """Return the message with which a table is refused; empty if it is accepted."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        table.to_csv(path, index=False)
        try:
            check_columns(recording_from(path, signs=signs))
        except TirefmuError as error:
            return str(error).replace(str(path), "table.csv")
    return ""


def main() -> int:
    """Print the results; return 1 if a wrong table is accepted or a right one is refused."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=["seen", "kept-back", "all"], default="all")
    parser.add_argument("--messages", action="store_true", help="print every message")
    options = parser.parse_args()
    faults = {**(SEEN if options.part != "kept-back" else {}), **(KEPT_BACK if options.part != "seen" else {})}
    refused = named = total = 0
    for kind, fault in faults.items():
        for number, (name, tire) in enumerate(TIRES.items()):
            message = refusal(fault.change(tire.table(seed=number)))
            right = any(text in message for text in fault.advice)
            total, refused, named = total + 1, refused + bool(message), named + right
            if options.messages or not right:
                print(f"{kind}, {name}: {message or 'ACCEPTED'}")
    wrongly = 0
    right_ones = list(right_tables())
    for name, table, signs in right_ones:
        if message := refusal(table, signs):
            wrongly += 1
            print(f"right table, {name}: {message}")
    measured = _measured()
    print(f"wrong tables refused: {refused} of {total}; right option named: {named} of {total}")
    print(f"right tables refused: {wrongly} of {len(right_ones)}; measured recordings refused: {measured}")
    return int(refused < total or wrongly > 0)


def _measured() -> str:
    """Return how many of the measured recordings are refused, in each sign convention, as a text."""
    folder = os.environ.get("TIREFMU_DATA")
    if not folder:
        return "TIREFMU_DATA is not set"
    refused = count = 0
    for path in sorted(Path(folder).glob("*.mat")):
        recording = read_recording(path)
        for signs in SIGNS:
            turned = recording.with_signs(signs)
            count += 1
            try:
                check_columns(Recording(turned.table, signs, path.name, turned.about))
            except TirefmuError as error:
                refused += 1
                print(error)
    return f"{refused} of {count}"


if __name__ == "__main__":
    sys.exit(main())
