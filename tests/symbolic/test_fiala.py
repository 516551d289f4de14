"""The Fiala tire: its equations, its limits, and every feature of a model of the package."""

from __future__ import annotations

from math import atan, copysign, hypot, pi, tan

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting import fit
from tirefmu.measurements import Recording
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.code import code_for
from tirefmu.tires.property_file.names import not_given
from tirefmu.tires.property_file.reading import read_tir_with_notes

LOAD = 3000.0
VALUES = {
    "FNOMIN": LOAD, "UNLOADED_RADIUS": 0.31, "WIDTH": 0.15, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 9e4, "CALPHA": 6e4,
    "UMIN": 0.7, "UMAX": 1.1, "ROLLING_RESISTANCE": 0.004,
}  # fmt: skip
TIRE = Tire("fiala", VALUES)
NOISE = {"Fx": 20.0, "Fy": 20.0, "Mz": 1.0, "My": 0.2}


def by_the_book(kappa, alpha, Fz, V):
    """Return Fx, Fy, Mz, My in ISO as the Adams help and Chrono's source state them, branch by branch."""
    c = VALUES
    U = c["UMAX"] - (c["UMAX"] - c["UMIN"]) * min(1.0, hypot(kappa, tan(alpha)))
    if abs(kappa) < abs(U * Fz / (2 * c["CSLIP"])):
        Fx = c["CSLIP"] * kappa
    else:
        Fx = copysign(U * Fz - abs((U * Fz) ** 2 / (4 * abs(kappa) * c["CSLIP"])), kappa)
    H = 1 - c["CALPHA"] * abs(tan(alpha)) / (3 * U * Fz)
    if abs(alpha) > atan(3 * U * Fz / c["CALPHA"]):
        Fy, Mz = copysign(U * Fz, -alpha), 0.0
    else:
        Fy = copysign(U * Fz * (1 - H**3), -alpha)
        Mz = copysign(U * Fz * c["WIDTH"] * (1 - H) * H**3, alpha)
    return Fx, Fy, Mz, copysign(c["ROLLING_RESISTANCE"] * Fz, -V)


@pytest.fixture(scope="module")
def rows():
    """Return kappa, alpha, Fz and V, none within 1e-4 of a change of branch."""
    rng = np.random.default_rng(0)
    kappa, alpha = rng.uniform(-1.0, 1.0, 300) ** 3 * 1.5, rng.uniform(-1.0, 1.0, 300) ** 3
    drawn = np.array([kappa, alpha, rng.uniform(300.0, 6000.0, 300), rng.choice([-8.0, 20.0], 300)])
    answer = TIRE.evaluate(pd.DataFrame(dict(zip(TIRE.inputs, drawn, strict=True))))
    near = np.array(
        [np.abs(kappa) - answer["kappa_crit"], np.abs(alpha) - answer["alpha_crit"], np.hypot(kappa, np.tan(alpha)) - 1]
    )
    distant = drawn[:, (np.abs(near) > 1e-4).all(axis=0)]
    assert distant.shape[1] > 250
    return distant


def bench(tire, n=400, alpha=0.3, **settings):
    """Return a recording of slow sweeps at four loads, in ISO, with noise. `alpha`: the largest slip angle."""
    t = np.linspace(0.0, 40.0, n)
    slips = {"kappa": 0.3 * np.sin(1.3 * t), "alpha": alpha * np.sin(2.1 * t + 0.4)}
    table = pd.DataFrame({"t": t, **slips, "Fz": np.repeat([1500.0, 3000.0, 4500.0, 2200.0], n // 4), "V": 15.0})
    forces = tire.evaluate(table, **settings)[list(NOISE)]
    noise = np.random.default_rng(0).normal(size=forces.shape) * list(NOISE.values())
    return pd.concat([table, forces + noise], axis=1)


def test_it_computes_the_published_equations(rows):
    expected = np.array([by_the_book(*row) for row in rows.T]).T
    forces = TIRE.forces(**dict(zip(TIRE.inputs, rows, strict=True)))
    for name, values in zip(TIRE.outputs, expected, strict=True):
        np.testing.assert_allclose(forces[name], values, rtol=1e-12, atol=1e-9, err_msg=name)


def test_slopes_at_zero_are_the_stiffnesses():
    point = np.array([[0.0], [0.0], [LOAD], [10.0]])
    for code in (code_for(TIRE.symbolic_model, language) for language in ("numpy", "c")):
        slopes = code.jacobian_inputs(point, TIRE.parameters())[0, :, :2]
        assert slopes[0].tolist() == [VALUES["CSLIP"], 0.0]
        assert slopes[1].tolist() == pytest.approx([0.0, -VALUES["CALPHA"]])
        # The aligning moment is the side force at a trail of a third of the width.
        assert slopes[2].tolist() == pytest.approx([0.0, VALUES["CALPHA"] * VALUES["WIDTH"] / 3])


@pytest.mark.parametrize("umin", [0.0, 0.7])
@pytest.mark.parametrize(
    "point", [(0.0, 0.0, 0.0), (0.1, -0.2, 0.0), (0.0, 0.0, LOAD), (1.0, 0.0, LOAD), (0, pi / 2, LOAD)]
)
def test_jacobians_are_finite_where_branches_meet(umin, point):
    tire = Tire("fiala", {**VALUES, "UMIN": umin})
    column = np.array([[*point, 0.0]]).T
    for language in ("numpy", "c", "batch"):
        code = code_for(tire.symbolic_model, language)
        for routine in ("forces", "jacobian_inputs", "jacobian_parameters"):
            assert np.isfinite(getattr(code, routine)(column, tire.parameters())).all(), (language, routine)


ADAMS = """[MDI_HEADER]
FILE_TYPE = 'tir'
[UNITS]
LENGTH = 'mm'
FORCE = 'newton'
ANGLE = 'degree'
MASS = 'kg'
TIME = 'sec'
[MODEL]
PROPERTY_FILE_FORMAT = 'FIALA'
USE_MODE = 2.0
[DIMENSION]
UNLOADED_RADIUS = 310.0
WIDTH = 240.0
ASPECT_RATIO = 0.5
[PARAMETER]
VERTICAL_STIFFNESS = 310.0
VERTICAL_DAMPING = 3.1
ROLLING_RESISTANCE = 1.5
CSLIP = 80000.0
CALPHA = 900.0
CGAMMA = 10.0
UMIN = 0.8
UMAX = 1.0
"""
IN_SI = {
    "UNLOADED_RADIUS": 0.31, "WIDTH": 0.24, "VERTICAL_STIFFNESS": 3.1e5, "VERTICAL_DAMPING": 3100.0,
    "ROLLING_RESISTANCE": 1.5e-3, "CSLIP": 8e4, "CALPHA": 900.0 * 180.0 / pi, "CGAMMA": 10.0 * 180.0 / pi,
    "UMIN": 0.8, "UMAX": 1.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("lengths", "read"),
    [
        ("", (0.0, 0.0)),
        ("RELAX_LENGTH_X = 0.05\nRELAX_LENGTH_Y = 0.15\n", (0.05, 0.15)),  # in metres, as in Adams' samples
        ("REL_LEN_LON = 50\nREL_LEN_LAT = 150\n", (0.05, 0.15)),
    ],
)
def test_a_property_file_of_adams_is_read_in_si_and_survives_a_round_trip(lengths, read, tmp_path):
    (tmp_path / "adams.tir").write_text(ADAMS + lengths, encoding="utf-8")
    reading = read_tir_with_notes(tmp_path / "adams.tir")
    tire, notes = reading.tire, reading.notes
    assert tire.model == "fiala"
    assert {name: tire.values[name] for name in IN_SI} == pytest.approx(IN_SI, rel=1e-14)
    assert (tire.values["REL_LEN_LON"], tire.values["REL_LEN_LAT"]) == pytest.approx(read)
    assert tire.lags == bool(lengths)
    assert any("relax_lon" in note for note in notes) == bool(lengths)
    # The file has no nominal load: one is assumed and reported.
    assert tire.values["FNOMIN"] == 4000.0
    assert "FNOMIN" in not_given(tire)
    tire.save(tmp_path / "adams.tir")
    text = (tmp_path / "adams.tir").read_text(encoding="utf-8")
    assert all(line in text for line in ("PROPERTY_FILE_FORMAT = 'FIALA'", "USE_MODE = 2", "ASPECT_RATIO = 0.5"))
    assert "FITTYP" not in text
    assert read_tir(tmp_path / "adams.tir") == tire


@pytest.mark.parametrize(("signs", "start"), [("iso", None), ("adapted-sae", None), ("iso", "features")])
def test_a_fit_finds_it(signs, start):
    table = bench(TIRE)
    table[["Fy", "Mz", "My"]] *= 1 if signs == "iso" else -1
    nominal = {"Fz0": LOAD, "R0": VALUES["UNLOADED_RADIUS"]}
    result = fit([Recording(table, signs, "b.csv")], "fiala", nominal=nominal, start=start, screening=False)
    assert result.ok, result.reason
    for name in ("WIDTH", "CSLIP", "CALPHA", "UMIN", "UMAX", "ROLLING_RESISTANCE"):
        assert result.tire.values[name] == pytest.approx(VALUES[name], rel=0.01), name


@pytest.mark.parametrize("unmeasured", [[], ["Fx"], ["Fy", "Mz"]])
def test_friction_that_grows_with_slip_is_fitted_on_request_only(unmeasured):
    growing = Tire("fiala", {**VALUES, "UMIN": 1.4})
    table = bench(growing, alpha=0.0 if "Fy" in unmeasured else 0.3)  # without Fy a swept alpha is refused
    recording = Recording(table.drop(columns=unmeasured), "iso", "bench.csv")
    bounded, free = (
        fit([recording], "fiala", nominal={"Fz0": LOAD, "R0": 0.31}, screening=False, without_constraints=left_out)
        for left_out in ((), ("signs:mu_x_fall", "signs:mu_y_fall"))
    )
    assert free.tire.values["UMIN"] == pytest.approx(1.4, rel=0.02)
    assert bounded.tire.values["UMIN"] <= bounded.tire.values["UMAX"] * (1 + 1e-6)
