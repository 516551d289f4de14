"""A drive of a known car on known tires: factors, forces, tires and files; refusals of logs that contradict the car."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import road

import tirefmu
from tests.json_schemas import check_file, objections
from tirefmu.boundary.errors import DataError
from tirefmu.cli import main
from tirefmu.driving.report import write_drive
from tirefmu.tires import read_tir


def test_the_factors_are_those_of_the_truth(answer):
    truth = {"front": (0.8, 0.9), "rear": (0.84, 1.0)}
    for axle, values in truth.items():
        for name, value in zip(("LMUY", "LKY"), values, strict=True):
            factor = answer.factors[axle][name]
            assert factor.determined, (axle, name)
            assert factor.low < value < factor.high
            assert factor.value == pytest.approx(value, rel=0.05)
    assert answer.ok
    assert not answer.verdict.car
    assert {finding.effect for finding in answer.verdict.tires} >= {"friction is lower"}


def test_longitudinal_factors_are_not_determined(answer):
    assert not any(answer.factors[axle][name].determined for axle in ("front", "rear") for name in ("LMUX", "LKX"))
    assert answer.scaled["front"].values["LMUX"] == answer.tires["front"].values["LMUX"]


def test_a_delay_is_estimated(answer):
    entries = answer.to_json()["car"]["entries"]
    assert entries["delay"]["value"] == pytest.approx(-0.015, abs=0.004)


def test_the_simulated_vehicle_is_closer_on_the_new_tires(answer):
    for name, before in answer.before.rms.items():
        assert answer.after.rms[name] < 0.7 * before, name


def test_a_drive_too_short_to_simulate_has_an_answer_without_errors(answer, tmp_path):
    none = replace(answer.before, rms=dict.fromkeys(answer.before.rms, float("nan")))
    content = replace(answer, before=none).to_json()
    assert set(content["simulation"]["before"].values()) == {None}
    assert objections("drive", json.loads(json.dumps(content, allow_nan=False))) == []
    write_drive(replace(answer, before=none), tmp_path / "report.html")
    assert '<td class="n">-</td>' in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_forces_are_a_recording(answer, tmp_path):
    written = answer.save(tmp_path)
    recording = tirefmu.read_recording(written[0])
    assert recording.measured() == ("Fy",)  # Fx over kappa would be the tire's own curve
    assert len(recording.segments()) == 2
    front = answer.wheels[answer.wheels["axle"] == 1]
    forces = answer.scaled["front"].forces(kappa=front["kappa"], alpha=front["alpha"], Fz=front["Fz"], code="numpy")
    assert np.sqrt(np.mean((forces["Fy"] - front["Fy"]) ** 2)) < 0.05 * front["Fy"].abs().max()
    assert read_tir(written[1]).values["LMUY"] == pytest.approx(answer.factors["front"]["LMUY"].value)


def test_without_a_peak_friction_is_not_determined(car, tire):
    truth = road.Truth({axle: dict.fromkeys(("LMUX", "LMUY", "LKX", "LKY"), 1.0) for axle in ("front", "rear")}, {})
    logs, _ = road.made_drives([truth], ["sweep"], [False], seed=2, seconds=10.0)
    factors = tirefmu.drive(logs[0], vehicle=car, tire=tire).factors
    for axle in ("front", "rear"):
        assert not factors[axle]["LMUY"].determined
        assert factors[axle]["LMUY"].low < 1.0 < factors[axle]["LMUY"].high


REFUSED = {
    "no steering": (lambda log: log.assign(steer=0.0), "steer hardly changes"),
    "no channel": (lambda log: log.drop(columns="steer"), "no channel steer"),
    "wrong sign": (lambda log: log.assign(steer=-log["steer"]), "opposite signs"),
    "degrees called radians": (lambda log: log.assign(yaw_rate=np.degrees(log["yaw_rate"])), "yaw_rate"),
    "radians called degrees": (lambda log: log.rename(columns={"steer": "steer [deg]"}), "radians and degrees"),
    "in g": (lambda log: log.assign(ay=log["ay"] / 9.81), "ay is"),
    "speed 0": (lambda log: log.assign(speed=0.0), "does not move"),
    "another log": (lambda log: log.assign(yaw_rate=np.roll(log["yaw_rate"], 300)), "car.toml"),
    "time": (lambda log: log.assign(t=log["t"].to_numpy()[::-1]), "time decreases"),
}


@pytest.mark.parametrize(("change", "message"), REFUSED.values(), ids=REFUSED)
def test_a_log_that_contradicts_the_car_is_refused(change, message, log, car, tire):
    with pytest.raises(DataError, match=re.escape(message)) as refusal:
        tirefmu.drive(change(log), vehicle=car, tire=tire)
    assert len(str(refusal.value).splitlines()) == 1


def test_the_command_writes_the_answer(log, tire, tmp_path, capsys):
    log[:900].rename(columns={"ay": "AccY"}).assign(AccY=log["ay"] / 9.80665).to_csv(tmp_path / "log.csv", index=False)
    tire.save(tmp_path / "front.tir")
    lines = [f"[{name}]\n" + "\n".join(f"{k} = {v}" for k, v in of.items()) for name, of in road.car_content().items()]
    (tmp_path / "car.toml").write_text("\n".join(lines), encoding="utf-8")
    given = [str(tmp_path / "log.csv"), "--vehicle", str(tmp_path / "car.toml"), "--tire", str(tmp_path / "front.tir")]
    assert main(["drive", *given, "--columns", "ay=AccY [g]", "-o", str(tmp_path / "answer")]) == 0
    written = {path.name for path in (tmp_path / "answer").iterdir()}
    assert written == {"drive.json", "wheels.csv", "front.tir", "rear.tir", "report.html"}
    check_file("drive", tmp_path / "answer" / "drive.json")
    content = json.loads((tmp_path / "answer" / "drive.json").read_text(encoding="utf-8"))
    assert {"factors", "found", "unknown", "car", "simulation"} <= content.keys()
    assert set(content["factors"]["rear"]["LKY"]) >= {"value", "low", "high", "determined"}
    assert set(content["simulation"]["after"]) == {"yaw_rate", "ay", "vy"}
    assert main(["drive", *given, "-o", str(tmp_path / "other")]) == 2
    assert "no channel ay" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()
