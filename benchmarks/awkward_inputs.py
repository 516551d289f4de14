"""What tirefmu reports about awkward inputs and uses (`awkward_uses`): the tables of docs/awkward_inputs.md.

Each input is a made recording with one fault. `tirefmu inspect` reads it. The column "fit" shows whether a fit
starts; it is stopped at its first iteration.

    python benchmarks/awkward_inputs.py                  # prints the table
    python benchmarks/awkward_inputs.py --write          # writes docs/awkward_inputs.md
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from awkward_uses import uses

from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.fitting import fit as fit_tire
from tirefmu.measurements import check_columns, recordings_from

DOCUMENT = Path(__file__).parents[1] / "docs" / "awkward_inputs.md"
#: A table, or the text of a file.
Content = pd.DataFrame | str
ROWS = 300


def recording(friction: float = 1.6, load: float = 1.0, seed: int = 0, rows: int = ROWS) -> pd.DataFrame:
    """Return sweeps of both slips at two loads, at 100 Hz, in iso, with noise."""
    ramp = np.tile(np.interp(np.arange(rows) / rows, [0.0, 0.25, 0.75, 1.0], [0.0, 0.2, -0.2, 0.0]), 4)
    part, random = np.repeat(np.arange(4), rows), np.random.default_rng(seed)
    lateral = part < 2
    alpha, kappa = np.where(lateral, ramp, 0.0), np.where(lateral, 0.0, ramp)
    heavy = load * np.where(part % 2, 900.0, 500.0)
    count = 4 * rows
    side = -friction * heavy * np.sin(1.4 * np.arctan(10.0 * alpha))
    gamma = np.random.default_rng(seed + 1).normal(0.0, 1e-4, count)  # no sensor records exactly 0
    table = {
        "t": np.arange(count) / 100.0 + 5.0 * part, "kappa": kappa, "alpha": alpha, "gamma": gamma,
        "Fz": heavy + load * random.normal(0.0, 4.0, count), "p": 83e3 + random.normal(0.0, 100.0, count),
        "V": 11.0 + random.normal(0.0, 0.01, count), "T": 60.0 + random.normal(0.0, 0.1, count),
        "Fx": friction * heavy * np.sin(1.5 * np.arctan(12.0 * kappa)) + load * random.normal(0.0, 5.0, count),
        "Fy": side + load * random.normal(0.0, 5.0, count),
        "Mz": -0.03 * side * np.cos(1.1 * np.arctan(9.0 * alpha)) + load * random.normal(0.0, 0.3, count),
    }  # fmt: skip
    return pd.DataFrame(table).round(6)


def with_values(channel: str, rows: Callable[[pd.Index], np.ndarray], value: float) -> pd.DataFrame:
    """Return the recording with another value of a channel in some rows."""
    table = recording()
    return table.assign(**{channel: table[channel].mask(rows(table.index), value)})


def joined(*tables: pd.DataFrame, pause: float | None = None) -> pd.DataFrame:
    """Return tables one after another; the clock restarts, or continues after a pause in s."""
    if pause is not None:
        starts = np.cumsum([0.0, *(table["t"].iloc[-1] + pause for table in tables[:-1])])
        tables = tuple(table.assign(t=table["t"] + start) for table, start in zip(tables, starts, strict=True))
    return pd.concat(tables, ignore_index=True)


def half(table: pd.DataFrame) -> np.ndarray:
    """Return whether each row is in the second half."""
    return np.asarray(table.index >= len(table) // 2)


def cases() -> dict[str, list[Content]]:
    """Return the files of each awkward input by its description."""
    good = recording()
    cold = joined(*(recording(seed=seed) for seed in range(4)), pause=5.0)
    pressures = [recording(seed=seed).assign(p=value) for seed, value in enumerate((83e3, 70e3, 97e3))]
    header, first, *rest = good.to_csv(index=False).splitlines()
    return {
        "no slip angle": [good.drop(columns="alpha")],
        "no longitudinal slip": [good.drop(columns="kappa")],
        "no load": [good.drop(columns="Fz")],
        "no output": [good.drop(columns=["Fx", "Fy", "Mz"])],
        "slip angle named SlipAngle": [good.rename(columns={"alpha": "SlipAngle"})],
        "misspelt channel": [good.rename(columns={"gamma": "gama"})],
        "load named load": [good.rename(columns={"Fz": "load"})],
        "side force named LateralForce": [good.rename(columns={"Fy": "LateralForce"})],
        "unit in the name": [good.rename(columns={"alpha": "alpha_deg"})],
        "column twice": ["\n".join([header + ",Fy", *(f"{row},1" for row in (first, *rest))])],
        "unknown columns": [good.assign(lap=1, remark="x")],
        "angles in degrees": [good.assign(alpha=np.degrees(good["alpha"]))],
        "slip in percent": [good.assign(kappa=100.0 * good["kappa"])],
        "load in kN": [good.assign(Fz=good["Fz"] / 1e3)],
        "pressure in kPa": [good.assign(p=good["p"] / 1e3)],
        "pressure in psi": [good.assign(p=good["p"] / 6894.76)],
        "speed in km/h, not declared": [good.assign(V=3.6 * good["V"])],
        "temperature in K": [good.assign(T=good["T"] + 273.15)],
        "mixed units: angles of the second half in degrees": [
            joined(good, good.assign(alpha=np.degrees(good["alpha"])), pause=5.0)
        ],
        "mixed units: pressure of the second half in kPa": [good.assign(p=np.where(half(good), 1e-3, 1.0) * good["p"])],
        "mixed units: speed of the second half in km/h": [good.assign(V=np.where(half(good), 3.6, 1.0) * good["V"])],
        "declared unit of another quantity": [good.rename(columns={"alpha": "alpha [kPa]"})],
        "adapted SAE read as ISO": [good.assign(Fy=-good["Fy"], Mz=-good["Mz"])],
        "SAE read as ISO": [good.assign(Fz=-good["Fz"], alpha=-good["alpha"], Fy=-good["Fy"], Mz=-good["Mz"])],
        "Fx and Fy swapped": [good.rename(columns={"Fx": "Fy", "Fy": "Fx"})],
        "longitudinal slip of the other sign": [good.assign(kappa=-good["kappa"])],
        "two tires in one file": [joined(recording(), recording(1.0, seed=1), pause=20.0)],
        "two tires in two files": [good, recording(1.0, seed=1)],
        "two sizes of tires in two files": [good, recording(load=9.0, seed=1)],
        "file given twice": [good, good],
        "rows repeated": [joined(good, good.iloc[:ROWS], pause=20.0)],
        "spikes: 1 % of Fy": [with_values("Fy", lambda rows: rows % 100 == 50, 9e3)],
        "spikes: 1 % of alpha": [with_values("alpha", lambda rows: rows % 100 == 50, 1.2)],
        "decimal commas, semicolons": [good.to_csv(index=False, sep=";", decimal=",")],
        "decimal commas, commas": ["\n".join([header, *(row.replace(".", ",") for row in (first, *rest))])],
        "time backwards": [good.iloc[::-1]],
        "time jumps back": [good.assign(t=good["t"] - 15.0 * half(good))],
        "time jumps forward within a sweep": [good.assign(t=good["t"] + 20.0 * (good.index > ROWS // 3))],
        "constant time": [good.assign(t=0.0)],
        "constant slips": [good.assign(alpha=0.05, kappa=0.0)],
        "one load": [good[good["Fz"] > 700.0]],
        "NaN in 10 % of alpha": [with_values("alpha", lambda rows: rows % 10 == 3, np.nan)],
        "NaN in 40 % of alpha": [with_values("alpha", lambda rows: rows % 10 < 4, np.nan)],
        "dead sensor: Mz constant": [good.assign(Mz=0.0)],
        "cold tire": [cold.assign(T=60.0 - 12.0 * np.exp(-cold["t"] / 8.0))],
        "pressures one after another": [joined(*pressures, pause=20.0)],
    }  # fmt: skip


class _StartedError(Exception):
    """A fit is at its first iteration."""


def _stop_fit(*_: object) -> None:
    raise _StartedError


@dataclass(frozen=True)
class Outcome:
    """What tirefmu makes of an input.

    `inspect`, `fit`: exit code of ``tirefmu inspect``; 2 if the data of a fit are refused, 0 if the fit would start.
    `messages`: the errors, or the findings.
    """

    inspect: int
    fit: int
    messages: tuple[str, ...]


def outcome(contents: list[Content], folder: Path, *, fit: bool = True) -> Outcome:
    """Return the outcome of an input.

    `contents`: written as a.csv, b.csv. `folder`: empty. `fit`: whether to start a fit, too; it takes most of the time.
    """
    paths = [folder / f"{name}.csv" for name, _ in zip("ab", contents, strict=False)]
    for path, content in zip(paths, contents, strict=True):
        path.write_text(content if isinstance(content, str) else content.to_csv(index=False), encoding="utf-8")
    errors, report = io.StringIO(), folder / "found.json"
    with contextlib.redirect_stderr(errors):
        status = main(["inspect", *map(str, paths), "--json", str(report), "--quiet"])
    messages = [errors.getvalue().replace("tirefmu: error: ", "").strip()]
    if status != 2:
        found = json.loads(report.read_text(encoding="utf-8"))
        messages = [finding["text"] for finding in found["findings"]]
        for described in found["recordings"]:
            counts = ", ".join(f"{count} rows ({reason})" for reason, count in described["excluded_rows"].items())
            messages += [f"{described['source']}: excluded from a fit: {counts}"] if counts else []
    refused = status if status == 2 else 0
    if fit and not refused:
        try:
            recordings = recordings_from(paths)
            for table in recordings:
                check_columns(table)
            fit_tire(recordings, "mf61", progress=_stop_fit)
        except _StartedError:
            pass
        except TirefmuError as error:
            refused, messages = 2, list(dict.fromkeys([*messages, str(error)]))
    return Outcome(status, refused, tuple(message.replace(f"{folder}/", "") for message in messages))


def table() -> str:
    """Return the document."""
    lines = []
    for number, (name, contents) in enumerate(cases().items(), start=1):
        with tempfile.TemporaryDirectory() as folder:
            result = outcome(contents, Path(folder))
        lines.append(f"| {number} | {name} | {result.inspect} | {result.fit} | {cell(result.messages)} |")
    answers = [f"| {name} | {cell(answer(use))} |" for name, use in uses().items()]
    document = [
        INTRODUCTION.format(count=len(lines)) + "\n".join(lines),
        USES.format(count=len(answers)) + "\n".join(answers),
    ]
    return "\n\n".join(document) + "\n"


def cell(messages: Sequence[str]) -> str:
    """Return messages as a cell of a table."""
    return "<br>".join(message.replace("|", "\\|") for message in messages) or "-"


def answer(use: Callable[[Path], str]) -> list[str]:
    """Return the lines of the answer to an awkward use."""
    with tempfile.TemporaryDirectory() as folder:
        return use(Path(folder)).splitlines()


INTRODUCTION = """# Awkward inputs

`make awkward` makes {count} recordings with one fault each, in ISO signs, and writes this table. Column "inspect": exit
code of `tirefmu inspect` (0; 1: a serious finding; 2: refused). Column "fit": 2 if `tirefmu fit` refuses the data, 0 if
it starts; it prints the same findings.

| | input | inspect | fit | message |
|---|---|---|---|---|
"""

USES = """## Awkward uses

{count} uses of arrays, property files, fits, logs and printed code. "exit" is the exit code of a command; only its
lines about the use are shown.

| use | answer |
|---|---|
"""


if __name__ == "__main__":
    document = table()
    if "--write" in sys.argv[1:]:
        DOCUMENT.write_text(document, encoding="utf-8")
    else:
        print(document, end="")
