"""The findings on the measured recordings are those that were found by hand."""

from __future__ import annotations

import re

import pytest

from tirefmu.measurements import data_findings, read_recording


@pytest.fixture(scope="module")
def found(data_folder):
    return data_findings([read_recording(data_folder / f"{name}.mat") for name in ("cornering", "drivebrake")])


def test_nothing_serious_and_pressure_run_in_order(found):
    assert not [finding for finding in found if finding.serious]
    sources = [finding.text.split(":")[0] for finding in found if finding.kind == "run order"]
    assert sources == ["cornering.mat", "drivebrake.mat"]


def test_the_warm_up_of_drive_and_brake(found):
    (warm_up,) = [finding for finding in found if finding.kind == "warm-up"]
    assert warm_up.text.startswith("drivebrake.mat: ")
    rows = int(re.search(r"only after (\d+) of 76484 rows", warm_up.text)[1])
    assert 5000 < rows < 8500  # the forces settle after about 6,800 rows


def test_the_files_differ_in_stiffness_and_shift(found):
    (difference,) = [finding for finding in found if finding.kind == "stiffness between files"]
    worst = float(re.search(r"by \+([\d.]+) \+- [\d.]+ % at \d+ N, 0 deg, 83", difference.text)[1])
    assert 8.0 < worst < 16.0  # K_yalpha of fits to each file differs by 10.9 %
    assert "the zero of Fy by -0.2" in difference.text
