"""The FMU against data and against the direct evaluation of its tire."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, FmuError
from tirefmu.fmu import check, export
from tirefmu.fmu.comparison.check import largest_difference
from tirefmu.fmu.comparison.figures import draw_check
from tirefmu.measurements import Recording
from tirefmu.tires import convert_signs

from .programs import unzipped, zipped

DESCRIPTION = "modelDescription.xml"


@pytest.fixture(scope="module")
def table(tires):
    """Return two sweeps in ISO signs, a pause between them, with the forces of the first tire."""
    n = 120
    frame = pd.DataFrame(
        {
            "t": np.r_[0.01 * np.arange(n), 50.0 + 0.01 * np.arange(n)],
            "kappa": np.r_[np.zeros(n), np.linspace(-0.15, 0.15, n)],
            "alpha": np.r_[np.linspace(-0.2, 0.2, n), np.full(n, 0.05)],
            "gamma": 0.02,
            "Fz": np.tile([400.0, 700.0, 1000.0], 2 * n // 3),
            "V": 11.0,  # the model does not read it
        }
    )
    forces = tires["first"].forces(**{name: frame[name] for name in ("kappa", "alpha", "gamma", "Fz")})
    return frame.assign(**{name: forces[name] for name in forces})


@pytest.fixture
def fmu(fmus):
    return fmus["first", 3]


def test_a_tire_agrees_with_its_own_forces(fmus, fmi, table):
    result = check(fmus["first", fmi], table)
    assert result.ok
    assert result.problems == ()
    assert result.fmi_version == f"{fmi}.0"
    assert (result.rows, result.segments) == (240, 2)
    assert [c.name for c in result.channels] == ["Fx", "Fy", "Mz"]
    assert result.evaluation_difference < 1e-9
    for channel in result.channels:
        assert channel.measured == 240
        assert channel.r2 == pytest.approx(1.0, abs=1e-12)


def test_statistics_are_those_of_the_error(fmu, table):
    error = np.random.default_rng(3).normal(0.0, 20.0, len(table))
    measured = table["Fy"] + error
    result = check(fmu, table.drop(columns=["Fx", "Mz"]).assign(Fy=measured))
    (channel,) = result.channels
    assert channel.rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
    assert channel.r2 == pytest.approx(1.0 - np.sum(error**2) / np.sum((measured - measured.mean()) ** 2))
    assert channel.r2_uncentred == pytest.approx(1.0 - np.sum(error**2) / np.sum(measured**2))
    assert channel.relative_rmse == pytest.approx(channel.rmse / measured.abs().max())
    row = int(np.argmax(np.abs(error)))
    worst = channel.worst
    assert (worst.row, worst.t, worst.measured) == (row, table["t"][row], measured[row])
    assert worst.simulated == pytest.approx(table["Fy"][row])
    assert worst.condition == {name: table[name][row] for name in ("kappa", "alpha", "gamma", "Fz")}


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_conventions_lead_to_the_same_result(fmu, table, signs, tmp_path):
    reference = check(fmu, table).to_json()
    written = convert_signs(table, "iso", signs)
    written.to_csv(tmp_path / "table.csv", index=False)
    given = [Recording(written, signs, "table"), tmp_path / "table.csv", str(tmp_path / "table.csv")]
    for recording, named in zip(given, (None, signs, signs), strict=True):
        shown = check(fmu, recording, signs=named).to_json()
        assert shown["channels"] == reference["channels"]


def test_nan_in_an_output_is_not_measured(fmu, table):
    gappy = table.assign(Fy=table["Fy"].where(table.index % 3 == 0), Mz=np.nan)
    result = check(fmu, gappy)
    assert {c.name: c.measured for c in result.channels} == {"Fx": 240, "Fy": 80}


def test_missing_inputs_are_nominal(fmu, table, tires):
    forces = tires["first"].forces(alpha=table["alpha"])
    result = check(fmu, pd.DataFrame({"alpha": table["alpha"], "Fy": forces["Fy"], "Fz_set": 1.0}))
    assert result.ok
    assert result.segments == 1
    assert result.channels[0].r2 == pytest.approx(1.0)
    assert result.channels[0].worst.t is None


def test_a_difference_from_the_embedded_tire_is_detected(fmus, tires, table, tmp_path):
    # The binary of the first tire, the .tir file of one that differs in the ninth digit.
    almost = replace(tires["first"], values={**tires["first"].values, "LMUY": 1.0 + 3e-9})
    mixed = tmp_path / "mixed.fmu"
    other = export(almost, tmp_path / "other.fmu")
    tir = "resources/tire.tir"
    result = check(zipped(mixed, {**unzipped(fmus["first", 3]), tir: unzipped(other)[tir]}), table)
    assert 1e-9 < result.evaluation_difference < 1e-6
    assert not result.ok


def test_nan_is_a_difference(tires, table):
    """A NaN that the direct evaluation does not have must not pass as agreement."""
    direct = tires["first"].evaluate(table)[["Fx", "Fy", "Mz"]]
    simulated = direct.copy()
    assert largest_difference(direct, simulated) == 0.0
    simulated.loc[3, "Fy"] = np.nan
    assert largest_difference(direct, simulated) == np.inf


def test_an_fmu_without_a_tire_can_be_checked(fmus, table, tmp_path):
    files = unzipped(fmus["first", 2])
    bare = {name: text for name, text in files.items() if not name.startswith(("resources/", "sources/"))}
    result = check(zipped(tmp_path / "bare.fmu", bare), table)
    assert result.evaluation_difference is None
    assert "direct evaluation" not in str(result)


def test_tolerance_decides(fmu, table):
    data = table.assign(Fy=table["Fy"] + 50.0).drop(columns=["Fx", "Mz"])
    share = 50.0 / data["Fy"].abs().max()
    assert check(fmu, data).ok
    assert check(fmu, data, tolerance=1.01 * share).ok
    assert not check(fmu, data, tolerance=0.99 * share).ok


def test_an_exact_fmu_of_a_wrong_tire_is_stated_apart(fmu, table):
    right = check(fmu, table)
    assert (right.of_fmu.grade, right.of_tire.grade) == ("good", "good")
    wrong = check(fmu, table.assign(**{name: 0.6 * table[name] for name in ("Fx", "Fy", "Mz")}))
    assert wrong.ok
    assert (wrong.of_fmu.text, wrong.of_tire.grade) == (right.of_fmu.text, "bad")
    unfitted = replace(wrong, not_fitted=("Fx", "Fy", "Mz"))
    assert (unfitted.of_tire.grade, unfitted.ok) == ("limited", True)
    partly = replace(check(fmu, table.assign(Fx=table["Mz"])), not_fitted=("Fx",))
    assert partly.of_tire.grade == "good"
    assert partly.of_tire.text.endswith("; the tire was not fitted to Fx")
    refused = check(fmu, table.assign(Fy=1.1 * table["Fy"]), tolerance=0.01)
    assert (refused.of_fmu.grade, refused.of_tire.grade, refused.ok) == ("good", "bad", False)
    assert "Fy exceeds 0.01" in refused.of_tire.text


@pytest.mark.parametrize("columns", [{"kappa": 0.0}, {"kappa": 0.001}, {}], ids=["zero", "offset", "missing"])
def test_a_force_without_slip_does_not_judge_the_tire(fmu, tires, table, columns):
    held = table.drop(columns=["kappa", "Mz"]).assign(**columns)
    held["Fy"] = tires["first"].evaluate(held)["Fy"]
    result = check(fmu, held.assign(Fx=-30.0 + np.sin(np.arange(len(held)))))
    assert result.by_name["Fx"].r2 < -1.0  # bearing friction: nothing of the tire
    assert result.of_tire.grade == "good"
    assert result.of_tire.text.endswith("; without slip Fx shows nothing")
    alone = check(fmu, held.drop(columns="Fy").assign(Fx=-30.0 + np.sin(np.arange(len(held)))))
    assert alone.of_tire.grade == "limited"
    braked = check(fmu, held.assign(kappa=-0.1, Fx=-30.0 + np.sin(np.arange(len(held)))))
    assert braked.of_tire.grade == "bad"


def test_an_invalid_fmu_is_not_ok(fmus, table, tmp_path):
    files = unzipped(fmus["first", 3])
    files[DESCRIPTION] = re.sub(rb'<InitialUnknown valueReference="7"[^>]*/>', b"", files[DESCRIPTION])
    result = check(zipped(tmp_path / "odd.fmu", files), table)
    assert not result.ok
    assert "InitialUnknown" in result.problems[0]
    assert "invalid:" in str(result)


def test_json_and_text_have_the_same_content(fmu, table):
    result = check(fmu, table.assign(Mz=0.0))
    plain = json.loads(json.dumps(result.to_json(), allow_nan=False))
    assert plain["channels"]["Mz"]["r2"] is None  # nothing to explain
    assert plain["channels"]["Fy"]["rmse"] == result.channels[1].rmse
    text = str(result)
    for channel in result.channels:
        assert f"row {channel.worst.row}: " in text
        assert any(line.startswith(channel.name) for line in text.splitlines())
    assert list(result.simulated.columns) == ["Fx", "Fy", "Mz"]


def test_a_long_recording(fmu, data_folder):
    result = check(fmu, data_folder / "cornering.mat")
    assert result.rows > 50_000
    assert result.evaluation_difference < 1e-9


# ------------------------------------------------------------------ bad input


def test_nan_in_an_input(fmu, table):
    result = check(fmu, table.assign(alpha=table["alpha"].where(table.index != 7)))
    assert result.rows == len(table) - 1  # the row is excluded
    with pytest.raises(DataError, match="table: row 8: alpha is NaN"):
        check(fmu, table.assign(alpha=table["alpha"].where(table.index < 7)))


def test_a_table_of_other_things(fmu, table):
    with pytest.raises(DataError, match="no measured output"):
        check(fmu, table.drop(columns=["Fx", "Fy", "Mz"]))
    with pytest.raises(DataError, match=r"no measured output of the FMU \(Fx, Fy, Mz\)"):
        check(fmu, table.drop(columns=["Fx", "Fy", "Mz"]).assign(Mx=1.0))
    with pytest.raises(DataError, match=r"no input of the FMU \(kappa, alpha, gamma, Fz\)"):
        check(fmu, table[["t", "Fy"]])


def test_an_fmu_with_other_names(fmu, table, tmp_path):
    files, path = unzipped(fmu), tmp_path / "other.fmu"
    for causality, names in (("input", ("kappa", "alpha", "gamma", "Fz", "V")), ("output", ("Fx", "Fy", "Mz"))):
        text = files[DESCRIPTION]
        for name in names:
            text = text.replace(f'name="{name}"'.encode(), f'name="tire_{name}"'.encode())
        zipped(path, {**files, DESCRIPTION: text})
        with pytest.raises(FmuError, match=rf"other\.fmu: no {causality} .*: its {causality}s are tire_{names[0]}, "):
            check(path, table)


@pytest.mark.parametrize("inputs", ["hub", "hub-torque"])
def test_an_fmu_with_other_inputs_is_refused_with_the_remedy(fmus, table, inputs):
    with pytest.raises(FmuError, match=r"its inputs are the motion of the wheel, .*: export it with slip inputs"):
        check(fmus["first", 3, inputs], table)


def test_an_fmu_without_a_binary_for_this_machine(fmu, table, tmp_path):
    zipped(tmp_path / "bare.fmu", {DESCRIPTION: unzipped(fmu)[DESCRIPTION]})
    with pytest.raises(FmuError, match=r"bare\.fmu: cannot be loaded: Cannot find shared library binaries"):
        check(tmp_path / "bare.fmu", table)


def test_a_refused_row_is_named(fmus, table, tmp_path):
    # A description that exchanges the output Fx and the input kappa.
    files = unzipped(fmus["first", 3])
    for name, old, new in ((b"kappa", b"1", b"5"), (b"Fx", b"5", b"1")):
        text = b'"%s" valueReference="%s"'
        files[DESCRIPTION] = files[DESCRIPTION].replace(text % (name, old), text % (name, new))
    zipped(tmp_path / "odd.fmu", files)
    with pytest.raises(FmuError, match=r"row 0: fmi3SetFloat64 failed .*: Fx cannot be set"):
        check(tmp_path / "odd.fmu", table)


def test_figures_show_every_measured_channel(fmus, tires, tmp_path):
    alpha = np.linspace(-0.2, 0.2, 40)
    table = pd.DataFrame({"t": np.r_[np.arange(20), 100 + np.arange(20)] * 0.01, "alpha": alpha, "Fz": 700.0})
    forces = tires["first"].forces(alpha=alpha, Fz=700.0)
    table["Fy"], table["Mz"] = forces["Fy"] + 5.0, np.where(alpha > 0.0, forces["Mz"], np.nan)
    result = check(fmus["first", 3], table)
    assert result.starts == (0, 20)
    np.testing.assert_array_equal(result.recording["t"], table["t"])
    drawn = draw_check(result, tmp_path / "figures", prefix="first_")
    assert [path.name for path in drawn] == ["first_Fy.png", "first_Mz.png"]
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == sorted(path.name for path in drawn)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)
    (tmp_path / "file").write_text("", encoding="ascii")
    with pytest.raises(FmuError, match="file: cannot be written"):
        draw_check(result, tmp_path / "file")
