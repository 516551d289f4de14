"""A measured drive of a small car, of which only the pose is logged; skipped without its folder in TIREFMU_DATA."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import tirefmu
from tirefmu.applications.driving.inputs.car import read_car

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import dart


@pytest.mark.slow
def test_friction_of_a_slippery_floor_is_lower_and_its_stiffness_is_not(data_folder):
    name, first = dart.SLIPPERY[0]
    log = dart.recorded(data_folder / "dart" / name, first)
    tires = {axle: dart.authors_tire(axle) for axle in dart.AUTHORS}
    answer = tirefmu.drive(log, vehicle=read_car(dart.CAR), tire=tires["front"], rear=tires["rear"])
    assert answer.ok
    assert {finding.effect for finding in answer.verdict.tires} == {"friction is lower"}
    for axle, (D, _, _) in dart.AUTHORS.items():
        assert answer.factors[axle]["LMUY"].low < 0.41 / D < answer.factors[axle]["LMUY"].high < 0.75
