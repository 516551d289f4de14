"""Initial values read from the data: closer to the truth than generic values, and never harmful."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting.data import readings, starting_values
from tirefmu.measurements import Noise
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire


def blank(make, model="mf96", effects=None):
    """Return a tire of which only the nominal values are known."""
    values = {"FNOMIN": 700.0, "UNLOADED_RADIUS": 0.23}
    return Tire(model, values, effects=make.effects if effects is None else effects, signs="adapted-sae")


ROLES = ("stiffness_x", "friction_x", "shift_x", "stiffness_y", "friction_y", "shift_y", "trail", "trail_fall")
FROM_DATA = {name for role in ROLES for name in model_named("mf96").roles[role].coefficients}


def measured(make, tire, **program):
    return make.bench(tire, noise=Noise(), **program).with_signs("adapted-sae").table


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_values_from_the_data_are_closer_to_the_truth_than_generic_ones(make, seed):
    truth = make.other_tire(seed)
    read = starting_values(blank(make), measured(make, truth))
    assert set(read) == FROM_DATA - {"PHX1"}  # of an absent effect
    points = pd.DataFrame({"Fz": [300.0, 700.0, 1100.0]})
    declarations = truth.symbolic_model.coefficients
    generic = {name: declarations[name].generic for name in read}

    def quantities(values):
        tire = Tire("mf96", {**truth.values, **values}, effects=make.effects, signs="adapted-sae")
        return tire.evaluate(points, signs="adapted-sae")

    true = quantities({})
    for name, worst in (("K_yalpha", 0.05), ("mu_y", 0.05), ("K_xkappa", 0.1), ("mu_x", 0.1), ("D_t", 0.15)):
        errors = [float(np.abs(quantities(values)[name] / true[name] - 1).max()) for values in (read, generic)]
        assert errors[0] < worst, name
        assert errors[0] < errors[1], name


@pytest.mark.parametrize("seed", [1, 2])
def test_a_fit_from_these_values_is_not_worse(make, seed):
    recording = make.sideways(make.other_tire(seed), noise=Noise())
    generic, read = (make.fit(recording, start=s) for s in (None, "features"))
    assert read.ok
    assert read.channels[0].rmse <= generic.channels[0].rmse * 1.001
    guess = make.coefficients(read)["PKY1"].guess
    assert guess != make.coefficients(generic)["PKY1"].guess
    assert any(f"initial values read from the data: PKY1 {guess:.3g}" in note for note in read.notes)


def test_a_later_model_reads_its_own_coefficients(make):
    values = {"PCY1": 1.4, "PDY1": 2.1, "PDY2": -0.2, "PEY1": -0.3, "PKY1": 50.0, "PKY2": 1.6, "PHY1": 0.004}
    effects = ("load_friction", "load_stiffness", "plysteer")
    start = blank(make, "mf61", effects)
    truth = Tire("mf61", {**start.values, **values}, effects=effects, signs="adapted-sae")
    read = starting_values(start, measured(make, truth, kappa=False)[["alpha", "gamma", "Fz", "Fy"]])
    assert set(read) == {"PKY1", "PKY2", "PDY1", "PDY2", "PHY1"}
    for name, value in read.items():
        assert value == pytest.approx(values[name], rel=0.1, abs=0.002), name


def test_a_core_without_load_stiffness_has_one_stiffness_coefficient(make, known):
    table = measured(make, Tire("mf96", known.values, effects=(), signs="adapted-sae"))
    assert set(starting_values(blank(make, effects=()), table)) == {"PDX1", "PDY1", "PKX1", "PKY1", "QBZ1", "QDZ1"}


def test_outliers_hardly_change_the_initial_values(make):
    table = measured(make, make.other_tire(1))
    random = np.random.default_rng(5)
    spoiled = table.assign(Fy=np.where(random.random(len(table)) < 0.02, 20e3, table["Fy"]))
    clean, odd = (starting_values(blank(make), rows) for rows in (table, spoiled))
    assert odd["PKY1"] == pytest.approx(clean["PKY1"], rel=0.3)


def test_quantities_that_the_data_do_not_show_have_no_reading(make):
    table = measured(make, make.other_tire(1))
    short = table[np.abs(table["alpha"]) < 0.02]
    assert "mu_y" not in readings(short)  # no peak in sight
    one_load = table[np.abs(table["Fz"] - 800.0) < 60.0]
    assert {"PKY1", "PDY1"} <= set(starting_values(blank(make), one_load))
    assert not {"PKY2", "PDY2", "PKX3", "PDX2"} & set(starting_values(blank(make), one_load))
    for rows in (table[["alpha", "Fy"]], table.drop(columns=["Fx", "Fy"]), table[table["alpha"] > 0.05], table[:5]):
        assert set(readings(rows)) <= {"stiffness_x", "friction_x", "shift_x"}
    silent = table.assign(Fx=0.0, Fy=0.0, Mz=0.0)
    assert readings(silent) == {}
