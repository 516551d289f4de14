"""A tire as a Python object: invalid arguments, defaults, and evaluation."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, TireError, UnknownName
from tirefmu.tires import PUBLISHED, Forces, Tire, convert_signs, evaluation, published

SMALL = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3}


@pytest.fixture(scope="module")
def hoosier():
    return published("trento_hoosier")


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"model": "mf69"}, UnknownName, "unknown model 'mf69': did you mean mf96?"),
        ({"effects": ["camber_trust"]}, UnknownName, "effect of mf96 'camber_trust': did you mean camber_thrust?"),
        ({"values": {**SMALL, "PCYI": 1.0}}, UnknownName, "coefficient of mf96 'PCYI': did you mean PCY1?"),
        ({"values": {**SMALL, "pcy1": 1.0}}, UnknownName, "coefficient of mf96 'pcy1': did you mean PCY1?"),
        ({"values": {**SMALL, "PCY1": math.nan}}, TireError, "PCY1 is nan: a coefficient is a finite number"),
        ({"values": {**SMALL, "PCY1": math.inf}}, TireError, "PCY1 is inf: a coefficient is a finite number"),
        ({"values": {**SMALL, "PCY1": "1,3"}}, TireError, "PCY1 is '1,3': a coefficient is a finite number"),
        ({"values": {**SMALL, "PCY1": None}}, TireError, "PCY1 is None: a coefficient is a finite number"),
        ({"values": {"UNLOADED_RADIUS": 0.3}}, TireError, "a tire needs FNOMIN (nominal load F_z0, N)"),
        ({"values": {"FNOMIN": 1e3}}, TireError, "a tire needs UNLOADED_RADIUS (free radius R_0, m)"),
        ({"signs": "sae"}, UnknownName, "sign convention of a tire 'sae'"),
        ({"about": {"two words": "x"}}, TireError, "about 'two words': a key is a word"),
        ({"ranges": {"Fz": (2000.0, 100.0)}}, TireError, "the range of Fz is crossed: 2000.0 to 100.0"),
        ({"ranges": {"Fz": (math.nan, 100.0)}}, TireError, "the range of Fz is crossed"),
        ({"ranges": {"gama": (0, 1)}}, UnknownName, "unknown input 'gama': did you mean gamma?"),
    ],
)
def test_invalid_arguments(change, error, message):
    with pytest.raises(error) as caught:
        Tire(**{"model": "mf96", "values": SMALL, **change})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_values_are_filled_in_and_listed():
    tire = Tire("mf96", {**SMALL, "PDY1": 1.2})
    assert set(tire.defaulted) == tire.symbolic_model.coefficients.keys() - {*SMALL, "PDY1"}
    assert (tire.values["PDY2"], tire.values["LMUY"], tire.values["PCX1"]) == (0.0, 1.0, 1.6)
    assert Tire("mf96", tire.values).defaulted == ()


def test_a_tire_of_defaults_pulls_the_right_way_in_both_conventions():
    """The generic starts are written in adapted SAE; in ISO a normal tire has Fy < 0 for alpha > 0."""
    iso, sae = Tire("mf96", SMALL), Tire("mf96", SMALL, signs="adapted-sae")
    assert iso.values["PKY1"] == -sae.values["PKY1"] < 0
    assert iso.forces(alpha=0.05).Fy == -sae.forces(alpha=0.05).Fy < 0
    assert sae.in_signs("iso") == iso
    assert sae.in_signs("iso").defaulted == sae.defaulted


def test_mirrored_zeros_are_positive():
    mirrored = Tire("mf96", SMALL).in_signs("adapted-sae")
    assert all(math.copysign(1.0, value) == 1.0 for value in mirrored.values.values() if value == 0)


def test_a_tire_is_copied_and_pickled(hoosier):
    assert copy.deepcopy(hoosier) == hoosier
    assert pickle.loads(pickle.dumps(hoosier)) == hoosier


def test_forces_broadcast(hoosier):
    forces = hoosier.forces(alpha=np.linspace(-0.2, 0.2, 5)[:, None], Fz=[200.0, 700.0, 1120.0], gamma=0.02)
    assert forces.Fy.shape == forces["Mz"].shape == (5, 3)
    assert forces.Fy[3, 1] == hoosier.forces(alpha=0.1, Fz=700.0, gamma=0.02).Fy


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
def test_forces_of_scalars_lists_and_nothing(hoosier, code):
    assert hoosier.forces(alpha=0.1, code=code).Fy.shape == ()
    assert hoosier.forces(alpha=[0.1], code=code).Fy.shape == (1,)
    assert hoosier.forces(alpha=[], code=code).Fy.shape == (0,)
    assert hoosier.evaluate(pd.DataFrame({"alpha": []}), code=code).shape[0] == 0


def test_unknown_inputs_and_languages_are_refused(hoosier):
    with pytest.raises(UnknownName, match=r"unknown input 'Alpha': did you mean alpha\?"):
        hoosier.forces(Alpha=0.1)
    with pytest.raises(UnknownName, match=r"language of the generated code 'fortran'"):
        hoosier.forces(alpha=0.1, code="fortran")


def test_forces_is_a_mapping():
    forces = Forces({"Fx": np.array(1.0), "Fy": np.array(2.0)})
    assert dict(forces) == {"Fx": 1.0, "Fy": 2.0}
    assert len(forces) == 2
    assert forces.Fx is forces["Fx"]
    assert repr(forces) == "Forces(Fx=1.0, Fy=2.0)"
    with pytest.raises(AttributeError, match="this model has no output My"):
        _ = forces.My
    with pytest.raises(KeyError):
        forces["My"]
    assert copy.copy(forces).Fy == 2.0


@pytest.fixture
def table():
    return pd.DataFrame(
        {"t": [0.0, 0.1, 0.2], "alpha": [0.0, 0.1, -0.1], "Fz": [500.0, 700, 900], "Fy": [1.0, 2, 3], "ET": [9, 8, 7]},
        index=[10, 20, 30],
    )


def test_evaluate_gives_inputs_forces_and_quantities(hoosier, table):
    answer = hoosier.evaluate(table, signs="adapted-sae")
    assert list(answer.index) == [10, 20, 30]
    assert list(answer)[:8] == ["t", "alpha", "Fz", "kappa", "gamma", "Fx", "Fy", "Mz"]
    assert answer.columns.is_unique
    assert "ET" not in answer
    assert (answer["kappa"] == 0).all()
    np.testing.assert_array_equal(answer["Fy"], hoosier.forces(alpha=table["alpha"], Fz=table["Fz"]).Fy)
    contract = """kappa_x B_x C_x D_x E_x S_Vx S_Hx K_xkappa mu_x F_x0 G_xa alpha_y B_y C_y D_y E_y S_Vy S_Hy
        K_yalpha mu_y F_y0 G_yk S_Vyk B_r B_t C_t D_r D_t E_t alpha_r alpha_t M_z0 M_zr trail
        F_x0_slope F_y0_slope"""
    assert set(contract.split()) <= set(answer)


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_evaluate_returns_the_convention_of_the_table(hoosier, table, signs):
    expected = hoosier.evaluate(table, signs="adapted-sae")
    answer = hoosier.evaluate(convert_signs(table, "adapted-sae", signs), signs=signs)
    back = convert_signs(answer, signs, "adapted-sae")
    for name in ("alpha", "Fz", "Fx", "Fy", "Mz"):
        np.testing.assert_allclose(back[name], expected[name], rtol=1e-12, atol=1e-12)


def test_a_nominal_load_is_returned_in_the_convention_of_the_table(hoosier):
    slips = pd.DataFrame({"alpha": [0.1]})
    assert hoosier.evaluate(slips, signs="sae")["Fz"].tolist() == [-220.0]
    assert hoosier.evaluate(slips, signs="iso")["Fz"].tolist() == [220.0]


def test_evaluate_clamps_to_the_ranges_on_demand(hoosier):
    assert hoosier.ranges["Fz"] == (120.0, 1220.0)
    wide = pd.DataFrame({"alpha": [0.1, 0.9], "Fz": [50.0, 9000.0]})
    inside = pd.DataFrame({"alpha": [0.1, hoosier.ranges["alpha"][1]], "Fz": [120.0, 1220.0]})
    clamped = hoosier.evaluate(wide, signs="adapted-sae", limits=True)
    np.testing.assert_array_equal(clamped["Fy"], hoosier.evaluate(inside, signs="adapted-sae")["Fy"])
    np.testing.assert_array_equal(clamped["Fz"], wide["Fz"])  # the inputs are returned unchanged
    free_of_limits = evaluation.evaluate(hoosier, wide, evaluation.Conventions("adapted-sae"))
    assert (free_of_limits["Fy"] != clamped["Fy"]).all()
    in_sae = hoosier.evaluate(convert_signs(wide, "adapted-sae", "sae"), signs="sae", limits=True)
    np.testing.assert_allclose(in_sae["Fy"], clamped["Fy"])
    free = replace(hoosier, ranges={})
    near = wide.assign(Fz=[50.0, 1900.0])
    pd.testing.assert_frame_equal(free.evaluate(near, limits=True), free.evaluate(near))


@pytest.mark.parametrize(
    ("value", "message"),
    [(math.nan, "row 2: alpha is NaN (1 of 3 rows)"), (-math.inf, "row 2: alpha is infinite (1 of 3 rows)")],
)
def test_evaluate_rejects_inputs_that_are_not_finite_numbers(hoosier, table, value, message):
    with pytest.raises(DataError) as caught:
        hoosier.evaluate(table.assign(alpha=[0.0, value, 0.1]), limits=True)
    assert str(caught.value) == message


def test_evaluate_does_not_modify_the_table(hoosier, table):
    before = table.copy()
    hoosier.evaluate(table, signs="adapted-sae", limits=True)
    pd.testing.assert_frame_equal(table, before)


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_tires_have_the_signs_of_their_source(name):
    tire = published(name)
    assert tire.signs == PUBLISHED[name]
    assert tire.about["source"]
    # The paper of the small tire gives Fx and Fy only: all other coefficients are neutral, and the file states it.
    assert tire.defaulted == () if name == "trento_hoosier" else "left_out" in tire.about
