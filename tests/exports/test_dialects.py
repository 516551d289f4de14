"""Property files for other programs: what conversion writes passes the check, and each planted fault is found."""

from __future__ import annotations

import os
import re
from dataclasses import replace

import numpy as np
import pytest

from tirefmu import convert, lint
from tirefmu.applications.exports import HOSTS, operating_conditions
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import published, read_tir
from tirefmu.tires.evaluation import forces

CASES = [(host, model) for host, rules in HOSTS.items() for model in rules.dialects]


def errors_of(path, host):
    return [finding for finding in lint(path, host) if finding.severity == "error"]


def forces_of(tire):
    rows = dict(zip(tire.inputs, operating_conditions(tire, 30), strict=True))
    return np.stack(list(forces(tire, rows).values()))


@pytest.mark.parametrize(("host", "model"), CASES)
def test_a_converted_file_is_accepted_and_is_the_same_tire(tire_of, tmp_path, host, model):
    result = convert(tire_of(model), tmp_path / "x.tir", host)
    assert result.model == model
    assert not result.refitted
    assert not errors_of(result.path, host)
    written = read_tir(result.path)
    assert written.model == model
    np.testing.assert_array_equal(forces_of(written), forces_of(tire_of(model)))
    text = result.path.read_text()
    for key, value in HOSTS[host].dialects[model].entries.items():
        assert text.count(f"\n{key} = {value}  $ of the model\n") == 1, key


def test_every_host_lacks_an_unpublished_coefficient(tire_of, tmp_path, monkeypatch):
    """Transient slip is computed by hosts in their own way."""
    monkeypatch.setattr(MODELS["mf61"].coefficients["PDY3"], "section", "TIREFMU_FRICTION")
    tire = tire_of("mf61")
    replace(tire, values={**tire.values, "PDY3": 0.25, "SIGX": 0.3}, effects={*tire.has, "relax_lon"}).save(
        tmp_path / "own.tir"
    )
    for host in [host for host, model in CASES if model == "mf61"]:
        lacking = [finding.text for finding in errors_of(tmp_path / "own.tir", host) if "lacks" in finding.text]
        assert lacking == ["PDY3 is 0.25: the host lacks it, as if it were 0"], host


def cut_and_read(path):
    """Read values as MFeval's public reader of 2020 does: it takes the last two characters of every line for CRLF."""
    found = {}
    for line in path.read_bytes().decode().split("\n"):
        line = line + "\n"
        key, equals, rest = line[:-2].partition("=")
        if equals and not key.startswith(("$", "!", "[")):
            found[key.strip()] = rest.partition("$")[0].strip()
    return found


@pytest.mark.parametrize("model", ["mf52", "mf61", "mf62"])
@pytest.mark.parametrize("way", ["convert", "save", "LF without comments"])
def test_a_reader_that_cuts_lines_reads_the_same_tire(tire_of, tmp_path, model, way):
    tire, path = tire_of(model), tmp_path / "x.tir"
    if way == "convert":
        convert(tire, path, "mfeval")
        assert path.read_bytes().count(b"\r\n") == path.read_bytes().count(b"\n") > 0
    else:
        tire.save(path)
    if way == "LF without comments":
        path.write_bytes(re.sub(rb" *[$].*", b"", path.read_bytes()))
    read = cut_and_read(path)
    lost = [finding for finding in errors_of(path, "mfeval") if "loses its last characters" in finding.text]
    if way == "LF without comments":
        assert lost
        return
    assert not lost
    assert read["FITTYP"] == str(MODELS[model].property_file.fittyp[0])
    values = {name: float(read[name]) for name in tire.values if name in read}
    again = replace(tire, values={**tire.values, **values})
    camber = {"kappa": 0.02, "alpha": 0.05, "gamma": 0.08, "Fz": 0.8 * tire.values["FNOMIN"]}
    assert tire.forces(**camber) == again.forces(**camber)


def test_tables_reach_a_reader_that_cuts_lines_and_knows_one_table_only(tire_of, tmp_path):
    """MFeval skips [SHAPE]; it stops at a row of another table, and of [SHAPE] if its heading loses the bracket."""
    tire, path = tire_of("mf52"), tmp_path / "x.tir"
    curve = (("DEFLECTION_LOAD_CURVE", "", " 0.00  0.0"), ("DEFLECTION_LOAD_CURVE", "", " 0.01  900.0"))
    replace(tire, other_entries=(*tire.other_entries, *curve)).save(path)
    assert {line[:-1] for line in path.read_text().split("\n") if "SHAPE" in line} == {"[SHAPE]"}
    assert [found.text for found in errors_of(path, "mfeval")] == [
        "a row without '=' in [DEFLECTION_LOAD_CURVE]: the program stops here"
    ]
    assert not errors_of(convert(read_tir(path), tmp_path / "y.tir", "mfeval").path, "mfeval")
    assert "DEFLECTION_LOAD_CURVE" in convert(read_tir(path), tmp_path / "z.tir", "chrono").path.read_text()
    path.write_bytes(path.read_bytes().replace(b"[SHAPE] ", b"[SHAPE]"))
    assert any("[SHAPE] loses its last characters" in found.text for found in errors_of(path, "mfeval"))


def test_lint_names_files_with_line_feeds_only(tire_of, tmp_path):
    tire_of("mf61").save(tmp_path / "x.tir")
    for host in HOSTS:
        noted = any("lines end with LF" in finding.text for finding in lint(tmp_path / "x.tir", host))
        assert noted == (host != "chrono" and "mf61" in HOSTS[host].dialects), host


def test_declarations_name_models_and_effects_that_exist():
    effects = set().union(*(model.effects for model in MODELS.values()))
    for host in HOSTS.values():
        assert set(host.dialects) <= set(MODELS)
        assert set(host.ignored) <= effects
        assert host.source


FAULTS = [
    ("PROPERTY_FILE_FORMAT = 'PAC2002'", "PROPERTY_FILE_FORMAT = 'USER'", "'USER': PAC2002 or MF_05 expected"),
    ("USE_MODE = 4", "USE_MODE = 14", "USE_MODE is '14': 3 or 4 expected"),
    ("FE_METHOD = ", "$ FE_METHOD ", "FE_METHOD is missing: NO expected"),
    ("FE_METHOD = 'NO'", "FE_METHOD = 'YES'", "FE_METHOD is 'YES': NO expected"),
    ("ANGLE = 'radians'", "ANGLE = 'degree'", "ANGLE is 'DEGREE'"),
    ("LONGVL = ", "$ LONGVL ", "LONGVL is missing"),
    ("PKX1 = ", "pkx1 = ", "'pkx1' is not in capital letters"),
    ("PKY2 = ", "PKY1 = 1.0 $ again\nPKY2 = ", "PKY1 is in line"),
    ("[SCALING_COEFFICIENTS]", f"$ {'x' * 200}\n[SCALING_COEFFICIENTS]", "characters: 200 at most"),
    ("VERTICAL_STIFFNESS = ", "VERTICAL_STIFFNESS = -1 $ ", "VERTICAL_STIFFNESS is -1: a positive value expected"),
]


@pytest.mark.parametrize(("correct", "wrong", "message"), FAULTS)
def test_every_fault_is_found(tire_of, tmp_path, correct, wrong, message):
    path = convert(tire_of("mf52"), tmp_path / "x.tir", "chrono").path
    text = path.read_text()
    assert text.count(f"\n{correct}") == 1, correct
    path.write_text(text.replace(f"\n{correct}", f"\n{wrong}"))
    errors = errors_of(path, "chrono")
    assert any(message in finding.text for finding in errors), errors
    if "missing" not in message and "positive" not in message:
        lines = path.read_text().splitlines()
        assert all(wrong.splitlines()[0].split(" ")[0] in lines[f.line - 1] for f in errors if message in f.text)


def test_an_added_effect_is_reported_and_stays_in_a_section_of_its_own(tire_of, tmp_path, capsys):
    tire = tire_of("mf52")
    values = {**tire.values, "TREF": 60.0, "TMU1": -0.002, "TMU2": 0.0}
    warm = replace(tire, values=values, effects={*tire.has, "temp_friction"})
    warm.save(tmp_path / "warm.tir")
    arguments = ["convert", str(tmp_path / "warm.tir"), "-o", str(tmp_path / "x.tir"), "--for", "chrono"]
    assert main(arguments) == 0
    assert "the added effect temp_friction is not evaluated" in capsys.readouterr().out
    assert "temp_friction" in read_tir(tmp_path / "x.tir").has
    assert main(["lint", str(tmp_path / "x.tir"), "--for", "chrono", "--quiet"]) == 0
    assert main(["lint", str(tmp_path / "warm.tir"), "--for", "chrono", "--quiet"]) == 1


@pytest.mark.parametrize("host", ["adams", "mfeval"])
def test_coefficients_that_a_host_lacks_are_replaced_by_a_fit_with_a_stated_error(tire_of, tmp_path, host):
    """MFeval has the coefficients of MF6.1 in MF5.2, too; PAC2002 would ignore them."""
    tire = replace(tire_of("mf52"), values={**tire_of("mf52").values, "PKY4": 1.8, "RBX3": 2.0})
    tire.save(tmp_path / "x.tir")
    errors = " ".join(finding.text for finding in errors_of(tmp_path / "x.tir", host))
    result = convert(tire, tmp_path / "y.tir", host)
    assert not errors_of(result.path, host)
    written = read_tir(result.path)
    assert (
        ("PKY4 is 1.8: the host lacks it" in errors) == ("RBX3 is 2" in errors) == result.refitted == (host == "adams")
    )
    if not result.refitted:
        np.testing.assert_array_equal(forces_of(written), forces_of(tire))
        return
    assert (written.values["PKY4"], written.values["RBX3"]) == (2.0, 0.0)
    assert 0.0 < max(result.errors.values()) < 0.02
    rows = {"alpha": np.linspace(-0.15, 0.15, 20), "Fz": 4000.0}
    difference = written.forces(**rows)["Fy"] - tire.forces(**rows)["Fy"]
    assert np.abs(difference).max() < 0.02 * np.abs(tire.forces(**rows)["Fy"]).max()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--for", "adam"], "unknown host 'adam': did you mean adams?"),
        (["--for", "chrono", "--model", "mf62"], "has no mf62: choose from mf52"),
    ],
)
def test_a_wrong_request_is_one_line(tmp_path, capsys, arguments, message):
    assert main(["convert", "trento_hoosier", "-o", str(tmp_path / "x.tir"), *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif("TIREFMU_HOSTS" not in os.environ, reason="fits a tire: make hosts")
def test_another_model_is_fitted_to_the_tire(trento, tmp_path):
    result = convert(trento, tmp_path / "x.tir", "chrono")
    assert (result.model, result.refitted) == ("mf52", True)
    assert not errors_of(result.path, "chrono")
    assert result.errors["Fx"] < 0.01
    assert result.errors["Fy"] < 0.01
    with pytest.raises(TirefmuError):
        convert(trento, tmp_path / "x.tir", "chrono", "mf96")


def test_a_file_is_sound_or_not_whatever_reads_it(tmp_path):
    tire = published("trento_hoosier")
    tire.save(tmp_path / "sound.tir")
    messages = lint(tmp_path / "sound.tir")
    assert {message.severity for message in messages} == {"note"}
    assert messages[-1].text.startswith("accepted as it is by")
    sizes = [("UNLOADED_RADIUS", tire["UNLOADED_RADIUS"] * factor) for factor in (1000.0, 37.0, 1e-3, 1e-2)]
    for name, value in [*sizes, ("FNOMIN", 0.3), ("PDY1", -tire["PDY1"]), ("PKX1", -tire["PKX1"])]:
        tire.with_values(**{name: value}).save(tmp_path / "fault.tir")
        assert errors_of(tmp_path / "fault.tir", None), name
