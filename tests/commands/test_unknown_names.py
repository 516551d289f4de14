"""Every refusal of an unknown name lists the valid ones, or of many the nearest and what lists all."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from tirefmu.applications.batch import KEYS, OPTIONS
from tirefmu.applications.project import SECTIONS
from tirefmu.boundary.errors import FEW, LISTED_BY
from tirefmu.fitting import RECIPES
from tirefmu.fitting.problem import recipe_schema
from tirefmu.measurements import CHANNELS
from tirefmu.measurements.row_selection.expression import NAMES
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import PUBLISHED, published
from tirefmu.tires.property_file.units import UNITS as TIR_UNITS

EFFECT = """\
name = "late_load"
physics = "text"
source = "text"
{more}
[coefficients]
LATE = {{description = "late", unit = "m", lower = 0.01, upper = 5.0, neutral = 0.5}}
[states.late_load]
{state}
[[acts]]
{acts}
"""
STATE, ACTS = 'kind = "lag"\ndrive = "Fz"\nlength = "LATE"', 'on = "friction_y"\nfactor = "1 + 0.1*late_load/FNOMIN"'
EFFECT_KEYS = ("acts", "coefficients", "diagnosis", "name", "physics", "source", "states")


def effect(more="", state=STATE, acts=ACTS):
    return EFFECT.format(more=more, state=state, acts=acts)


#: Content of a file, command that reads it, and names of which all have to be in the message.
FILES = {
    "a section of a project file": ("tirefmu.toml", "[ft]\nmodel = 'mf96'\n", "run {file}", tuple(SECTIONS)),
    "a key of a project file": (
        "tirefmu.toml", "[data]\ntables = ['a.csv']\n[fit]\nmodl = 'mf96'\n", "run {file}", tuple(SECTIONS["fit"]),
    ),
    "a table of a job file": ("j.toml", "[[job]]\nname = 'a'\n", "fit-many {file} -o out", ("defaults", "jobs")),
    "a key of a job": (
        "j.toml", "[[jobs]]\nname = 'a'\ntables = ['a.csv']\nmodle = 'mf96'\n", "fit-many {file} -o out",
        ("name", "tables", *OPTIONS),
    ),
    "a key of a study": ("s.toml", "manoeuvre = 1\n", "study tire.fmu {file} -o out", tuple(KEYS)),
    "a key of a recipe": (
        "r.toml", "[[stage]]\nname = 'a'\nchanels = ['Fx']\n", "fit a.csv --model mf96 --recipe {file} -o t.tir",
        tuple(recipe_schema()["properties"]["stage"]["items"]["properties"]),
    ),
    "a channel of a recipe": (
        "r.toml", "[[stage]]\nname = 'a'\nchannels = ['Fq']\n", "fit a.csv --model mf96 --recipe {file} -o t.tir",
        ("Fx", "Fy", "Mz", "Mx", "My"),
    ),
    "a coefficient of a recipe": (
        "r.toml", "[[stage]]\nname = 'a'\n[stage.free]\nPCX9 = {guess = 1.0}\n",
        "fit a.csv --model mf96 --recipe {file} -o t.tir", ("PCX1", LISTED_BY["coefficient"]),
    ),
    "a key of an effect": ("e.toml", effect("sorce = 'x'"), "diagnose a.csv --effect {file} -o out", EFFECT_KEYS),
    "a kind of state": (
        "e.toml", effect(state=STATE.replace('"lag"', '"lagg"')), "diagnose a.csv --effect {file} -o out",
        ("lag", "heat", "accumulation", "oscillator", "hysteresis", "play"),
    ),
    "a key of a state": (
        "e.toml", effect(state=STATE + '\nstiffness = "LATE"'), "diagnose a.csv --effect {file} -o out",
        ("kind", "drive", "length", "unit", "description"),
    ),
    "a function of a formula": (
        "e.toml", effect(acts=ACTS.replace("1 + ", "expp(1) + ")), "diagnose a.csv --effect {file} -o out",
        ("exp", "sin", "sqrt", "tanh"),
    ),
    "a column": ("c.csv", "sideslip,Fz,Fy\n0.1,900,-500\n", "inspect {file}", tuple(CHANNELS)),
    "a unit of a column": ("c.csv", "alpha [dge],Fz,Fy\n0.1,900,-500\n", "inspect {file}", ("deg", LISTED_BY["unit"])),
    "a kind of file": ("c.xls", "alpha\n1\n", "inspect {file}", (".csv", ".parquet", ".mat", ".dat", ".tdx")),
}  # fmt: skip

OPTIONS_GIVEN = {
    "fit a.csv -o t.tir --model mf69": tuple(MODELS),
    "fit a.csv -o t.tir --model mf96 --recipe jont": RECIPES,
    "fit a.csv -o t.tir --model mf96 --effects camber_trust": ("camber_thrust", LISTED_BY["effect"]),
    "fit a.csv -o t.tir --model mf96 --constraint curvatur": ("curvature", "known"),
    "fit a.csv -o t.tir --model mf96 --nominal F0=3": ("Fz0", "R0", "p0", "V0"),
    "fit a.csv -o t.tir --model mf96 --loss hubr": ("squares", "huber", "cauchy"),
    "fit a.csv -o t.tir --model mf96 --method ipop": ("ipopt", "ioa"),
    "fit a.csv -o t.tir --where load>3": NAMES,
    "fit a.csv -o t.tir --where xyz>3": (*NAMES[:FEW], f"{len(NAMES)} are known"),
    "fit a.csv -o t.tir --signs isso": ("iso", "sae", "adapted-sae"),
    "info trento": tuple(PUBLISHED),
    "effects temp_frction": ("temp_friction", LISTED_BY["effect"]),
    "generate trento_hoosier --language pyton -o out": ("numpy", "c", "cpp", "rust", "latex"),
    "generate trento_hoosier --language c --functions forcs -o out": ("forces", "quantities", "states"),
    "convert trento_hoosier --for adms -o t.tir": ("adams", "carmaker", "chrono", "mfeval"),
    "export trento_hoosier -o t.fmu --inputs hubb": ("slip", "wheel", "hub", "hub-torque"),
    "export trento_hoosier -o t.fmu --platforms lnux": ("host", "all"),
    "draw trento_hoosier -o out --format jpg": ("png", "svg", "pdf"),
    "fitt a.csv": ("fit", "tirefmu --help lists all commands"),
    "fit a.csv --modle mf96": ("--model", "tirefmu fit --help lists all options"),
    "models --foo": ("tirefmu models --help lists all options",),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "\n".join(f"{0.001 * n:.3f},900,{-50 * n}" for n in range(-50, 50))
    (tmp_path / "a.csv").write_text(f"alpha,Fz,Fy\n{rows}\n", encoding="utf-8")
    return tmp_path


def refusal(command, line):
    outcome = command(*line.split())
    (message,) = outcome.err.splitlines()
    assert (outcome.status, outcome.out) == (2, ""), message
    return message


def assert_listed(message, names):
    """Each name is in the message as a word of its own."""
    assert [name for name in names if not re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", message)] == [], message


@pytest.mark.parametrize("what", FILES)
def test_a_file_with_an_unknown_name(what, command, folder, published_fmu):
    name, text, line, known = FILES[what]
    (folder / name).write_text(text, encoding="utf-8")
    line = line.format(file=name).replace("tire.fmu", str(published_fmu))
    assert_listed(refusal(command, line), known)


@pytest.mark.parametrize("line", OPTIONS_GIVEN)
def test_an_option_with_an_unknown_name(line, command, folder):
    assert_listed(refusal(command, line), OPTIONS_GIVEN[line])
    assert sorted(path.name for path in folder.iterdir()) == ["a.csv"]


@pytest.mark.parametrize(
    ("line", "wrong", "known"),
    [
        ("LENGTH ", "LENGHT = 'meter'", tuple(TIR_UNITS)),
        ("LENGTH ", "LENGTH = 'metre3'", ("metre", "known")),
        ("PDY1 ", "PDYY1 = 3", ("PDY1", LISTED_BY["coefficient"])),
        ("TIREFMU_MODEL", "TIREFMU_MODEL = 'mf69'", tuple(MODELS)),
        ("EFFECTS", "EFFECTS = 'camber_trust'", ("camber_thrust", LISTED_BY["effect"])),
    ],
)
def test_a_tire_file_with_an_unknown_name(line, wrong, known, command, folder):
    tire = published("trento_hoosier")
    replace(tire, effects=tire.has - {"camber_thrust"}).save(folder / "t.tir")
    text = (folder / "t.tir").read_text(encoding="utf-8").splitlines()
    assert any(row.startswith(line) for row in text)
    changed = "\n".join(wrong if row.startswith(line) else row for row in text)
    (folder / "t.tir").write_text(changed + "\n", encoding="utf-8")
    message = refusal(command, "info t.tir")
    assert re.match(r"tirefmu: error: t\.tir:\d+: ", message)
    assert_listed(message, known)
