"""The library with the Standard Tyre Interface that reads the property file of its tire."""

from __future__ import annotations

import os
import random
import re
import subprocess

import numpy as np
import pytest

from tirefmu.cli import main
from tirefmu.fmu.description.hub_variables import known_value
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import export, fmi_headers
from tirefmu.fmu.packaging.sources import sti_sources
from tirefmu.fmu.packaging.sti import export_sti, tire_header
from tirefmu.fmu.packaging.written_headers import input_ranges
from tirefmu.symbolic.errors import FmuError, TirefmuError
from tirefmu.tires import Tire
from tirefmu.tires.code.compiler import suffix
from tirefmu.tires.property_file.reading import read_tir

from .test_robustness import SANITIZERS
from .test_sti import SOURCE, motion, run, simulate

FATAL = 3
READER = ("tir_text.c", "tir_entries.c", "tir_tire.c")
#: Fewest keys, units, spellings and notations of the field; what each reader of it makes of them is in tests/tires.
SPELLED = {
    "inches": (
        "mf61",
        "[UNITS]\nLENGTH='inch'\nFORCE = 'pound_force' $ US\nANGLE = 'DEGREE'\nTIME='second'\nPRESSURE='psi'\n"
        "[MODEL]\nFITTYP = 61\n[DIMENSION]\nUNLOADED_RADIUS = 12.0\nWIDTH = '8.5'\nRIM_RADIUS = 7\n[VERTICAL]\n"
        "FNOMIN = 900 ! lbf\nVERTICAL_STIFFNESS=1.2D+3\nVERTICAL_DAMPING = 0.3\nINFLPRES = 32\nNOMPRES = 30\n"
        "BOTTOM_STIFF = 12000\nFZMIN = 50\nFZMAX = 1500\n[LONG_SLIP_RANGE]\nKPUMIN = -.5\nKPUMAX = 5.D-1\n"
        "[SLIP_ANGLE_RANGE]\nALPMIN = -15\nALPMAX = 15\n[LATERAL_COEFFICIENTS]\npcy1 = 1.3\nPDY1 = '+9.5e-1'\n",
    ),
    "spelled twice": (
        "mf52",
        "UNLOADED_RADIUS = 7\r\n[MODEL]\r\nPROPERTY_FILE_FORMAT = 'PAC2002'\r[dimension]\nunloaded_radius = 0.31\n"
        "[SOMETHING]\nUNLOADED_RADIUS = 9\n[VERTICAL]\nFNOMIN = 3000\nFNOMIN = 4000\nIP_NOM = 2e5\nIP = 2.2e5\n"
        "VERTICAL_STIFFNESS = 0\nLFZ0 = 0.9\n[LATERAL_COEFFICIENTS]\nPKY1 = -12.5+0\n[SHAPE]\n{r w}\n 1.0 0.0\n",
    ),
    "fiala": (
        "fiala",
        "[UNITS]\nLENGTH='mm'\nFORCE='newton'\nANGLE='degree'\nMASS='kg'\nTIME='sec'\n[MODEL]\n"
        "PROPERTY_FILE_FORMAT='FIALA'\n[DIMENSION]\nUNLOADED_RADIUS=322\nWIDTH=235\n[PARAMETER]\nFNOMIN=4000\n"
        "VERTICAL_STIFFNESS=310\nVERTICAL_DAMPING=3.1\nROLLING_RESISTANCE=1\nCSLIP=1000\nCALPHA=800\nUMIN=0.9\nUMAX=1.0\n"
        "RELAX_LENGTH_X=0.05\nRELAX_LENGTH_Y=0.15\n",
    ),
    "brush": ("brush", "[MODEL]\nPROPERTY_FILE_FORMAT = 'BRUSH'\nUNLOADED_RADIUS = 0.3\nFNOMIN = 3000\nMUX = 0.8\n"),
}  # fmt: skip


@pytest.fixture(scope="module")
def read(compiler, tmp_path_factory):
    """Return a function that reads files as the library of a tire does: arrays, or texts of what is wrong."""
    built = {}

    def program(shown):
        folder = built[shown.tire.model, "turn_slip" in shown.tire.has] = tmp_path_factory.mktemp("reader")
        for file, content in sti_sources(shown, tire_header(shown, from_file=True), from_file=True).items():
            (folder / file).write_bytes(content)
        sources = [str(SOURCE.with_name("tir_program.c")), *(str(folder / name) for name in READER)]
        command = [*compiler, "-std=c99", f"-I{folder}", *sources, "-o", str(folder / "program"), "-lm"]
        subprocess.run(command, check=True)
        return folder

    def run_reader(tire, *paths):
        shown = interface(tire, inputs="hub")
        folder = built.get((tire.model, shown.twists)) or program(shown)
        command, names = [str(folder / "program")], "".join(f"{path}\n" for path in paths)
        done = subprocess.run(command, input=names, capture_output=True, text=True, check=True)
        return [
            line[1:] if line.startswith("?") else np.array(line.split(), dtype=float)
            for line in done.stdout.splitlines()
        ]

    return run_reader


def blank(model):
    return Tire(model, {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3})


def expected(path):
    """Return width, parameters and ranges of the hub FMU of a tire."""
    shown = interface(read_tir(path), inputs="hub")
    tire = shown.tire
    limits = [limit for limits in input_ranges(shown) for limit in limits]
    return np.array([known_value(tire, "WIDTH", 0.0), *(v.start for v in shown.group("parameter")), *limits])


def write(tmp_path, text, name="tire.tir"):
    path = tmp_path / name
    path.write_bytes(text.encode("latin-1"))
    return path


def assert_equal(found, path):
    assert isinstance(found, np.ndarray), found
    np.testing.assert_allclose(found, expected(path), rtol=1e-14)


@pytest.mark.parametrize("name", ["first", "mf61", "mf62"])
def test_a_written_tire_has_the_values_of_its_fmu(read, tires, tmp_path, name):
    tires[name].save(tmp_path / "tire.tir")
    (found,) = read(tires[name], tmp_path / "tire.tir")
    assert_equal(found, tmp_path / "tire.tir")
    if name == "mf62":  # has no turn slip
        assert read(blank("mf62"), tmp_path / "tire.tir") == [
            "only this library has the effect turn_slip: export a library of this tire"
        ]


@pytest.mark.parametrize("version", ["61", "52", "62"])
def test_files_of_the_field_have_the_values_of_their_fmus(read, golden, version):
    path = golden / f"MagicFormula{version}_Parameters.tir"
    assert_equal(read(blank(read_tir(path).model), path)[0], path)


@pytest.mark.parametrize("file", SPELLED)
def test_units_spellings_and_missing_keys(read, tmp_path, file):
    model, text = SPELLED[file]
    path = write(tmp_path, text)
    assert_equal(read(blank(model), path)[0], path)


def test_both_readers_have_the_same_values_of_random_parts_of_a_file(read, golden, tmp_path):
    lines = (golden / "MagicFormula61_Parameters.tir").read_text(encoding="latin-1").splitlines()
    chosen, valid = random.Random(3), []
    for i in range(25):
        kept = [line for line in lines if chosen.random() > 0.1]
        unit = chosen.choice(["LENGTH = 'mm'", "FORCE = 'kN'", "PRESSURE = 'bar'", "TIME = 'ms'", "ANGLE = 'deg'"])
        path = write(tmp_path, "\n".join([*kept, "[UNITS]", unit, f"{unit} $ again"]), f"{i}.tir")
        try:
            expected(path)
        except TirefmuError:
            continue
        valid.append(path)
    assert len(valid) > 10
    for found, path in zip(read(blank("mf61"), *valid), valid, strict=True):
        assert_equal(found, path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("FITTYP = 61", "FITTYP = 62"), "FITTYP 62 is not the model of this library, mf61"),
        (("FITTYP = 61", "TYPE = 'CAR'"), "the file states no FITTYP and no PROPERTY_FILE_FORMAT"),
        (("FITTYP = 61", "PROPERTY_FILE_FORMAT = 'FTIRE'"), "the format FTIRE does not state the model mf61"),
        (("[MODEL]", "[TIREFMU]\nTIREFMU_MODEL = 'mf62'\n[MODEL]"), "the tire has the model mf62, this library mf61"),
        (("[MODEL]", "[TIREFMU]\nEFFECTS = 'heat_friction'\n[MODEL]"), "this library has no effect heat_friction"),
        (("[MODEL]", "[TIREFMU_ADDED]\nWARM = 'x'\n[MODEL]"), "this library has no effect WARM"),
        (("[MODEL]", "[TIREFMU]\nEFFECTS = 'load_friction'\n[MODEL]"), "only this library has the effect turn_slip"),
        (("= 4000", "= 4 kN"), "FNOMIN = 4 kN is not a number"),
        (("= 4000", "= 1,5"), "FNOMIN = 1,5 is not a number"),
        (("= 4000", "= nan"), "FNOMIN = nan is not a number"),
        (("= 4000", "= 1e999"), "FNOMIN is too large"),
        (("= 4000", "="), "a tire needs FNOMIN > 0"),
        (("= 4000", f"= {'4' * 3000}"), "line 4 is too long"),
        (("RADIUS = 0.3", "RADIUS = -0.3"), "a tire needs UNLOADED_RADIUS > 0"),
        (("[MODEL]", "[UNITS]\nLENGTH = 'parsec'\n[MODEL]"), "the unit 'parsec' of LENGTH is unknown"),
        (("[MODEL]", "[UNITS]\nLUNGTH = 'm'\n[MODEL]"), "unknown key LUNGTH in [UNITS]"),
        (("[MODEL]", "[MODEL"), "line 1: a section is not closed"),
        (("[MODEL]\n", "[VERTICAL]\nFZMIN 3\n[MODEL]\n"), "FZMIN 3 in [VERTICAL] is not KEY = value"),
        (("[MODEL]", "\xff\xfe[MODEL]"), "the text is UTF-16"),
        (("[MODEL]", "[VERTICAL]\nFZMIN = 5\nFZMAX = 1\n[MODEL]"), "a valid range of the tire ends at 1 before"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused(read, tmp_path, change, message):
    text = "[MODEL]\nFITTYP = 61\nUNLOADED_RADIUS = 0.3\nFNOMIN = 4000\n"
    good, bad = write(tmp_path, text, "good.tir"), write(tmp_path, text.replace(*change), "bad.tir")
    assert good.read_bytes() != bad.read_bytes()
    found, refused = read(blank("mf61"), good, bad)
    assert isinstance(found, np.ndarray), found
    assert isinstance(refused, str)
    assert message in refused


@pytest.fixture(scope="module")
def library(compiler, tires, tmp_path_factory):
    """Return a library of the model mf96."""
    return export_sti(tires["first"], tmp_path_factory.mktemp("library") / f"libtire{suffix()}", values="file")


@pytest.fixture(scope="module")
def program(compiler, library):
    built = library.parent / "host"
    command = [
        *compiler,
        "-std=c99",
        str(SOURCE),
        "-o",
        str(built),
        str(library),
        "-lm",
        f"-Wl,-rpath,{library.parent}",
    ]
    subprocess.run(command, check=True)
    return built


@pytest.mark.parametrize("entry", ["tirefmu_sti", "tirefmu_sti_"])
def test_forces_are_those_of_the_fmu_of_the_file(program, tires, compiler, tmp_path, entry):
    tire = tires["second"].with_values(UNLOADED_RADIUS=0.31)
    tire.save(tmp_path / "other.tir")
    given = motion("launch", 0.31)
    found, report, status = run(program, entry, *given, tire_file=tmp_path / "other.tir")
    assert status == 0, report
    assert f"{len(tire.values) + 8 + 8 + 18} parameters" in report
    values = simulate(export(tire, tmp_path / "tire.fmu", inputs="hub"), tmp_path, entry, 0.31, *given)
    size = 1.0 + np.abs(values).max(axis=0)
    assert np.abs((found[:, : values.shape[1]] - values) / size).max() < 1e-9
    assert np.abs(values[:, 0]).max() > 100.0


def test_a_file_that_cannot_be_used_is_fatal(program, tmp_path):
    given = motion("slalom", 0.3)
    bad = write(tmp_path, "[MODEL]\nFITTYP = 61\n")
    for file, message in (
        ("", "no tire file is named: this library reads one"),
        (tmp_path / "absent.tir", "absent.tir: the file cannot be opened"),
        (tmp_path, "unreadable"),
        (bad, "tire.tir: FITTYP 61 is not the model of this library, mf96"),
    ):
        found, report, status = run(program, "tirefmu_sti_", *given, tire_file=file)
        assert (len(found), status) == (0, FATAL)
        assert message in report


def test_a_tire_with_added_effects_is_compiled_in(tires, tmp_path, capsys):
    with pytest.raises(FmuError, match=r"no added effects \(temp_friction\)"):
        export_sti(Tire("mf96", tires["first"].values, effects=["temp_friction"]), tmp_path / "tire.so", values="file")
    with pytest.raises(FmuError, match="known are built-in, file"):
        export_sti(tires["first"], tmp_path / "tire.so", values="fil")
    assert main(["export", "trento_hoosier", "-o", str(tmp_path / "tire.fmu"), "--values", "file"]) == 2
    assert "--values file is for --kind sti" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_random_faults_in_a_file(tires, compiler, tmp_path):
    """No file crashes the host, gives a code that the standard does not have, or a force that is not finite."""
    shown, sanitized = interface(tires["first"], inputs="hub"), bool(os.environ.get("TIREFMU_SANITIZE"))
    for file, content in sti_sources(shown, tire_header(shown, from_file=True), from_file=True).items():
        (tmp_path / file).write_bytes(content)
    tires["first"].save(tmp_path / "tire.tir")
    command = [
        *compiler, "-std=gnu99", "-O1", *(SANITIZERS if sanitized else ()), f"-I{fmi_headers()}",
        str(SOURCE.with_name("fuzz_sti.c")), *map(str, tmp_path.glob("*.c")), "-o", str(tmp_path / "fuzz"), "-lm",
    ]  # fmt: skip
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    count = 5 * int(os.environ.get("TIREFMU_FUZZ", "200"))
    command = [str(tmp_path / "fuzz"), str(tmp_path / "tire.tir"), str(tmp_path / "spoiled.tir"), str(count)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    accepted, refused = map(int, re.findall(r"\d+", done.stdout))
    assert accepted + refused == count
    assert min(accepted, refused) > 0.05 * count
