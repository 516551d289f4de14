"""A measured drive of a small car, of which only the pose is logged; skipped without its folder in TIREFMU_DATA."""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

import tirefmu
from tirefmu.driving.inputs.car import read_car

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import dart


def test_friction_of_a_slippery_floor_is_lower_and_its_stiffness_is_not(data_folder):
    log = pd.read_csv(data_folder / "dart" / dart.SLIPPERY)
    log = log[log["vicon time"] > log["vicon time"].iloc[0] + 85.0]  # the fastest part
    tires = {axle: dart.authors_tire(axle) for axle in dart.AUTHORS}
    answer = tirefmu.drive(log, vehicle=read_car(dart.CAR), tire=tires["front"], rear=tires["rear"])
    assert answer.ok
    assert {(finding.axle, finding.effect) for finding in answer.verdict.tires} <= {
        ("front", "friction is lower"), ("rear", "friction is lower"),
    }  # fmt: skip
    for axle, (D, _, _) in dart.AUTHORS.items():
        assert answer.factors[axle]["LMUY"].low < 0.41 / D < answer.factors[axle]["LMUY"].high < 0.75
