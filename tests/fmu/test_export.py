"""Writing the file: its bytes, its contents, and errors."""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path

import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import export
from tirefmu.fmu.description.documentation import license_of
from tirefmu.fmu.packaging.export import c_identifier, contents
from tirefmu.tires import published, read_tir

from .programs import unzipped

ROOT = Path(__file__).parents[2]


@pytest.fixture
def tire(tires):
    return tires["first"]


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "fresh cache"))


def test_equal_tires_give_equal_bytes(fmus, fmi, tire, tmp_path, fresh_cache):
    # Compiled again in another folder.
    again = export(tire, tmp_path / f"first_{fmi}.fmu", fmi=fmi)
    assert again.read_bytes() == fmus["first", fmi].read_bytes()


@pytest.mark.parametrize(("kind", "fmi"), [("native", 2), ("native", 3), ("pythonfmu", 2)])
def test_the_signs_of_a_tire_change_no_value(kind, fmi):
    tire = published("trento_hoosier")
    shown = []
    for each in (tire, tire.in_signs("iso")):
        files = contents(each, fmi, "hoosier", kind)
        page = files["documentation/index.html"].replace(b", converted from adapted-sae signs", b"")
        shown.append((page, re.findall(rb' start="[^"]*"', files["modelDescription.xml"])))
    assert shown[0] == shown[1]


def test_the_code_of_a_model_is_compiled_once(tires, tmp_path, fresh_cache, compiler):
    """So is all of the wrapper that does not contain the values of a tire."""
    stored = []
    for name in ("first", "second"):
        export(tires[name], tmp_path / f"{name}.fmu")
        stored.append({path.name for path in (tmp_path / "fresh cache").iterdir()})
    assert sum(name.startswith("fmu-mf96") for name in stored[0]) == 2  # for speed, and for size
    assert stored[0] < stored[1]
    assert len(stored[1] - stored[0]) == 1  # the library


def test_contents(fmus, fmi, tire):
    with zipfile.ZipFile(fmus["first", fmi]) as archive:
        names = archive.namelist()
        assert archive.testzip() is None
        page = archive.read("documentation/index.html").decode()
        notice = archive.read("documentation/licenses/fmi-headers.txt").decode()
        infos = archive.infolist()
    assert names == sorted(names)
    assert {info.date_time for info in infos} == {(1980, 1, 1, 0, 0, 0)}
    assert {"modelDescription.xml", "resources/tire.tir", "sources/model_config.h", "sources/mf96.c"} <= set(names)
    assert ("sources/buildDescription.xml" in names) == (fmi == 3)
    assert not any(Path(name).name.startswith("fmi") and name.endswith(".h") for name in names)
    assert "Redistributions in binary form must reproduce" in notice
    for name in (*tire.inputs, *tire.outputs, "PDY1"):
        assert f"<td>{name}</td>" in page
    (binary,) = (name for name in names if name.startswith("binaries/"))
    assert Path(binary).stem == f"first_{fmi}"


def test_contains_the_tire(fmus, fmi, tire, tmp_path):
    with zipfile.ZipFile(fmus["first", fmi]) as archive:
        embedded = read_tir(archive.extract("resources/tire.tir", tmp_path))
    assert (embedded.model, embedded.signs, embedded.name) == (tire.model, "iso", tire.name)
    assert embedded.parameters().tolist() == tire.parameters().tolist()


def test_it_contains_no_name_of_this_machine(fmus):
    for key in (("first", 2), ("first", 3, "hub-torque")):
        for name, content in unzipped(fmus[key]).items():
            assert str(ROOT).encode() not in content, name
            assert str(Path.home()).encode() + b"/" not in content, name


def test_the_binary_shows_its_functions_of_the_standard_only(fmus, fmi, tmp_path):
    if not sys.platform.startswith("linux"):
        pytest.skip("reads the symbols of a Linux binary")
    (content,) = (text for name, text in unzipped(fmus["first", fmi]).items() if name.startswith("binaries/"))
    assert f"fmi{fmi}DoStep".encode() in content
    assert b"mf96_forces" not in content
    assert b"instance_step" not in content


def test_license_is_the_projects():
    assert (ROOT / "LICENSE").read_text(encoding="utf-8") == license_of("tirefmu")


@pytest.mark.parametrize("name", ["tire", "Tire_2", "2nd", "Ü-Reifen 13''", "double", "", "_x", "a.b.c"])
def test_identifiers_are_c(name):
    assert re.fullmatch("[A-Za-z][A-Za-z0-9_]*", c_identifier(name))
    assert c_identifier(c_identifier(name)) == c_identifier(name)
    assert c_identifier(name) != "double"


# ------------------------------------------------------------------ errors


def fails(tire, path, message, **options):
    """Assert a one-line error and that no file remains."""
    before = sorted(path.parent.iterdir()) if path.parent.is_dir() else []
    with pytest.raises(FmuError, match=message) as caught:
        export(tire, path, **options)
    assert "\n" not in str(caught.value)
    assert (sorted(path.parent.iterdir()) if path.parent.is_dir() else []) == before


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("t.fmu", {"fmi": 1}, "FMI 1 is not supported: supported are 2 and 3"),
        ("t.fmu", {"inputs": "motion"}, "inputs 'motion' are unknown: known are slip, wheel"),
        ("t.fmu", {"inputs": "hub", "axes": "sae"}, "ISO axes only"),
        ("t.fmu", {"kind": "julia"}, "kind 'julia' is unknown: known kinds are native, pythonfmu"),
        ("t.fmu", {"axes": "adapted-sae"}, "axes 'adapted-sae' are unknown: known are iso, sae"),
        ("no/t.fmu", {}, r"cannot be written \(No such file"),
        ("folder.fmu", {}, "cannot be written"),
    ],
)
def test_wrong_options_and_paths(compiler, tire, tmp_path, name, options, message):
    (tmp_path / "folder.fmu").mkdir()
    fails(tire, tmp_path / name, message, **options)


def test_a_compiler_that_fails_is_quoted_and_changes_no_file(tire, tmp_path, monkeypatch, compiler, fresh_cache):
    path = tmp_path / "t.fmu"
    path.write_bytes(b"precious")
    (tmp_path / "fresh cache").mkdir()
    monkeypatch.setenv("CC", f"{compiler[0]} --no-such-option")
    fails(tire, path, "no-such-option")
    assert path.read_bytes() == b"precious"
