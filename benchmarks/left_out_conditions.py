"""Intervals of stiffness and friction on measured recordings in conditions that the fit has not seen.

One load or pressure after the other is left out. The tire is read at the left-out rows as they are: slope at zero slip
and peak friction in each condition (load, camber, pressure). Prints by left-out level: the share of readings within the
95 % interval, and within the interval and two standard errors of the reading; mean error and mean half interval.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

import tirefmu
from tirefmu.fitting.checks.characteristics import characteristics
from tirefmu.fitting.checks.slip_stiffness import Compared, slip_stiffnesses
from tirefmu.fitting.results.fitted import Fitted
from tirefmu.fitting.results.intervals import band
from tirefmu.measurements import Recording, levels, recordings_from

#: Quantities, and the force and kind of reading of each.
QUANTITIES = {
    "K_xkappa": ("Fx", ""), "K_yalpha": ("Fy", ""),
    "mu_x": ("Fx", "peak friction"), "mu_y": ("Fy", "peak friction"),
}  # fmt: skip
#: Nominal values, so that every fit has the same.
NOMINAL = {"Fz0": 1650.0, "R0": 0.2032, "p0": 83e3}


@dataclass(frozen=True)
class LeftOut:
    """A level of an input, with the ends between it and its neighbors, and whether it is the lowest or highest."""

    name: str
    level: float
    low: float
    high: float
    outermost: bool

    def rows(self, table: pd.DataFrame) -> pd.Series:
        """Return which rows are at the level."""
        return table[self.name].abs().between(self.low, self.high)


def left_out(recordings: list[Recording]) -> Iterator[LeftOut]:
    """Yield each level of load and pressure."""
    rows = pd.concat([recording.table for recording in recordings])
    for name in ("Fz", "p"):
        held = sorted(levels(rows[name].abs()))
        ends = [0.0, *(0.5 * (a + b) for a, b in pairwise(held)), np.inf]
        for number, level in enumerate(held):
            yield LeftOut(name, level, ends[number], ends[number + 1], number in (0, len(held) - 1))


def readings(whole: Fitted, tire: tirefmu.Tire) -> list[tuple[str, Compared]]:
    """Return each quantity that all rows show, and that of a tire at the same rows."""
    assert whole.residuals is not None
    at_all_rows = replace(whole.residuals, tire=tire.in_signs("adapted-sae"))
    read = [(s.channel, "", s) for s in slip_stiffnesses(at_all_rows)]
    read += [(c.channel, c.quantity, c) for c in characteristics(at_all_rows) if c.shown]
    names = {key: quantity for quantity, key in QUANTITIES.items()}
    known = [(names[channel, kind], one) for channel, kind, one in read if (channel, kind) in names]
    return [(quantity, one) for quantity, one in known if np.isfinite(one.error)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="+", type=Path)
    recordings = [
        replace(r, table=r.table.drop(columns=[name for name in ("Mz", "Mx", "My") if name in r.table]))
        for r in recordings_from(parser.parse_args().tables)
    ]
    whole = tirefmu.fit(recordings, "mf61", nominal=NOMINAL)
    records = []
    for out in left_out(recordings):
        rest = [replace(r, table=r.table[~out.rows(r.table)]) for r in recordings]
        result = tirefmu.fit([r for r in rest if len(r.table)], "mf61", nominal=NOMINAL)
        for quantity, one in readings(whole, result.tire):
            at = pd.DataFrame([{**one.at, "Fz": one.load}])
            if out.rows(at).all():
                (found,) = band(result, quantity, at, "iso").to_dict("records")
                half = 1.96 * found["error"] / abs(found["value"])
                noise = 1.96 * one.error / one.read
                records.append({
                    "left out": f"{out.name} {out.level:.0f}", "beyond": out.outermost, "quantity": quantity,
                    "readings": 1, "inside": abs(one.off) <= half, "with noise": abs(one.off) <= np.hypot(half, noise),
                    "error": abs(one.off), "half": half,
                })  # fmt: skip
    table = pd.DataFrame(records)
    for keys in (["left out", "quantity"], ["beyond", "quantity"], ["beyond"]):
        groups = table.groupby(keys, sort=False)
        shown = groups[["inside", "with noise", "error", "half"]].mean().assign(readings=groups["readings"].sum())
        print(shown.assign(ratio=shown["half"] / shown["error"]).round(3).to_string(), "\n")


if __name__ == "__main__":
    main()
