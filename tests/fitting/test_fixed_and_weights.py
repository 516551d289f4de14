"""Coefficients that are not fitted, and factors of the weights of rows."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.boundary.errors import DataError, FitError, UnknownName
from tirefmu.fitting import fit
from tirefmu.measurements import VirtualBench, alpha_sweeps, concatenate
from tirefmu.tires import published

NOMINAL = {"Fz0": 700.0, "R0": 0.23}
#: What sweeps at two loads determine, with PHY1, whose sign changes: a fit of all effects takes ten times as long.
EFFECTS = ("load_friction", "load_stiffness", "plysteer", "conicity")


@pytest.fixture(scope="module")
def recording():
    """Return sweeps at two loads, in ISO-W."""
    program = concatenate([alpha_sweeps([300.0, 900.0], sample_rate=5.0)])
    return VirtualBench(published("trento_hoosier"), seed=1).run(program).with_signs("iso")


@pytest.fixture(scope="module")
def free(recording):
    return fit(recording, "mf96", nominal=NOMINAL, effects=EFFECTS)


def test_fixed_coefficients_have_their_values_in_the_signs_of_the_file(recording, free):
    """Also one whose sign depends on the convention, and in every recipe; the others are fitted around them."""
    fixed = {"PCY1": 1.1 * free.tire.values["PCY1"], "PHY1": 0.01}
    assert fixed.keys() <= {each.name for each in free.coefficients}
    for recipe in (None, "joint", "trento"):
        found = fit(recording, "mf96", nominal=NOMINAL, effects=EFFECTS, fixed=fixed, recipe=recipe)
        assert {name: found.tire.values[name] for name in fixed} == fixed
        assert not fixed.keys() & {each.name for each in found.coefficients}
    rmse = [next(each.rmse for each in result.channels if each.channel == "Fy") for result in (free, found)]
    assert rmse[1] > rmse[0]


def test_a_weighted_condition_is_fitted_better(recording):
    """The core cannot describe both loads: the larger the weight of one, the smaller its error."""
    few = {"nominal": NOMINAL, "effects": (), "stiffness_weight": 0.0}
    errors = []
    for factor in (0.01, 1.0, 100.0):
        tire = fit(recording, "mf96", weights={"Fz in 800..1000 N": factor}, **few).tire
        rows = recording.table[recording.table["Fz"] > 800.0]
        error = rows["Fy"] - tire.forces(alpha=rows["alpha"].to_numpy(), Fz=rows["Fz"].to_numpy())["Fy"]
        errors.append(float(np.sqrt(np.mean(error**2))))
    assert errors[0] > errors[1] > errors[2]


def test_wrong_values_are_refused(recording):
    with pytest.raises(UnknownName, match="PCY1"):
        fit(recording, "mf96", nominal=NOMINAL, fixed={"PCY11": 1.0})
    with pytest.raises(FitError, match="not finite"):
        fit(recording, "mf96", nominal=NOMINAL, fixed={"PCY1": float("nan")})
    for factor in (0.0, -1.0, float("inf")):
        with pytest.raises(FitError, match="not positive"):
            fit(recording, "mf96", nominal=NOMINAL, weights={"Fz > 3 N": factor})
    with pytest.raises(DataError, match="where"):
        fit(recording, "mf96", nominal=NOMINAL, weights={"Fz >": 2.0})
