"""Invalid input: a one-line error, exit code 2, no output files."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest


@pytest.fixture(scope="module")
def files(tmp_path_factory, bench_csv, published_tir, published_fmu):
    """Return a folder with one file of each kind, and unusual ones."""
    folder = tmp_path_factory.mktemp("files")
    shutil.copy(bench_csv, folder / "good.csv")
    shutil.copy(published_tir, folder / "good.tir")
    shutil.copy(published_fmu, folder / "good.fmu")
    table = pd.read_csv(bench_csv)
    odd = {
        "nan.csv": table.assign(alpha=table["alpha"].where(table.index < 7)),
        "degrees.csv": table.assign(alpha=np.degrees(table["alpha"])),
        "negative.csv": table.assign(Fz=-table["Fz"]),
    }
    for name, content in odd.items():
        content.to_csv(folder / name, index=False)
    (folder / "empty.csv").write_text("", encoding="utf-8")
    (folder / "rows.csv").write_text("alpha,Fz,Fy\n", encoding="utf-8")
    (folder / "text.csv").write_text("alpha,Fz,Fy\n0.1,high,-800\n", encoding="utf-8")
    (folder / "notes.txt").write_text("nothing\n", encoding="utf-8")
    lines = (folder / "good.tir").read_text(encoding="utf-8").splitlines()
    (position,) = (i for i, line in enumerate(lines) if line.startswith("PDY1 "))
    for name, line in (("broken.tir", "PDY1 2.7"), ("word.tir", "PDY1 = much")):
        (folder / name).write_text("\n".join([*lines[:position], line, *lines[position + 1 :]]), encoding="utf-8")
    (folder / "cross.toml").write_text(
        '[[stage]]\nname = "one"\n[stage.free]\nPDY1 = { lower = 3, upper = 2 }\n', encoding="utf-8"
    )
    (folder / "broken.toml").write_text("[[stage]\n", encoding="utf-8")
    (folder / "taken").mkdir()
    return folder


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """Return a working folder with a copy of the files."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(files, tmp_path, dirs_exist_ok=True))


FIT = ("-o", "new.tir", "--report", "new.html", "--figures", "new", "--json", "new.json")
#: Unknown names are in `test_unknown_names.py`, wrong recordings in `test_awkward_inputs.py`.
BAD = {
    "fit missing.csv {fit}": "missing.csv: no such file",
    "fit notes.txt {fit}": "notes.txt: unknown kind of recording '.txt'",
    "fit empty.csv {fit}": "empty.csv: the file is empty",
    "fit rows.csv {fit}": "rows.csv: no rows",
    "fit text.csv {fit}": "text.csv: line 2:",
    "fit nan.csv {fit}": "nan.csv: line 9: alpha",
    "fit negative.csv {fit}": "negative.csv: Fz is negative in 100 % of the rows: SAE signs? (--signs sae)",
    "fit good.csv --signs sae {fit}": "good.csv: Fz is positive in 100 % of the rows: not SAE?",
    "fit good.csv good.csv missing.mat {fit}": "missing.mat: no such file",
    "fit good.csv --iterations 0 {fit}": "0 is not in the range x>=1",
    "fit good.csv --recipe missing.toml {fit}": "missing.toml: cannot be read",
    "fit good.csv --recipe broken.toml {fit}": "broken.toml: ",
    "fit good.csv --recipe cross.toml {fit}":
        "cross.toml, stage 'one', PDY1: bounds cross: lower 3 is above upper 2",
    "fit good.csv --start missing.tir {fit}": "missing.tir: cannot be read",
    "fit good.csv --start broken.tir {fit}": "broken.tir:",
    "fit good.csv --nominal Fz0 {fit}": "'Fz0' is not like Fz0=1000",
    "fit good.csv --nominal Fz0=-220 {fit}": "nominal Fz0 = -220 is not positive",
    "fit good.csv --nominal Fz0=0.22 {fit}": "nominal Fz0 = 0.22 N is far from the median of Fz",
    "fit good.csv --colour red {fit}": "No such option",
    "fit {fit}": "Missing argument 'TABLES...'",
    "fit good.csv": "Missing option '-o'",
    "fit good.csv -o no/new.tir": "no/new.tir: no folder no",
    "fit good.csv -o taken": "taken: is a folder, not a file",
    "fit good.csv -o new.tir --json no/new.json": "no/new.json: no folder no",
    "fit good.csv -o new.tir --report no/new.html": "no/new.html: no folder no",
    "fit good.csv -o new.tir --figures good.csv": "good.csv: is a file, not a folder",
    "evaluate missing.tir good.csv -o new.csv": "missing.tir: no such file",
    "evaluate broken.tir good.csv -o new.csv": "'PDY1 2.7' in [LATERAL_COEFFICIENTS] is not 'KEY = value'",
    "evaluate word.tir good.csv -o new.csv": "PDY1 = 'much' is not a number",
    "evaluate good.csv good.csv -o new.csv": "not a .tir file",
    "evaluate good.tir missing.csv -o new.csv": "missing.csv: no such file",
    "evaluate good.tir nan.csv -o new.csv": "nan.csv: line 9: alpha",
    "evaluate good.tir negative.csv -o new.csv": "negative.csv: Fz is negative in 100 % of the rows",
    "evaluate good.tir good.csv -o new.txt": "new.txt: unknown kind of table '.txt'",
    "evaluate good.tir good.csv -o no/new.csv": "no/new.csv: no folder no",
    "evaluate good.tir good.csv -o new.csv --json no/new.json": "no/new.json: no folder no",
    "evaluate good.tir good.csv -o new.csv --code fortran": "'fortran' is not one of 'auto', 'numpy'",
    "export missing.tir -o new.fmu": "missing.tir: no such file",
    "export good.tir -o no/new.fmu": "no/new.fmu: no folder no",
    "export good.tir -o new.fmu --json no/new.json": "no/new.json: no folder no",
    "export good.tir -o new.fmu --fmi 4": "'4' is not one of '2', '3'",
    "check missing.fmu good.csv --json new.json": "missing.fmu: no such file",
    "check good.csv good.csv --json new.json": "good.csv: not a readable FMU",
    "check good.fmu missing.csv --json new.json": "missing.csv: no such file",
    "check good.fmu degrees.csv --json new.json": "degrees.csv: alpha reaches",
    "check good.fmu good.csv --json no/new.json": "no/new.json: no folder no",
    "check good.fmu good.csv --tolerance -1": "Invalid value for '--tolerance'",
    "info missing.tir": "missing.tir: no such file",
    "info broken.tir": "broken.tir:",
    "info taken": "taken: cannot be read",
    "demo -o good.csv": "good.csv: is a file, not a folder",
    "generate --check --json no/new.json": "no/new.json: no folder no",
    "fit good.csv --cross-validate 500 {fit}": "500 folds require at least 500 operating conditions",
    "fit good.csv --where pressure>3kPa {fit}": "where 'pressure>3kPa': unknown name 'pressure': did you mean p?",
    "fit good.csv --bootstrap 5 {fit}": "5 bootstrap replicates: at least 40 are required",
    "fit good.csv --bootstrap 50 --where t<30 {fit}": "sweeps in the recordings, at least 10 are required",
    "fit good.csv --workers 2 --scheduler tcp://127.0.0.1:1 {fit}": "--workers is for this machine",
    "evaluate good.tir good.csv --where pressure>3kPa -o new.csv": "unknown name 'pressure': did you mean p?",
    "diagnose good.csv --where pressure>3kPa -o new": "unknown name 'pressure': did you mean p?",
    "diagnose good.csv --effect missing.toml -o new": "missing.toml: no such file",
    "diagnose good.csv --nominal Fz0=3,R0=0.3 -o new": "nominal Fz0 = 3 N is far from the median of Fz",
    "diagnose good.csv good.csv --holdout good.csv --tire good.tir -o new": "--holdout is for one recording",
    "diagnose good.csv --resume --tire good.tir -o new": "are for several recordings",
    "inspect none.csv": "none.csv: no such file",
    "inspect godo.csv": "godo.csv: no such file: did you mean good.csv?",
    "inspect good.dat": "good.dat: no such file: did you mean good.csv?",
    "inspect good.tir": "good.tir: a tire, not a recording",
    "explore good.csv good.tir -o new.html": "good.tir: a tire, not a recording",
    "check good.csv good.fmu": "good.fmu: an FMU, not a recording",
    "inspect good.csv good.csv --table new.csv": "--table writes the rows of one table",
    "inspect good.csv -o no/page.html": "no/page.html: no folder no",
    "inspect good.csv --table new.xlsx": "new.xlsx: unknown kind of table '.xlsx'",
    "inspect good.csv --where Fz>9kN": "selects none of",
    "draw unicamp_small_tyre -o new": "did you mean unicamp_small_tire?",
    "draw missing.tir -o new": "missing.tir: no such file",
    "draw good.tir missing.csv -o new": "missing.csv: no such file",
    "draw unicamp_small_tire --loads 60,heavy -o new": "'60,heavy' is not like 60,110,160",
    "draw unicamp_small_tire --loads 0 -o new": "a load is above 0",
    "draw unicamp_small_tire --signs din -o new": "'din' is not one of",
    "compare good.tir none.tir -o new": "none.tir: no such file",
    "explore trento -o new.html": "trento",
    "explore good.tir no.csv -o new.html": "no.csv: no such file",
    "explore good.tir --fit no.json -o new.html": "no.json: no such file",
    "example -o new.csv --tire hoosier": "hoosier",
    "example -o new.csv --sample-rate 0": "0 is not in the range",
    "init -o new.toml": "no bench file",
    "init missing.csv -o new.toml": "missing.csv: no such file",
    "init good.csv --model mf60 -o new.toml": "unknown model 'mf60'",
    "init good.csv --nominal Fz=1 -o new.toml": "unknown nominal value 'Fz'",
    "init good.csv --nominal Fz0=nan -o new.toml": "'Fz0=nan' is not finite",
    "init good.csv --model mf96 --effects camber_trust -o new.toml": "did you mean camber_thrust?",
    "schema projekt": "did you mean project?",
    "fit-many none.toml -o new": "none.toml: no such file or folder",
}  # fmt: skip


def everything(folder):
    """Return every file below a folder with its content."""
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_reported_in_one_line_and_writes_nothing(folder, command, line):
    arguments = [word for part in line.split() for word in (FIT if part == "{fit}" else [part])]
    before = everything(folder)
    outcome = command(*arguments)
    assert outcome.status == 2
    (message,) = outcome.err.splitlines()
    assert message.startswith("tirefmu: error: ")
    assert BAD[line] in message
    assert "Traceback" not in outcome.out
    assert everything(folder) == before


def test_a_missing_file_is_no_file_of_another_kind(folder, command):
    """Names that share only their extension, or only a part of another kind's name, are not suggested."""
    for call in ("info nowhere.tir", "diagnose good.csv --effect gode.toml -o new"):
        assert command(*call.split()).err.strip().endswith("no such file")


def test_a_broken_tire_file_is_named_with_its_line(folder, command):
    number = Path("broken.tir").read_text(encoding="utf-8").splitlines().index("PDY1 2.7") + 1
    for call in ("evaluate broken.tir good.csv -o new.csv", "export broken.tir -o new.fmu", "info broken.tir"):
        assert f"broken.tir:{number}: " in command(*call.split()).err


def test_an_existing_file_survives_a_failure(folder, command):
    old = Path("good.tir").read_bytes()
    assert command("fit", "degrees.csv", "--model", "mf96", "-o", "good.tir").status == 2
    assert command("export", "broken.tir", "-o", "good.fmu").status == 2
    assert Path("good.tir").read_bytes() == old
    assert command("check", "good.fmu", "good.csv").status == 0
