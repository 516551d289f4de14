"""The proof inside an FMU: repeated with and without this program, and what it detects."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import runpy
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pandas as pd
import pytest
from lxml import etree

from tests.json_schemas import objections
from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.fmu import add_proof, check, export, repeat_proof

from .programs import unzipped, zipped

ROOT = "extra/org.fmi-standard.fmi-ls-ref/"
PROOF, STIMULI, REFERENCE = (ROOT + name for name in ("proof.json", "stimuli.csv", "reference.csv"))
TIR, DESCRIPTION, SCRIPT = "resources/tire.tir", "modelDescription.xml", "documentation/check_proof.py"
#: Of every kind of inputs and both versions; the last tire has relaxation, whose state starts at each segment.
PROVED = [("first", 2, "slip"), ("second", 3, "wheel"), ("brush", 3, "hub"), ("rolling", 3, "slip")]


@pytest.fixture(scope="module")
def table():
    """Return two segments of slips, loads and a measured side force."""
    n, rng = 90, np.random.default_rng(40)
    t = np.r_[0.02 * np.arange(n), 30.0 + 0.02 * np.arange(n)]
    frame = pd.DataFrame({"t": t, "kappa": 0.05 * np.sin(2.0 * t), "alpha": 0.15 * np.sin(3.0 * t)})
    frame = frame.assign(gamma=0.03 * np.cos(t), Fz=800.0 + 150.0 * np.sin(5.0 * t), V=12.0)
    return frame.assign(Fy=rng.normal(0.0, 500.0, 2 * n))


@pytest.fixture(scope="module")
def proved(fmus, table, tmp_path_factory):
    """Return FMUs with a proof by tire, version and kind of inputs; each is built on first use."""
    folder = tmp_path_factory.mktemp("proved")

    class Proved(dict):
        def __missing__(self, key):
            verdict = ["usable", "a <b> reason"]
            self[key] = add_proof(fmus[key], table, folder / f"{'_'.join(map(str, key))}.fmu", verdict=verdict)
            return self[key]

    return Proved()


def script(fmu, folder):
    """Run the program inside an FMU, without this package."""
    program = folder / "check_proof.py"
    program.write_bytes(unzipped(fmu)[SCRIPT])
    blocked = "import sys, runpy; sys.modules['tirefmu'] = None; runpy.run_path(sys.argv.pop(1), run_name='__main__')"
    return subprocess.run([sys.executable, "-c", blocked, program, fmu], capture_output=True, text=True, cwd=folder)


def numbers(content):
    names, *rows = csv.reader(io.StringIO(content.decode()))
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.parametrize("key", PROVED)
def test_a_proof_is_repeated_with_and_without_this_program(proved, key, tmp_path):
    result = repeat_proof(proved[key])
    assert (result.ok, result.rows, result.changed, result.problems) == (True, 180, (), ())
    assert result.difference < 1e-9
    assert objections("proof", json.loads(unzipped(proved[key])[PROOF])) == []
    run = script(proved[key], tmp_path)
    assert run.returncode == 0, run.stderr
    assert result.digest in run.stdout


def test_the_program_inside_has_about_forty_lines_of_code(proved):
    lines = unzipped(proved[PROVED[0]])[SCRIPT].decode().splitlines()
    assert len([line for line in lines if line.strip() and not line.startswith(("import", "from", '"""'))]) <= 40


def flipped(content):
    return content[: len(content) // 2] + bytes([content[len(content) // 2] ^ 1]) + content[len(content) // 2 + 1 :]


def raised(content):
    """Return a table with its last value raised by one."""
    head, _, last = content.decode().strip().rpartition(",")
    return f"{head},{float(last) + 1.0!r}\n".encode()


CHANGES = {
    "a bit of the binary": lambda files: {n: flipped(f) if n.startswith("binaries/") else f for n, f in files.items()},
    "a coefficient": lambda files: {**files, TIR: files[TIR].replace(b"PCY1", b"PCY2", 1)},
    "a start value": lambda files: {**files, DESCRIPTION: files[DESCRIPTION].replace(b'start="0.', b'start="9.', 1)},
    "a stimulus": lambda files: {**files, STIMULI: raised(files[STIMULI])},
    "a reference": lambda files: {**files, REFERENCE: raised(files[REFERENCE])},
    "a file more": lambda files: {**files, "resources/more.txt": b""},
    "a file less": lambda files: {n: f for n, f in files.items() if n != TIR},
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_file_is_detected_and_its_code_is_not_run(proved, change, tmp_path):
    files = unzipped(proved[PROVED[0]])
    changed = CHANGES[change](files)
    assert changed != files
    fmu = zipped(tmp_path / "changed.fmu", changed)
    result = repeat_proof(fmu)
    assert not result.ok
    assert (len(result.changed), result.rows) == (1, 0)
    if change in ("a bit of the binary", "a file less"):  # a process each; make proofs runs it for more
        assert script(fmu, tmp_path).returncode == 1
    assert main(["check", str(fmu), "--json", str(tmp_path / "check.json")]) == 1
    assert json.loads((tmp_path / "check.json").read_text())["changed"] == list(result.changed)


@pytest.mark.parametrize("name", [STIMULI, REFERENCE])
def test_another_table_with_right_digests_is_detected_by_the_simulation(proved, name, tmp_path):
    original = proved[PROVED[3]]
    files = unzipped(original)
    files[name] = raised(files[name])
    proof = json.loads(files[PROOF])
    proof["files"][name] = hashlib.sha256(files[name]).hexdigest()
    fmu = zipped(tmp_path / "another.fmu", {**files, PROOF: json.dumps(proof).encode()})
    result = repeat_proof(fmu)
    assert (result.ok, result.changed) == (False, ())
    assert 1e-9 < result.difference < 1.0
    assert result.digest != repeat_proof(original).digest
    assert script(fmu, tmp_path).returncode == 1


#: What the schema of FMI-LS-REF (fmi3LayeredStandardReferenceManifest.xsd, commit baf43cc) requires of a manifest. Name
#: and description are fixed there; libxml2 does not check this.
STANDARD = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
IDENTITY = {
    "name": "org.fmi-standard.fmi-ls-ref",
    "version": "1.0.0-alpha.1",
    "description": "Layered Standard providing information on related files included in an FMU.",
}
ROLES = {
    "document", "requirement", "specification", "model", "parameter", "system", "testcase", "experiment", "result",
    "method", "rationale", "report", "request", "delivery", "configuration", "signature", "meta-data", "other",
}  # fmt: skip


def test_the_files_of_the_manifest_are_in_the_fmu(proved):
    for key in PROVED:
        files = unzipped(proved[key])
        manifest = etree.fromstring(files[ROOT + "fmi-ls-manifest.xml"])
        assert manifest.tag == "fmiReferences"
        assert {key.removeprefix(STANDARD): value for key, value in manifest.items()} == IDENTITY
        assert {child.tag for child in manifest} == {"Related"}
        assert {related.get("role") for related in manifest.iter("Related")} <= ROLES
        assert all({"source", "type"} <= set(related.keys()) for related in manifest.iter("Related"))
        for related in manifest.iter("Related"):
            assert str(Path("/", ROOT, related.get("source")).resolve().relative_to("/")) in files
        assert b'href="fmi-ls-ref.html"' in files["documentation/index.html"]
        assert b"a &lt;b&gt; reason" in files["documentation/fmi-ls-ref.html"]
        assert fmpy.validation.validate_fmu(str(proved[key])) == []


def test_the_reference_of_hub_inputs_is_that_of_numpy(proved, tires, monkeypatch):
    """As in `make proofs` for every model; another tire differs."""
    benchmarks = Path(__file__).parents[2] / "benchmarks"
    monkeypatch.syspath_prepend(benchmarks)
    difference = runpy.run_path(str(benchmarks / "proofs.py"))["direct_difference"]
    brush = tires["brush"]
    assert difference(proved["brush", 3, "hub"], brush) < 1e-11
    assert difference(proved["brush", 3, "hub"], brush.with_values(CALPHA=1.001 * brush.values["CALPHA"])) > 1e-4


def test_a_proof_has_the_inputs_of_the_table_and_no_measured_output(proved, table):
    files = unzipped(proved[PROVED[0]])
    assert np.array_equal(numbers(files[STIMULI])["alpha"], table["alpha"])
    assert not any(repr(value).encode() in content for value in table["Fy"] for content in files.values())
    ((name, rows, rmse, unit, _),) = json.loads(files[PROOF])["agreement"]
    simulated = numbers(files[REFERENCE])["Fy"]
    assert (name, rows, unit) == ("Fy", 180, "N")
    assert rmse == pytest.approx(np.sqrt(np.mean((simulated - table["Fy"]) ** 2)))
    assert check(proved[PROVED[0]], table).channels[0].rmse == pytest.approx(rmse)


def test_a_wheel_carrier_follows_the_slips_of_the_table(proved, table):
    reference = numbers(unzipped(proved["brush", 3, "hub"])[REFERENCE])
    assert reference["gamma"] == pytest.approx(table["gamma"], abs=1e-12)
    assert reference["V_x"] == pytest.approx(table["V"])
    assert np.arctan2(reference["V_y"], reference["V_x"]) == pytest.approx(table["alpha"], abs=0.01)
    assert np.corrcoef(reference["Fz"], table["Fz"])[0, 1] > 0.99


def test_long_tables_are_thinned_within_their_segments(fmus, table, tmp_path):
    long = pd.concat([table.assign(t=table["t"] + 100.0 * i) for i in range(30)], ignore_index=True)
    result = repeat_proof(add_proof(fmus["first", 2], long, tmp_path / "long.fmu"))
    assert result.ok
    assert 1800 <= result.rows <= 2000


@pytest.mark.parametrize(
    "damage",
    [b"[", b"{}", b"[]", b"null", b'{"format": 2}', b'{"format": 1, "files": 3, "reference": ""}',
     b'{"format": 1, "files": {"\\u001b[2J": ""}, "reference": "\\u001b[2J"}', b"[" * 100_000],
)  # fmt: skip
def test_an_invalid_proof_is_one_line(proved, damage, tmp_path):
    fmu = zipped(tmp_path / "damaged.fmu", {**unzipped(proved[PROVED[0]]), PROOF: damage})
    try:
        text = str(repeat_proof(fmu))
    except FmuError as error:
        text = str(error)
        assert len(text.splitlines()) == 1
    assert "\x1b" not in text


INVALID_TABLES = (b"time,alpha\n0,nan\n", b"x\n1\n", b"time,nothing\n0,1\n")


@pytest.mark.parametrize(
    ("segments", "stimuli"),
    [
        *((segments, None) for segments in ([], [1], [0, 0], [0, 500], [0.0], "0", [[0]], [True])),
        *(([0], stimuli) for stimuli in INVALID_TABLES),
    ],
)
def test_invalid_segments_and_tables_are_refused(proved, segments, stimuli, tmp_path):
    files = unzipped(proved[PROVED[0]])
    files |= {STIMULI: stimuli} if stimuli else {}
    proof = {**json.loads(files[PROOF]), "segments": segments}
    proof["files"] = {n: hashlib.sha256(f).hexdigest() for n, f in files.items() if n != PROOF}
    with pytest.raises(FmuError, match="its proof is invalid"):
        repeat_proof(zipped(tmp_path / "invalid.fmu", {**files, PROOF: json.dumps(proof).encode()}))


def test_the_command_writes_and_repeats_a_proof(tmp_path, table, capsys):
    run, fmu, fit = tmp_path / "run.csv", tmp_path / "my.fmu", tmp_path / "fit.json"
    table.to_csv(run, index=False)
    fit.write_text('{"verdict": "usable with limits", "reasons": ["few loads"]}')
    assert main(["export", "trento_hoosier", "-o", str(fmu), "--proof", str(run), "--fit", str(fit)]) == 0
    assert json.loads(unzipped(fmu)[PROOF])["verdict"] == ["usable with limits", "few loads"]
    assert main(["check", str(fmu)]) == 0
    assert "verdict: proof repeated" in capsys.readouterr().out
    refused = [
        (["check", str(fmu), "--tolerance", "0.1"], "need a TABLE"),
        (["export", "trento_hoosier", "-o", str(tmp_path / "b.fmu"), "--fit", str(fit)], "--proof TABLE"),
        (["export", "trento_hoosier", "-o", str(tmp_path / "b.fmu"), "--proof", str(run), "--fit", str(run)], "fit"),
        (["export", "trento_hoosier", "-o", str(tmp_path / "b.tir"), "--kind", "ssv", "--proof", str(run)], "one FMU"),
    ]
    for arguments, message in refused:
        assert main(arguments) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / "b.fmu").exists()


def test_an_fmu_has_one_proof_or_none(proved, fmus, table):
    with pytest.raises(FmuError, match="has no proof"):
        repeat_proof(fmus["first", 2])
    with pytest.raises(FmuError, match="has a proof already"):
        add_proof(proved[PROVED[0]], table)


def test_array_inputs_are_refused(tires, compiler, table, tmp_path):
    fmu = export(tires["brush"], tmp_path / "arrays.fmu", inputs="hub", arrays=True)
    with pytest.raises(FmuError, match="scalar inputs"):
        add_proof(fmu, table)
