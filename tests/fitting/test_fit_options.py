"""Options of a fit: effects, start, nominal values, progress; a fit that does not converge is a result."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting import fit
from tirefmu.measurements import rounded_median
from tirefmu.symbolic.models import model_named
from tirefmu.tires import Tire

MODEL = model_named("mf96")


def test_the_coefficients_of_absent_effects_stay_neutral(known, make):
    result = fit([make.sideways(known)], "mf96", without=["camber_thrust", "plysteer"], nominal=make.nominal)
    assert result.tire.has == frozenset(MODEL.effects) - {"camber_thrust", "plysteer"}
    absent = MODEL.owned("camber_thrust", "plysteer")
    assert {"PHY3", "PVY3", "PVY4", "PHY1", "PHY2"} <= absent
    for name in absent:
        assert result.tire.values[name] == MODEL.coefficients[name].neutral
    assert not absent & set(make.coefficients(result))


def test_the_core_alone_is_fitted(known, make):
    core = Tire("mf96", known.values, effects=(), signs="adapted-sae")
    result = make.fit(make.sideways(core), effects=())
    assert result.status == "converged"
    assert result.tire.has == frozenset()
    assert result.channels[0].r2 > 0.99999
    assert -result.tire.values["PKY1"] == pytest.approx(core.values["PKY1"], rel=1e-4)
    assert make.coefficients(result)["PKY1"].value == pytest.approx(core.values["PKY1"], rel=1e-4)


@pytest.mark.parametrize("stiffness", [(), ("load_stiffness",)], ids=["proportional", "saturating"])
def test_constraints_and_influence_use_rescaled_coefficients(make, known, stiffness):
    effects = ("camber_thrust", "load_friction", *stiffness)
    truth = Tire("mf96", known.values, effects=effects, signs="adapted-sae")
    result = make.fit(make.sideways(truth), effects=effects)
    assert result.ok
    assert result.channels[0].r2 > 0.99999
    (stiff,) = (margin for margin in result.margins if margin.constraint == "B_y > 0")
    assert 1.0 < stiff.worst < 100.0
    assert make.coefficients(result)["PKY1"].determined


# ------------------------------------------------------------------ start, nominal, progress


def test_a_start_tire_gives_values_and_effects(known, make):
    recording = make.sideways(known)
    result = fit([recording], "mf96", start=known.in_signs("iso"))
    assert result.tire.has == known.has
    assert result.tire.name == "known"
    assert result.tire.values["FNOMIN"] == 700.0
    assert result.channels[0].rmse < 1e-3
    assert make.coefficients(result)["PDY1"].guess == known.values["PDY1"]
    # What these data cannot see is still the start's.
    assert not make.coefficients(result)["RBY1"].determined
    for name in ("PCX1", "PKX1", "QBZ1", "RBY1"):
        assert result.tire.values[name] == known.values[name]
    less = fit([recording], "mf96", start=known, without=["camber_thrust"])
    assert less.tire.has == known.has - {"camber_thrust"}
    assert less.channels[0].rmse > 10.0


def test_nominal_values(known, make):
    recording = make.sideways(known)
    result = fit([recording], "mf96", effects=make.effects, nominal={"Fz0": 900.0, "R0": 0.25, "p0": 1e5})
    assert result.tire.values["FNOMIN"] == 900.0
    assert result.tire.values["UNLOADED_RADIUS"] == 0.25
    assert any("nominal p0 is not used by mf96" in note for note in result.notes)
    assert result.channels[0].r2 > 0.9999  # the same curve with another nominal load
    generic = fit([recording], "mf96", effects=())
    assert generic.tire.values["FNOMIN"] == float(f"{np.median(recording.table['Fz']):.2g}")
    assert {"nominal load not given: the median, 650 N", "radius R0 not known: 0.3 m is assumed"} <= {
        note.partition(";")[0] for note in generic.notes
    }


@pytest.mark.parametrize(
    "values", [[11.1, 11.16, 11.29], [83449.0, 83449.0], [1e6 / 90.0] * 3, [1.0, np.nan, 657.0], [5.04, 5.05]]
)
def test_a_nominal_value_of_the_data_is_within_the_data(values):
    found = rounded_median(pd.Series(values))
    assert np.nanmin(values) <= found <= np.nanmax(values)
    assert found == pytest.approx(np.nanmedian(values), rel=0.05)


def test_a_fit_that_ends_within_the_noise_of_the_optimum_has_converged(known, make):
    result = make.fit(make.sideways(known), iterations=1)
    assert result.ok
    assert result.channels[0].r2 > 0.99999
    assert result.stages[-1].reason.startswith("iteration limit: predicted reduction")
    assert result.stages[-1].reason.endswith("standard errors of the optimum")
