"""Evaluation of a table: the other side of the vehicle, conventions by name, inputs without influence on a tire."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import UnknownName
from tirefmu.tires import Tire, convert_signs
from tirefmu.tires.signs import MIRRORED

BODY = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "PKY1": -18.0, "PKY2": 2.0, "PDY2": -0.2}
#: One asymmetric coefficient of each kind.
ASYMMETRIC = {"PHY1": 0.01, "PVY1": 0.02, "QDZ6": 0.01, "RHX1": 0.01, "PEY3": 0.1, "QDZ8": -0.3, "PVY3": -0.4}


MAGIC = ("mf96", "mf52", "mf61", "mf62")


def asymmetric(name):
    """Return a tire with plysteer, conicity and every other asymmetry."""
    declarations = Tire(name, BODY).symbolic_model.coefficients
    more = {"QSX1": 0.01, "QSX2": 0.5, "QSX3": 0.05, "QSY1": 0.01, "PDXP1": 0.4, "PDYP1": 0.5, "PKY6": -1.0,
            "PHYP2": 0.1, "QCRP1": 0.2}  # fmt: skip
    return Tire(name, {**BODY, **ASYMMETRIC, **{key: value for key, value in more.items() if key in declarations}})


def drawn(n=50, seed=0):
    rng = np.random.default_rng(seed)
    return pd.DataFrame(
        {
            "kappa": rng.uniform(-0.3, 0.3, n),
            "alpha": rng.uniform(-0.3, 0.3, n),
            "gamma": rng.uniform(-0.1, 0.1, n),
            "Fz": rng.uniform(500.0, 6000.0, n),
            "V": rng.uniform(-20.0, 20.0, n),
            "phit": rng.uniform(-1.0, 1.0, n) * (rng.random(n) < 0.5),
        }
    )


def turned(table):
    """Return a table of inputs or outputs, mirrored in the wheel plane."""
    return table.assign(**{name: -table[name] for name in table if name in MIRRORED})


@pytest.fixture(params=MAGIC)
def tire(request):
    return asymmetric(request.param)


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_the_other_side_is_the_mirror_image(tire, signs):
    table, forces = convert_signs(drawn(), "iso", signs), list(tire.outputs)
    expected = turned(tire.evaluate(turned(table), signs=signs)[forces])
    answer = tire.evaluate(table, signs=signs, mirror=True)
    np.testing.assert_allclose(answer[forces], expected, rtol=1e-12, atol=1e-9)
    for name in set(table) & set(answer):
        np.testing.assert_array_equal(answer[name], table[name])  # the inputs are returned unchanged
    other = tire.evaluate(table, signs=signs)
    assert np.max(np.abs(answer["Fy"] - other["Fy"])) > 10.0  # the tire is asymmetric


def test_the_side_of_a_tire_changes_nothing_by_itself(tire):
    table = drawn()
    for side in ("left", "right"):
        pd.testing.assert_frame_equal(replace(tire, side=side).evaluate(table), tire.evaluate(table))


def test_forces_are_the_evaluation_at_its_defaults(tire):
    table = drawn()
    forces = tire.forces(**{name: table[name] for name in table})
    answer = tire.evaluate(table, signs=tire.signs)
    for name in tire.outputs:
        np.testing.assert_array_equal(forces[name], answer[name])


@pytest.mark.parametrize("model", MAGIC[1:])
def test_turn_slip_has_no_influence_on_a_tire_without_it(model):
    tire = asymmetric(model)
    plain = replace(tire, effects=tire.has - {"turn_slip"})
    table, forces = drawn(), list(tire.outputs)
    straight = tire.evaluate(table.assign(phit=0.0))
    answer = plain.evaluate(table)
    pd.testing.assert_frame_equal(answer[forces], straight[forces], check_exact=True)
    np.testing.assert_array_equal(answer["phit"], table["phit"])
    assert np.max(np.abs(tire.evaluate(table)["Fy"] - straight["Fy"])) > 10.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"convention": "tnt"}, "unknown value of convention 'tnt': did you mean tno?"),
        ({"slip_angle": "angel"}, "unknown value of slip_angle 'angel': did you mean angle?"),
        ({"signs": "isso"}, "unknown sign convention 'isso': did you mean iso?"),
    ],
)
def test_an_unknown_convention_is_refused(tire, options, message):
    with pytest.raises(UnknownName) as caught:
        tire.evaluate(drawn(), **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_option_that_does_not_exist_is_refused(tire):
    with pytest.raises(UnknownName, match=r"unknown option 'limit': did you mean limits\?"):
        tire.parameters(limit="on")
    if tire.model == "mf96":
        np.testing.assert_array_equal(tire.parameters(convention="book"), tire.parameters())
    else:
        assert (tire.parameters(convention="book") != tire.parameters()).sum() == 1
