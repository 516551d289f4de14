"""The faults of `make mutants`: each has a line that occurs once, another one in its place, and tests that exist."""

from __future__ import annotations

import re
import tomllib

import pytest

from .rooms import ROOT, STUDIES

FAULTS = tomllib.loads((ROOT / "benchmarks" / "mutants.toml").read_text(encoding="utf-8"))["fault"]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault['file']}: {fault['old'].strip()[:40]}")
def test_a_fault_can_be_planted_and_its_tests_exist(fault):
    assert (ROOT / fault["file"]).read_text(encoding="utf-8").count(fault["old"]) == 1
    assert fault["new"] != fault["old"]
    for test in (entry for entry in fault["tests"] if entry.startswith("tests/")):
        path, _, name = test.partition("::")
        assert not name or f"def {name.partition('[')[0]}(" in (ROOT / path).read_text(encoding="utf-8")
        assert (ROOT / path).exists()


def test_the_number_of_faults_is_that_of_the_documentation():
    (stated,) = re.findall(r"plants (\d+) single-line faults", STUDIES["mutants"]["about"])
    assert int(stated) == len(FAULTS)
