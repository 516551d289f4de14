"""The kinds of fuzzed files: valid examples, mutations and readers."""

from __future__ import annotations

import io
import math
import re
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from tirefmu.applications.batch import read_jobs, read_study
from tirefmu.applications.project import read_project, steps_of
from tirefmu.commands.diagnose_command import user_effect
from tirefmu.fitting import RECIPES, load_recipe
from tirefmu.fmu.comparison.resources import axes_of_inputs, embedded_tire
from tirefmu.fmu.packaging.export import contents
from tirefmu.fmu.simulation.archive import unpacked
from tirefmu.fmu.simulation.simulate import read_description
from tirefmu.measurements import INPUTS, check_plausible, read_recording
from tirefmu.symbolic.added import effect_text, library, read_effect
from tirefmu.tires import published, read_tir, write_tir
from tirefmu.tires.property_file.units import unit_factor
from tirefmu.tires.property_file.writing import tir_text

from ..hostile import HOSTILE
from .mutations import BINARY, compressed, mutated, rezipped

ROOT = Path(__file__).parents[2]
GOLDEN = Path(__file__).parents[1] / "golden"


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    `seeds` makes whole files, `change` the mutated file of a number, and `read` reads one: it returns, or raises a
    TirefmuError; any other exception is a fault, and so is an invalid result.
    """

    suffix: str
    seeds: Callable[[], list[bytes]]
    read: Callable[[Path], object]
    change: Callable[[int, list[bytes]], bytes] = mutated


# ------------------------------------------------------------------ tires


def tir_seeds() -> list[bytes]:
    files = [(GOLDEN / f"MagicFormula{n}_Parameters.tir").read_bytes() for n in (52, 61, 62)]
    return [*files, tir_text(published("trento_hoosier")).encode()]


def declared(text: str) -> tuple[str, str] | None:
    """Return the unit of length and the radius by a plain search of the file; None unless each occurs once."""
    text = re.sub(r"[$!].*", "", text)
    units = re.findall(r"(?im)^\s*LENGTH\s*=\s*'?([\w ]*)'?\s*$", text)
    radii = re.findall(r"(?im)^\s*UNLOADED_RADIUS\s*=\s*(\S+)\s*$", text)
    return (units[0], radii[0]) if len(units) == 1 == len(radii) else None


def read_tire(path: Path) -> None:
    """Read a tire; its values are finite, in the declared unit, and survive a round trip."""
    data = path.read_bytes()
    tire = read_tir(path)
    assert all(math.isfinite(value) for value in tire.values.values())
    look = declared(data.decode("latin-1")) if b"\x00" not in data and b"\x85" not in data else None
    if look:  # no unit is overlooked
        expected = float(look[1].strip("'\"").lower().replace("d", "e")) * (unit_factor("LENGTH", look[0]) or math.nan)
        assert tire.values["UNLOADED_RADIUS"] == pytest.approx(expected, rel=1e-12)
    write_tir(tire, path)
    again = read_tir(path)
    assert again == tire
    assert [v.hex() for v in again.values.values()] == [v.hex() for v in tire.values.values()]


# ------------------------------------------------------------------ recordings


def bench(rows: int = 12) -> dict[str, Any]:
    """Return the channels of a bench file, as columns."""
    values = {"V": 36.0, "SA": 2.0, "IA": 4.0, "P": 80.0, "FX": 10.0, "FY": -300.0, "FZ": -900.0, "MZ": 7.0, "SL": 0.05}
    columns = {name: np.full((rows, 1), value) for name, value in values.items()}
    return {"ET": 0.01 * np.arange(rows)[:, None], **columns}


UNITS = {"ET": "sec", "V": "kph", "SA": "deg", "IA": "deg", "P": "kPa", "FX": "N", "FY": "N", "FZ": "N", "MZ": "N-m"}


def table() -> pd.DataFrame:
    t = np.arange(12) / 10
    return pd.DataFrame({"t": t, "kappa": t / 10 - 0.05, "alpha": 0.2 - t / 5, "Fz": 900 + t, "p": 8e4, "Fy": 50 - t})


def csv_seeds() -> list[bytes]:
    headers = {"alpha": "alpha [deg]", "Fz": "Fz [kN]", "p": "p [psi]"}
    scaled = table().assign(alpha=np.degrees(table()["alpha"]), Fz=table()["Fz"] / 1e3, p=12.0).rename(columns=headers)
    return [
        table().to_csv(index=False).encode(),
        scaled.to_csv(index=False, sep=";").encode(),
        b"# a table\n" + table().assign(**{HOSTILE[5]: HOSTILE[2]}).to_csv(index=False).encode(),
    ]


def matlab(**options: Any) -> bytes:
    text = {} if options.get("format") == "4" else {"tireid": HOSTILE[5], "channel": channel_struct()}
    file = io.BytesIO()
    savemat(file, {**bench(), **text}, **options)
    return file.getvalue()


def channel_struct() -> dict[str, Any]:
    return {"name": np.array(list(UNITS), dtype=object), "units": np.array(list(UNITS.values()), dtype=object)}


def newer_matlab() -> list[bytes]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # importing it warns of an option of pandas
        matio = pytest.importorskip("matio", reason="the extra matlab writes files of MATLAB 7.3")
    path = Path("seed.mat")
    files = []
    for content in ({**bench(), "channel": channel_struct()}, {"data": table()}):
        matio.save_to_mat(str(path), content, version="v7.3")
        files.append(path.read_bytes())
        path.unlink()
    return files


def dat_seeds() -> list[bytes]:
    columns = bench()
    rows = "\n".join("\t".join(f"{columns[name][i, 0]:g}" for name in columns) for i in range(12))
    names, units = "\t".join(columns), "\t".join([*UNITS.values(), "none"])
    return [f"Tire_Name=Somebody's\tISO False\n{names}\n{units}\n{rows}\n".encode()]


TYDEX = b"""**HEADER
RELEASE   1.3
MEASID    run 3
**CONSTANTS
INFLPRES  inflation pressure   bar  2.5
**MEASURCHANNELS
LONGSLIP  longitudinal slip    %    0.1  0  0
SLIPANGL  slip angle           deg  1    0  0
FZW       vertical force       kN   1    0  0
FYW       side force           N    1    0  0
**MEASURDATA
0 1.5 3.01 -1100
1 2.5 3.02 -1800
**END
"""


def parquet_seeds() -> list[bytes]:
    pytest.importorskip("pyarrow", reason="the extra parquet writes Parquet")
    wide = table().assign(**{HOSTILE[5]: HOSTILE[0], "whole": np.arange(12), "truth": True})
    return [frame.to_parquet(index=False) for frame in (table(), wide)]


def read_table(path: Path) -> None:
    """Read a recording; every input is finite."""
    recording = read_recording(path)
    inputs = [name for name in INPUTS if name in recording.table]
    assert np.isfinite(recording.table[inputs].to_numpy(dtype=float)).all()
    check_plausible(recording)


# ------------------------------------------------------------------ files that control a fit and a diagnosis


PROJECT = """[data]
tables = ["a.csv", "b c.mat"]
signs = "sae"
where = "t > 120 and p in 70..90 kPa"
[fit]
model = "mf61"
nominal = {Fz0 = 1000.0, R0 = 0.25}
effects = ["load_friction"]
cross_validate = 5
[check]
tolerance = 0.05
[diagnose]
run = true
[output]
folder = "results"
"""
JOBS = """[defaults]
model = "mf61"
nominal = {Fz0 = 1000.0}
[[jobs]]
name = "front"
tables = ["a.csv", "b.mat"]
iterations = 30
[[jobs]]
name = "rear"
tables = ["c.csv"]
where = "t > 5"
"""
STUDY = """tables = ["a.csv"]
outputs = ["Fy"]
series = true
[parameters]
LMUY = {from = 0.5, to = 1.0, count = 3}
LKY = [0.9, 1.1]
"""


def read_steps(path: Path) -> None:
    """Read a project; its steps have texts for arguments."""
    assert all(isinstance(text, str) for step in steps_of(read_project(path)) for text in step.arguments)


def recipe_seeds() -> list[bytes]:
    return [(ROOT / "fitting" / "recipes" / f"{name}.toml").read_bytes() for name in RECIPES]


def effect_seeds() -> list[bytes]:
    examples = [path.read_bytes() for path in sorted((ROOT / "docs" / "effects").glob("*.toml"))]
    return [*examples, *(effect_text(effect).encode() for effect in library().values())]


def read_user_effect(path: Path) -> None:
    """Read an effect; it survives a round trip."""
    effect = user_effect(path)
    assert read_effect(effect_text(effect), "again.toml") == effect


# ------------------------------------------------------------------ FMUs


def fmu_seeds() -> list[bytes]:
    """Return FMUs without binaries."""
    files = []
    for fmi in (2, 3):
        content = io.BytesIO()
        parts = contents(published("trento_hoosier"), fmi, "tire")
        with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in ("modelDescription.xml", "resources/interface.json", "resources/tire.tir"):
                archive.writestr(zipfile.ZipInfo(name), parts[name], zipfile.ZIP_DEFLATED)
        files.append(content.getvalue())
    return files


def read_fmu(path: Path) -> None:
    """Read the parts of an FMU that a check reads before it loads the binary."""
    with unpacked(path) as folder:
        description = read_description(path, folder)
        outputs = [v.name for v in description.modelVariables if v.causality == "output" and v.name == "Fy"]
        assert axes_of_inputs(folder, path) in ("iso", "sae")
        embedded_tire(folder, path, outputs)


KINDS = {
    "tir": Kind(".tir", tir_seeds, read_tire),
    "csv": Kind(".csv", csv_seeds, read_table),
    "mat 4": Kind(".mat", lambda: [matlab(format="4")], read_table, lambda n, files: mutated(n, files, BINARY)),
    "mat 5": Kind(".mat", lambda: [matlab()], read_table, lambda n, files: mutated(n, files, BINARY)),
    "mat 7": Kind(".mat", lambda: [matlab()], read_table, compressed),
    "mat 7.3": Kind(".mat", newer_matlab, read_table, lambda n, files: mutated(n, files, BINARY)),
    "dat": Kind(".dat", dat_seeds, read_table),
    "parquet": Kind(".parquet", parquet_seeds, read_table, lambda n, files: mutated(n, files, BINARY)),
    "tydex": Kind(".tdx", lambda: [TYDEX], read_table),
    "recipe": Kind(".toml", recipe_seeds, lambda path: load_recipe(str(path), "mf96")),
    "effect": Kind(".toml", effect_seeds, read_user_effect),
    "project": Kind(".toml", lambda: [PROJECT.encode()], read_steps),
    "jobs": Kind(".toml", lambda: [JOBS.encode()], read_jobs),
    "study": Kind(".toml", lambda: [STUDY.encode()], read_study),
    "fmu": Kind(".fmu", fmu_seeds, read_fmu, rezipped),
}
