""".tir files of other tools: every model number, every notation, missing and additional keys."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import TirefmuWarning, TirError
from tirefmu.commands.cli import main
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import read_tir, write_tir
from tirefmu.tires.property_file.names import not_given
from tirefmu.tires.property_file.reading import read_tir_with_notes
from tirefmu.tires.property_file.writing import tir_text

pytestmark = pytest.mark.filterwarnings("ignore:.*is the file complete:tirefmu.boundary.errors.TirefmuWarning")

FILES = {"mf52": "MagicFormula52", "mf61": "MagicFormula61", "mf62": "MagicFormula62"}


@pytest.fixture(params=FILES)
def field_file(request, golden):
    """Return the model and the path of a file of another tool."""
    return request.param, golden / f"{FILES[request.param]}_Parameters.tir"


def bits(tire):
    return {name: value.hex() for name, value in tire.values.items()}


def written(path, content, **how):
    how = how or {"encoding": "utf-8", "newline": ""}
    path.write_text(content, **how)
    return path


def small(lines, model="FITTYP = 61"):
    """Return the text of a small file with additional lines."""
    return f"[MODEL]\n{model}\n[DIMENSION]\nUNLOADED_RADIUS = 0.3\n[VERTICAL]\nFNOMIN = 4000\n{lines}\n"


def test_values_are_those_of_the_reference_reader(field_file, golden):
    """Given or missing, every coefficient equals that of MFeval for its golden rows."""
    model, path = field_file
    tire = read_tir(path)
    reference = json.loads((golden / f"{model}_{FILES[model]}_params.json").read_text(encoding="utf-8"))
    assert tire.model == model
    compared = {name: value for name, value in tire.values.items() if name in reference}
    # Keys that MFeval does not read.
    published = {name for name in tire.values if tire.symbolic_model.coefficients[name].published}
    assert published - compared.keys() <= {"QBZ6", "LMUV", "Q_A1", "Q_A2"}
    assert compared == {name: reference[name] for name in compared}


def test_what_the_file_lacks_is_listed(field_file):
    model, path = field_file
    keys = set(re.findall(r"^(\w+)\s*=", path.read_text(encoding="utf-8"), re.MULTILINE))
    assert set(not_given(read_tir(path))) == MODELS[model].coefficients.keys() - keys


def test_a_rewritten_file_is_the_same_tire_with_the_same_content(field_file, tmp_path):
    _, path = field_file
    tire = read_tir(path)
    again = tmp_path / path.name
    write_tir(tire, again)
    read = read_tir(again)
    assert read == tire
    assert bits(read) == bits(tire)
    assert not_given(read) == not_given(tire)
    assert tir_text(read) == tir_text(tire)
    before = re.findall(r"^(\w+)\s*=", path.read_text(encoding="utf-8"), re.MULTILINE)
    after = re.findall(r"^(\w+)\s*=", again.read_text(encoding="utf-8"), re.MULTILINE)
    assert set(before) <= set(after)


@pytest.mark.parametrize("effects", ["'load_friction,camber_stiffness'", "''"])
def test_defaults_of_an_absent_effect_are_those_of_the_tire(effects, tmp_path):
    tire = read_tir(written(tmp_path / "t.tir", small(f"[TIREFMU]\nEFFECTS = {effects}")))
    write_tir(tire, tmp_path / "t.tir")
    assert read_tir(tmp_path / "t.tir") == tire
    assert tire.values["QSX4"] == MODELS["mf61"].coefficients["QSX4"].neutral
    assert "QSX4" in tire.defaulted


@pytest.mark.parametrize(("lines", "has"), [("SIGX = 0.3", True), ("SIGX = 0", False), ("", False)])
def test_a_relaxation_length_in_a_file_acts(lines, has, tmp_path):
    tire = read_tir(written(tmp_path / "t.tir", small(lines)))
    assert tire.has == MODELS["mf61"].default_effects | ({"relax_lon"} if has else set())
    assert tire.values["SIGX"] == (0.3 if has else 0.0)
    without = read_tir(written(tmp_path / "t.tir", small(f"{lines}\n[TIREFMU]\nEFFECTS = ''")))
    assert without.has == set()


def test_what_a_file_lacks_is_the_same_in_other_signs(field_file):
    """Defaults of a reader are in ISO: they are mirrored with the other values, not assumed again."""
    _, path = field_file
    tire = read_tir(path)
    assert bits(tire.in_signs("adapted-sae").in_signs("iso")) == bits(tire)


WAYS = {
    "lines of Windows": lambda text: text.replace("\n", "\r\n").encode(),
    "lines of old Macs": lambda text: text.replace("\n", "\r").encode(),
    "mixed line ends": lambda text: re.sub("\n", lambda m: "\r\n" if m.start() % 2 else "\r", text).encode(),
    "no last line end": lambda text: text.rstrip("\n").encode(),
    "a byte order mark": lambda text: text.encode("utf-8-sig"),
    "UTF-16": lambda text: text.encode("utf-16"),
    "Latin-1": lambda text: ("! 20\u00b0 Schr\u00e4glauf\n" + text).encode("latin-1"),
    "tabs": lambda text: re.sub(" +", "\t", text.replace(" 1.0 ", "@").replace(" 0.9 ", "#")).replace("@", " 1.0 ")
    .replace("#", " 0.9 ").replace("\t0.", "    0.").replace("\t1.0", "    1.0").encode(),
    "no blanks": lambda text: re.sub(r" *= *", "=", text).encode(),
    "lower case": lambda text: text.replace("{radial", "@").lower().replace("@", "{radial").encode(),
    "other comments": lambda text: text.replace("$", "!").encode(),
    "Fortran's exponents": lambda text: re.sub(r"(\d)[eE]([+-]\d)", r"\1D\2", text).encode(),
    "numbers in quotes": lambda text: re.sub(r"(?m)^(P\w+ *= *)([-+.\deE]+)", r"\1'\2'", text).encode(),
    "blank lines": lambda text: text.replace("\n", "\n \t \n").encode(),
    "indented": lambda text: re.sub(r"(?m)^(?=[\[A-Z$])", "   ", text).encode(),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_the_notation_does_not_matter(field_file, way, tmp_path):
    _, path = field_file
    text = path.read_text(encoding="utf-8")
    (tmp_path / path.name).write_bytes(WAYS[way](text))
    tire, other = read_tir(path), read_tir(tmp_path / path.name)
    assert bits(other) == bits(tire)
    assert (other.model, other.side, other.ranges) == (tire.model, tire.side, tire.ranges)
    assert [line[:2] for line in other.other_entries] == [line[:2] for line in tire.other_entries]


@pytest.mark.parametrize(
    ("fittyp", "model"),
    [*((n, "mf52") for n in (5, 6, 21, 51, 52)), (60, "mf61"), (61, "mf61"), (62, "mf62"), ("6.0", "mf52"),
     ("'61'", "mf61"), ("62  Magic Formula", "mf62")],
)  # fmt: skip
def test_the_number_of_a_model(fittyp, model, tmp_path):
    path = written(tmp_path / "t.tir", small("", f"FITTYP = {fittyp}"))
    assert read_tir_with_notes(path).tire.model == model


@pytest.mark.parametrize(
    ("form", "lines", "model"),
    [
        ("PAC2002", "", "mf52"),
        ("pac2002", "FITTYP = ", "mf52"),
        ("MF_05", "", "mf52"),
        ("MF-TYRE", "", "mf52"),
        ("MF-Tyre 6.1", None, "PROPERTY_FILE_FORMAT 'MF-TYRE 6.1' is not a model of this version"),
        ("USER", "PKY6 = -1", "mf61"),
        ("USER", "PHY3 = 0.1", "mf52"),
        ("USER", "Q_CAM3 = 0.1\nPKY6 = -1", "mf62"),
        ("USER", None, "no FITTYP in [MODEL], and 'USER' does not identify the model"),
        ("TMEASY", None, "the file is for TMeasy, which describes each curve by its own points: tirefmu reads files"),
        ("PAC89", None, "the file is for the Magic Formula of 1989 (PAC89)"),
        ("PAC94", None, "the file is for the Magic Formula of 1994 (PAC94)"),
        ("PAC_MC", None, "the file is for the Magic Formula for motorcycle tires (PAC_MC)"),
        ("FTire", None, "the file is for FTire"),
        ("UA", None, "the file is for the University of Arizona model (UA)"),
        ("5.2.1", None, "the file is for the 5.2.1 tire of Adams"),
        ("SWIFT-TYRE", None, "the file is for SWIFT, a rigid ring model"),
        ("PAC2003", None, "did you mean PAC2002?"),
    ],
)
def test_a_file_without_number(form, lines, model, tmp_path):
    path = written(tmp_path / "t.tir", small(lines or "", f"PROPERTY_FILE_FORMAT = '{form}'"))
    if lines is None:
        with pytest.raises(TirError) as caught:
            read_tir(path)
        assert model in str(caught.value)
        return
    reading = read_tir_with_notes(path)
    assert reading.tire.model == model
    assert any(note.startswith(f"no FITTYP: {model} by ") for note in reading.notes)
    # The name of the format is preserved, in addition to a FITTYP that all readers understand.
    text = tir_text(reading.tire)
    assert f"PROPERTY_FILE_FORMAT = '{form}'" in text
    assert re.search(r"^FITTYP = (6|61|62)  ", text, re.MULTILINE)


def test_a_json_file_is_named(tmp_path):
    path = written(tmp_path / "tire.json", '{"model": "TMeasy", "fz": [3000.0, 6000.0]}\n')
    with pytest.raises(TirError, match="a JSON file, as of TMeasy"):
        read_tir(path)


@pytest.mark.parametrize(
    ("side", "read"), [("LEFT", "left"), ("Right", "right"), ("SYMMETRIC", "symmetric"), ("UNKNOWN", ""), ("", "")]
)
def test_the_side_of_the_vehicle(side, read, tmp_path):
    tire = read_tir_with_notes(written(tmp_path / "t.tir", small("", f"FITTYP = 61\nTYRESIDE = '{side}'"))).tire
    assert tire.side == read
    assert f"TYRESIDE = '{side if read == '' else side.upper()}'" in tir_text(tire)


def test_keys_belong_to_their_section(tmp_path):
    lines = "[UNITS]\nMASS = 'kg'\n[INERTIA]\nMASS = 9.3\nMASS = 8.1\n[SOMEWHERE]\nPCX1 = 1.5\nPDX1 = 1\n"
    lines += "[LONGITUDINAL_COEFFICIENTS]\nPDX1 = 1.1\nPDX1 = 1.2\n[ELSEWHERE]\nPDX1 = 3"
    reading = read_tir_with_notes(written(tmp_path / "t.tir", small(lines)))
    assert (reading.tire.values["PCX1"], reading.tire.values["PDX1"]) == (1.5, 1.2)
    assert reading.tire.other_entries[0] == ("INERTIA", "MASS", "8.1")
    assert "line 16: PDX1 = 1.1 is given again in line 17, which counts" in reading.disputed


@pytest.mark.parametrize(
    ("alias", "name"),
    [("LFZ0", "LFZO"), ("QPZ1", "PPZ1"), ("QPZ2", "PPZ2"), ("QPX1", "PPMX1"), ("IP", "INFLPRES"), ("IP_NOM", "NOMPRES"),
     ("LKYG", "LKYC")],
)  # fmt: skip
def test_other_spellings(alias, name, tmp_path):
    tire = read_tir(written(tmp_path / "t.tir", small(f"{alias} = 0.7")))
    assert tire.values[name] == 0.7
    assert name not in not_given(tire)
    both = read_tir(written(tmp_path / "t.tir", small(f"{alias} = 0.7\n{name} = 0.9")))
    assert both.values[name] == 0.9
    assert ("VERTICAL", alias, "0.7") in both.other_entries


def test_an_empty_value_is_a_missing_one(tmp_path):
    tire = read_tir(written(tmp_path / "t.tir", small("[LATERAL_COEFFICIENTS]\nPDY1 =\nPKY1 = ''\nPKY2= $ none")))
    none = read_tir(written(tmp_path / "t.tir", small("")))
    assert bits(tire) == bits(none)
    assert {"PDY1", "PKY1", "PKY2"} <= set(not_given(tire))
    assert tire.values["PKY1"] == MODELS["mf61"].coefficients["PKY1"].assumed == -20.0


def test_a_zero_stiffness_or_radius_of_the_body_is_a_missing_value(tmp_path):
    """Some files state 0 for a stiffness that nobody measured; with turn slip every force was NaN."""
    path = written(tmp_path / "t.tir", small("[VERTICAL]\nVERTICAL_STIFFNESS = 0\nQ_RE0 = 0\nPFZ1 = 0"))
    reading = read_tir_with_notes(path)
    tire, notes = reading.tire, reading.notes
    assert {"VERTICAL_STIFFNESS", "Q_RE0"} <= set(not_given(tire))
    assert tire.values["PFZ1"] == 0.0
    assert sum("= 0 is not possible" in note for note in notes) == 2
    turning = tire.evaluate(pd.DataFrame({"Fz": [600.0], "alpha": [0.05], "phit": [0.1]}))
    assert np.isfinite(turning.to_numpy()).all()


@pytest.mark.parametrize(
    ("value", "number"),
    [(".5", 0.5), ("5.", 5.0), ("+5", 5.0), ("1.5D+03", 1500.0), ("1.5d3", 1500.0), ("1.5+3", 1500.0),
     ("-1.5-3", -1.5e-3), ("'2.5'", 2.5), ('"2.5"', 2.5), ("2.5 [-]", 2.5), ("2.5 nominal", 2.5),
     ("'2.5' nominal", 2.5), ("1e-400", 0.0)],
)  # fmt: skip
def test_numbers(value, number, tmp_path):
    assert read_tir(written(tmp_path / "t.tir", small(f"PDX1 = {value}"))).values["PDX1"] == number


@pytest.mark.parametrize(
    "value", ["1,5", "1.5.2", "1e", "0x10", "1_000", "inf", "NaN", "1e999", "1 2", "'1", "--1", "1.5kN"]
)
def test_a_value_that_is_not_a_number_is_reported(value, tmp_path):
    path = written(tmp_path / "t.tir", small(f"PDX1 = {value}"))
    with pytest.raises(TirError) as caught:
        read_tir(path)
    assert str(caught.value) == f"{path}:7: PDX1 = {value!r} is not a number"


def test_a_key_similar_to_a_coefficient_is_reported_and_preserved(tmp_path):
    lines = "[LATERAL_COEFFICIENTS]\nPDYI = 1.2\nLGAY = 1\n[SHOP]\nPDYI = 3"
    reading = read_tir_with_notes(written(tmp_path / "t.tir", small(lines)))
    (note,) = (note for note in reading.notes if "unknown" in note)
    assert note == "line 8: unknown key PDYI (near PDY1) is stored, not used"
    assert ("LATERAL_COEFFICIENTS", "PDYI", "1.2") in reading.tire.other_entries


def test_tables_headers_and_unknown_sections_are_preserved_exactly(tmp_path):
    lines = (
        "[MDI_HEADER]\n(COMMENTS)\n{comment_string}\n'Tire = x'\n[SHAPE]\n{radial width}\n 1.0\t0.0 $ a\n[VERTICAL]\n"
    )
    lines += "{pen fz}\n0 0\nMORE = 'a $ b'\n[SHOP]\nPRICE = it's 5\nno equals sign"
    tire = read_tir(written(tmp_path / "t.tir", small(lines)))
    assert tire.other_entries[:10] == (
        ("MDI_HEADER", "", "(COMMENTS)"),
        ("MDI_HEADER", "", "{comment_string}"),
        ("MDI_HEADER", "", "'Tire = x'"),
        ("VERTICAL", "", "{pen fz}"),
        ("VERTICAL", "", "0 0"),
        ("VERTICAL", "MORE", "'a $ b'"),
        ("SHAPE", "", "{radial width}"),
        ("SHAPE", "", " 1.0\t0.0 $ a"),
        ("SHOP", "PRICE", "it's 5"),
        ("SHOP", "", "no equals sign"),
    )
    write_tir(tire, tmp_path / "t.tir")
    assert read_tir(tmp_path / "t.tir") == tire


def test_ranges_that_only_our_sections_hold(tmp_path):
    tire = replace(read_tir(written(tmp_path / "t.tir", small(""))), ranges={"V": (0.5, 30.0), "T": (-5.0, 80.0)})
    write_tir(tire, tmp_path / "t.tir")
    assert read_tir(tmp_path / "t.tir") == tire


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("[TIREFMU]\nEFECTS = ''", "unknown key EFECTS of mf61: did you mean EFFECTS?"),
        ("[TIREFMU_ASSUMED]\nVERTICAL = 'Q_RE9'", "unknown coefficient Q_RE9 of mf61: did you mean Q_RE0?"),
        ("[TIREFMU_RANGES]\nV = '30,1'", "V = '30,1' is not a range 'lower,upper'"),
        ("[TIREFMU_RANGES]\nVV = '1,2'", "unknown key VV"),
        ("[TIREFMU_TRANSIENT]\nSIGZ = 1", "unknown key SIGZ of mf61: did you mean SIG"),
        ("[LONG_SLIP_RANGE]\nKPUMIN = 1\nKPUMAX = -1", "KPUMIN = 1.0 lies above KPUMAX = -1.0"),
    ],
)
def test_faults_in_the_sections_of_tirefmu_are_reported(lines, message, tmp_path):
    path = written(tmp_path / "t.tir", small(lines))
    with pytest.raises(TirError) as caught:
        read_tir(path)
    assert str(caught.value).startswith(f"{path}:8: ")
    assert message in str(caught.value)


CORE = (
    "[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.6\nPDX1 = 1.2\nPKX1 = 22\n[LATERAL_COEFFICIENTS]\nPCY1 = 1.4\nPDY1 = 1\n"
    "PKY1 = -15\n[ALIGNING_COEFFICIENTS]\nQBZ1 = 9\nQCZ1 = 1.1\nQDZ1 = 0.1\n"
)
OFFSETS = "[LATERAL_COEFFICIENTS]\nPHY1 = 0.004\nPVY1 = 0.03\n[ALIGNING_COEFFICIENTS]\nQDZ6 = 0.01\n"


@pytest.mark.parametrize("text", ["SYMMETRIC", "Symmetric", "symmetrical", " SYMMETRIC ", "SYM"])
@pytest.mark.parametrize("fittyp", [6, 61, 62])
def test_a_symmetric_tire_has_no_force_at_zero_slip(text, fittyp, tmp_path):
    reading = read_tir_with_notes(
        written(tmp_path / "t.tir", small(OFFSETS, f"FITTYP = {fittyp}\nTYRESIDE = '{text}'"))
    )
    forces = reading.tire.forces(alpha=[0.0, 0.1, -0.1])
    assert forces["Fy"][0] == 0.0
    assert forces["Fy"][1] == -forces["Fy"][2]
    assert any("PHY1, PVY1, QDZ6" in note for note in reading.notes)
    path = written(tmp_path / "again.tir", tir_text(reading.tire))
    again = read_tir_with_notes(path)
    assert again.tire.side == "symmetric"
    assert not [note for note in again.notes if "SYMMETRIC" in note]


@pytest.mark.parametrize(
    ("line", "note"),
    [
        ("TYRESIDE = 'BOTH'", "none of LEFT, RIGHT, SYMMETRIC"),
        ("USE_MODE = 0", "no slip forces"),
        ("USE_MODE = 11", "Fx and My only"),
        ("USE_MODE = 112", "Fy, Mx and Mz only"),
        ("USE_MODE = 13", "without combined slip"),
        ("USE_MODE = -14", "mirror"),
        ("USE_MODE = 19", "unknown"),
        ("USE_MODE = 'all'", "no whole number"),
        ("[SCALING_COEFFICIENTS]\nLGAY = 0.5", "LGAY = 0.5: other programs may scale forces by it, mf61 does not"),
        ("USE_MODE = 14", "let the slips lag"),
        ("USE_MODE = 124", "let the slips lag"),
        ("MFSAFE2 = 1", "limits forces"),
        ("FE_METHOD = 'YES'", "friction ellipse"),
    ],
)
def test_what_a_file_requests_and_tirefmu_does_not_do_is_stated(line, note, tmp_path):
    reading = read_tir_with_notes(written(tmp_path / "t.tir", small("", f"FITTYP = 61\n{line}")))
    key = line.split("\n")[-1].split(" ")[0]
    assert any(key in stated and note in stated for stated in reading.notes), reading.notes


@pytest.mark.parametrize(
    ("line", "note"),
    [
        ("FITTYP = 52", "FITTYP 52 is read as mf52; MFeval reads it as MF6.1"),
        ("FITTYP = 61\nPROPERTY_FILE_FORMAT = 'PAC2002'", "FITTYP is that of mf61, PROPERTY_FILE_FORMAT 'PAC2002'"),
        ("FITTYP = 61\nUSE_MODE = 3", "other programs compute forces without combined slip"),
        ("FITTYP = 62\nTYRESIDE = 'SYMMETRIC'", "what makes left and right differ is set to 0: PHY1, PVY1, QDZ6"),
    ],
)
def test_what_other_programs_read_otherwise_is_a_warning_of_every_reading(line, note, tmp_path, capsys):
    path = written(tmp_path / "t.tir", small(CORE + OFFSETS, line))
    with pytest.warns(TirefmuWarning, match=re.escape(note)) as caught:
        read_tir(path)
    assert [warning.filename for warning in caught] == [__file__]
    command = ["export", str(path), "--kind", "ssv", "-o", str(tmp_path / "t.ssv")]
    assert main(command) == 0
    assert capsys.readouterr().err.count(f"tirefmu: warning: {path}: ") == 1
    assert main([*command, "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_what_agrees_is_not_stated(tmp_path):
    lines = "FITTYP = 61\nTYRESIDE = 'LEFT'\nUSE_MODE = 104\nMFSAFE1 = 0\nVXLOW = 1\nLONGVL = 16.7\nFE_METHOD = 'NO'"
    notes = read_tir_with_notes(written(tmp_path / "t.tir", small("", lines))).notes
    assert not [note for note in notes if any(line.split(" ")[0] in note for line in lines.split("\n"))]


@pytest.mark.parametrize("fittyp", [5, 51, 52])
def test_a_number_without_one_meaning_is_noted(fittyp, tmp_path):
    notes = read_tir_with_notes(written(tmp_path / "t.tir", small("", f"FITTYP = {fittyp}"))).notes
    assert [note for note in notes if f"FITTYP {fittyp} is read as mf52" in note and "MFeval" in note]


@pytest.mark.parametrize(
    ("broken", "lacking"),
    [
        (lambda text: text.partition("[LATERAL")[0], "PCY1 = 1.3, PDY1 = 1.1, PKY1 = -20, QBZ1 = 10"),  # cut off
        (lambda text: text.replace("PDY1 = 1\n", "PDY1 =\n"), "PDY1 = 1.1"),
        (lambda text: text.replace("PKX1", "PKX9"), "PKX1 = 20"),
    ],
)
def test_a_file_that_lacks_what_every_tire_has_is_not_sound(broken, lacking, tmp_path, capsys):
    whole, part = (
        written(tmp_path / name, text) for name, text in (("w.tir", small(CORE)), ("p.tir", broken(small(CORE))))
    )
    assert not any("complete" in note for note in read_tir_with_notes(whole).notes)
    (note,) = read_tir_with_notes(part).typical
    assert note.split("assumed: ")[1].startswith(lacking)
    assert [main(["lint", str(path)]) for path in (whole, part)] == [0, 1]
    assert main(["export", str(part), "--kind", "ssv", "-o", str(tmp_path / "p.ssv")]) == 0
    assert "warning: " in capsys.readouterr().err
    # A file of tirefmu that lists them as assumed does not repeat it.
    write_tir(read_tir(part), tmp_path / "own.tir")
    assert read_tir_with_notes(tmp_path / "own.tir").typical == ()


@pytest.mark.parametrize("name", ["FNOMIN", "UNLOADED_RADIUS"])
@pytest.mark.parametrize("value", ["0", "-0.3"])
def test_no_tire_has_a_nominal_load_or_a_radius_of_zero(name, value, tmp_path):
    text = re.sub(rf"{name} = \S+", f"{name} = {value}", small(CORE))
    with pytest.raises(TirError, match=rf"t\.tir: {name} = {value}: a positive value expected"):
        read_tir(written(tmp_path / "t.tir", text))


def test_coefficients_of_another_model_are_named(tmp_path, capsys):
    text = small(CORE + "[LATERAL_COEFFICIENTS]\nPKY6 = -0.9\n", "FITTYP = 6")
    main(["lint", str(written(tmp_path / "t.tir", text))])
    assert "given but ignored by mf52: PKY6 = -0.9" in " ".join(capsys.readouterr().out.split())


def test_the_end_of_file_of_dos_ends_the_file(tmp_path):
    for end in ("\x1a", "\r\n\x1a\x1a\0\0"):
        assert read_tir(written(tmp_path / "t.tir", small(CORE) + end)).values["PDY1"] == 1.0


def test_a_file_of_bytes_is_not_read_as_text(tmp_path):
    (tmp_path / "t.tir").write_bytes(b"PK\x03\x04\0\0[\xff\0]")
    with pytest.raises(TirError, match=r"t\.tir: not a text: not a \.tir file"):
        read_tir(tmp_path / "t.tir")
