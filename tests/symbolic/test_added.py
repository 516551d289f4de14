"""Effects beyond the book: their files, the quantities that they change, and their neutral values."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import EffectError
from tirefmu.symbolic.added import effect_text, library, read_effect
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire, read_tir

OWN = """
name = "grip_by_humidity"
physics = "a wet morning"
[coefficients]
HMU1 = {description = "friction, change with pressure in bar", unit = "1/Pa", lower = -1.0, upper = 1.0}
[[acts]]
on = "mu_y"
factor = "1 + HMU1*(p - NOMPRES)"
"""
LIBRARY = tuple(library())
#: The whole library in its order: a model that other tests print and compile, too.
ADDED = tuple(library().values())
VALUES = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
TABLE = pd.DataFrame(
    {"t": np.arange(6) * 0.1, "alpha": 0.1, "kappa": 0.05, "Fz": 3000.0, "V": 20.0, "T": np.linspace(30, 80, 6)}
)


@pytest.mark.parametrize("name", LIBRARY)
def test_a_file_written_and_read_is_the_same_effect(name):
    effect = library()[name]
    assert effect.name == name
    assert effect.source
    assert read_effect(effect_text(effect), "again.toml") == effect
    assert effect_text(read_effect(effect_text(effect), "again.toml")) == effect_text(effect)


@pytest.mark.parametrize("name", LIBRARY)
def test_an_effect_owns_its_coefficients(name):
    symbolic_model = model_named("mf61", ADDED)
    declared = {effect: {declaration.name for declaration in library()[effect].declarations} for effect in LIBRARY}
    assert symbolic_model.owned(name) <= declared[name]
    assert symbolic_model.owned(*LIBRARY) == set().union(*declared.values())
    assert symbolic_model.effects[name].optional


def test_with_every_added_effect_at_neutral_a_model_is_itself():
    plain = Tire("mf61", VALUES).evaluate(TABLE)
    effects = [*model_named("mf61").default_effects, *LIBRARY]
    added = Tire("mf61", VALUES, effects=effects, added=ADDED).evaluate(TABLE)
    for name in ("Fx", "Fy", "Mz", "Mx", "My", "mu_y", "K_yalpha"):
        np.testing.assert_array_equal(added[name], plain[name])


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
def test_each_has_the_effect_that_its_file_describes(code):
    values = VALUES | {"TMU1": -2e-3, "TMU2": 1e-5, "TREF": 50.0, "TK1": -1e-3, "VMU1": -0.1, "WMU1": -1e-3}
    tire = Tire("mf61", values, effects=LIBRARY, added=ADDED)
    answer, plain = tire.evaluate(TABLE, code=code), Tire("mf61", VALUES, effects=()).evaluate(TABLE, code=code)
    warm, rolled, faster = TABLE["T"] - 50.0, TABLE["t"] * 20.0, (20.0 - 16.7) / 16.7
    grip = (1 - 2e-3 * warm + 1e-5 * warm**2) * (1 - 1e-3 * rolled) * (1 - 0.1 * faster)
    for name in ("mu_x", "mu_y"):
        np.testing.assert_allclose(answer[name], plain[name] * grip, rtol=1e-12)
    for name in ("K_xkappa", "K_yalpha"):
        np.testing.assert_allclose(answer[name], plain[name] * (1 - 1e-3 * warm), rtol=1e-12)
    np.testing.assert_allclose(answer["distance"], rolled, rtol=1e-12)


def test_a_users_own_effect_acts():
    effect = read_effect(OWN, "own.toml")
    effects = ["grip_by_humidity", "temp_friction"]  # the model of the last test of this file
    tire = Tire("mf61", VALUES | {"HMU1": 1e-6}, effects=effects, added=(effect,))
    pressed = TABLE.assign(p=3e5)
    ratio = tire.evaluate(pressed)["mu_y"] / Tire("mf61", VALUES, effects=()).evaluate(pressed)["mu_y"]
    np.testing.assert_allclose(ratio, 1 + 1e-6 * (3e5 - 2.2e5), rtol=1e-12)


def test_an_effect_of_inclination_changes_the_upright_wheel_as_that_of_the_book_does():
    """The aligning moment follows the side force without inclination."""
    text = (
        OWN.replace("1/Pa", "1").replace("mu_y", "K_yalpha").replace("HMU1*(p - NOMPRES)", "HMU1*absolute(sin(gamma))")
    )
    table = TABLE.assign(gamma=np.linspace(-0.1, 0.1, 6))
    values = VALUES | {"QDZ1": 0.1, "QBZ1": 10.0, "QCZ1": 1.1}
    own = Tire("mf61", values | {"HMU1": -0.5}, added=[read_effect(text, "mine.toml")]).evaluate(table)
    of_book = Tire("mf61", values | {"PKY3": 0.5}).evaluate(table)
    assert abs(of_book["Mz"]).min() > 1.0
    for name in ("Fy", "Mz"):
        np.testing.assert_allclose(own[name], of_book[name], rtol=1e-12)


def test_an_effect_without_a_finite_value_at_the_upright_wheel_is_named():
    text = OWN.replace("HMU1*(p - NOMPRES)", "HMU1/gamma")
    with pytest.raises(EffectError, match=r"grip_by_humidity: .*not finite without inclination"):
        Tire("mf61", VALUES | {"HMU1": 0.1}, added=[read_effect(text, "mine.toml")])


def test_an_absent_added_effect_is_silent():
    tire = Tire("mf61", VALUES | {"TMU1": 0.04}, effects=["temp_stiffness"])
    assert tire.values["TMU1"] == 0.0
    assert tire.has == {"temp_stiffness"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (OWN.replace("mu_y", "mu_yy"), "grip_by_humidity acts on 'mu_yy', which is no named quantity: did you mean"),
        (OWN.replace("NOMPRES", "NOMPRESS"), "reads 'NOMPRESS', which mf61 has not before it: did you mean NOMPRES"),
        (OWN.replace("NOMPRES", "Fy"), "reads 'Fy', which mf61 has not before it"),
    ],
)
def test_an_effect_without_a_place_is_named(text, message):
    with pytest.raises(EffectError, match=message):
        model_named("mf61").extended([read_effect(text, "own.toml")])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name = ", "own.toml"),
        (OWN.replace("physics", "phisics"), "unknown key 'phisics': did you mean physics"),
        (OWN.replace("[[acts]]", "[[act]]"), "unknown key 'act': did you mean acts"),
        (OWN.replace("factor", "faktor"), "unknown key 'faktor' in acts.1.: did you mean factor"),
        (OWN.replace("1 + HMU1*(p - NOMPRES)", "1 + p"), "HMU1 is declared but not used"),
        (OWN.replace("lower = -1.0", "lower = 2.0"), "lower 2.0 is not below upper 1.0"),
        (OWN.replace("lower = -1.0", "lower = true"), "coefficients.HMU1.lower is true: expected a number"),
        (OWN.replace("HMU1 =", "hmu1 ="), "a word of capital letters"),
    ],
)
def test_an_invalid_file_gives_a_message_of_one_line(text, message):
    with pytest.raises(EffectError, match=message) as caught:
        read_effect(text, "own.toml")
    assert str(caught.value).startswith("own.toml")
    assert "\n" not in str(caught.value)


def test_a_tire_with_added_effects_survives_its_file(tmp_path):
    values = VALUES | {"HMU1": 1e-6, "TMU1": -1e-3, "SIGY": 0.4}
    effects = ["grip_by_humidity", "temp_friction", "relax_lat", "load_friction"]
    tire = Tire("mf61", values, effects=effects, added=(read_effect(OWN, "own.toml"),), name="added")
    tire.save(tmp_path / "added.tir")
    again = read_tir(tmp_path / "added.tir")
    assert again == tire
    pd.testing.assert_frame_equal(again.evaluate(TABLE), tire.evaluate(TABLE), rtol=0, atol=0)
