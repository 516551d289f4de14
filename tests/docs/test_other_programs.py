"""The page of other programs: each row has program, version and date; what it names exists; small statements hold."""

from __future__ import annotations

import ast
import re
from datetime import date

import numpy as np
import pandas as pd
import pytest

from tirefmu import convert, lint
from tirefmu.measurements import read_recording
from tirefmu.tires import read_tir

from ..rooms import ROOT

PAGE = (ROOT / "docs" / "other_programs.md").read_text(encoding="utf-8")
FINDINGS = ROOT / "findings"
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in PAGE.partition("## One file, many readers")[0].splitlines()
    if line.startswith("| ") and not line.startswith("| program")
]
TIRE = ROOT / "tests" / "golden" / "MagicFormula61_Parameters.tir"


def missing(named: str) -> bool:
    """Return whether a test `FILE::NAME` does not exist."""
    file, name = named.split("::")
    return name not in {node.name for node in ast.parse((ROOT / file).read_text("utf-8")).body if hasattr(node, "name")}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_a_row_has_program_version_and_date(row):
    program, version, day, seen, advice, test = row
    assert all((program, seen, advice))
    assert re.search(r"\d|newest stored state", version)
    assert date(2026, 11, 1) <= date.fromisoformat(day.removesuffix(", again"))
    assert test == "-" or not missing(test.strip("`"))


def test_the_check_of_names_can_fail():
    assert missing("tests/docs/test_other_programs.py::test_nothing")
    assert not missing("tests/docs/test_other_programs.py::test_the_check_of_names_can_fail")


def test_the_findings_are_listed_and_complete():
    scripts = {path.name for path in FINDINGS.glob("*.sh")}
    assert set(re.findall(r"`(\w+\.sh)`", (FINDINGS / "README.md").read_text("utf-8"))) == scripts
    assert set(re.findall(r"`findings/(\w+\.sh)`", PAGE)) == scripts
    for script in scripts:
        text = (FINDINGS / script).read_text("utf-8")
        for part in ("# Expected:", "# Happens:", "# Matters:", "# Source:", "# Guess written down", "set -e", "trap "):
            assert part in text, (script, part)


def test_the_load_factor_is_spelled_with_a_letter_or_a_digit(tmp_path):
    text = re.sub(r"(?m)^LFZO( *)= *1", r"LFZO\1= 0.9", TIRE.read_text("utf-8"))
    (tmp_path / "letter.tir").write_text(text, "utf-8")
    (tmp_path / "digit.tir").write_text(text.replace("LFZO", "LFZ0"), "utf-8")
    letter, digit = read_tir(tmp_path / "letter.tir"), read_tir(tmp_path / "digit.tir")
    assert letter.values["LFZO"] == digit.values["LFZO"] == 0.9


def test_a_file_without_fittyp_is_no_file_for_mfeval(tmp_path):
    path = tmp_path / "tire.tir"
    path.write_text(re.sub(r"(?m)^FITTYP.*\n", "", TIRE.read_text("utf-8")), "utf-8")
    assert any("FITTYP" in found.text for found in lint(path, "mfeval") if found.severity == "error")
    assert not any("FITTYP" in found.text for found in lint(TIRE, "mfeval"))


def test_chrono_has_neither_camber_nor_constant_rolling_resistance(tmp_path):
    path = convert(read_tir(TIRE.with_name("MagicFormula52_Parameters.tir")), tmp_path / "tire.tir", "chrono").path
    notes = " ".join(found.text for found in lint(path, "chrono") if found.severity == "note")
    assert "no constant rolling resistance" in notes
    assert "inclination has no effect on a vehicle" in notes


def test_angles_in_whole_numbers_of_eight_bits_keep_their_digits(tmp_path):
    degrees = np.arange(-90, 91, 7, dtype=np.int8)
    pd.DataFrame({"alpha [deg]": degrees, "Fz": 4000.0}).to_parquet(tmp_path / "table.parquet")
    read = read_recording(tmp_path / "table.parquet").table["alpha"]
    np.testing.assert_allclose(read, np.radians(degrees.astype(float)), rtol=1e-15)
