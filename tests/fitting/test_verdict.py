"""The verdict on a fit: what makes a tire unusable, what limits it, in order of weight."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tirefmu.fitting import Findings, fit
from tirefmu.fitting.checks import Characteristic, Clipped, Discontinuity, SlipStiffness
from tirefmu.fitting.constraints import Margin, chosen_constraints
from tirefmu.fitting.data import ExcludedRows
from tirefmu.fitting.results.records import ChannelFit
from tirefmu.fitting.results.verdict import verdict_of
from tirefmu.fitting.uncertainty.sandwich import Uncertainty
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps


def stiffness(error, load=500.0):
    return SlipStiffness("a.csv", "Fy", "alpha", "N/rad", load, 1e4, 1e4 * (1.0 + error))


def lacking(share):
    """Return a fit of Fy whose error is 5 times its floor and this share of the spread of the values."""
    return ChannelFit(
        "a.csv", "Fy", "N", 900, 49.0, 0.9, 0.9, 9.8, 300.0, 900, 49.0, 1.0 - (0.98 * share) ** 2, 1.0, 48.0, 2.0
    )


@pytest.fixture
def judged(side_fit):
    """Return a function that gives the verdict on a good fit with some attributes changed."""
    result, _ = side_fit
    good = {
        "ok": True, "status": "converged", "tire": result.tire, "coefficients": (),
        "channels": tuple(replace(result.channels[0], channel=name, recording="a.csv") for name in ("Fx", "Fy")),
        "excluded_rows": (), "bounds": (), "uncertainty": Uncertainty(), "residuals": None,
        "findings": Findings(stiffnesses=(stiffness(0.02),)),
    }  # fmt: skip
    names = [each.name for own in chosen_constraints(result.tire.model).values() for each in own]
    good["margins"] = [Margin(name, 0.0, 1.0, {}, name) for name in names]

    def verdict(**changed):
        return verdict_of(SimpleNamespace(**{**good, **changed}))

    return verdict


def test_a_good_fit_has_no_reasons(judged):
    verdict = judged()
    assert (verdict.word, verdict.reasons, verdict.usable) == ("good", (), True)


def test_each_reason_has_its_consequence(judged, side_fit):
    result, _ = side_fit
    cut = Clipped("a.csv", "Fy", "N", float("nan"), 2300.0, 0.16)
    low = Characteristic("a.csv", "Fy", "peak friction", "1", 500.0, 2.0, 1.6, 0.02, {"Fz": 500.0})
    step = Discontinuity("Mx", "N m", "jump", -28.0, "alpha", 0.0017, {"Fz": 2750.0})
    force, moment = result.channels[0], replace(result.channels[0], channel="Mz", fitted_r2=-1.0)
    excluded = ExcludedRows("a.csv", "warm-up", "cold tread", 400, 1000, ())
    bounded = replace(result.coefficients[0], at_bound=True)
    cases = [
        ({"ok": False, "status": "not converged"}, "not usable", "not converged"),
        ({"channels": (force, replace(force, channel="Fx", fitted_r2=-0.63))}, "not usable", "Fx is not described"),
        (
            {"findings": Findings(stiffnesses=(stiffness(-0.999),))},
            "not usable",
            "differs from the data by -100% over all conditions",
        ),
        (
            {"findings": Findings(stiffnesses=(stiffness(-0.16),))},
            "usable with limits",
            "differs from the data by -16% at 500 N",
        ),
        ({"channels": (force,)}, "usable with limits", "Fx is not fitted"),
        ({"channels": (force, replace(force, channel="Fx", fitted_r2=0.3))}, "usable with limits", "described poorly"),
        ({"channels": (force, replace(force, channel="Fx"), moment)}, "usable with limits", "Mz is not described"),
        (
            {"channels": (lacking(0.05), replace(force, channel="Fx"))},
            "usable with limits",
            "is 5.0 times the noise floor (48 N changes slowly with time",
        ),
        (
            {"channels": (lacking(0.5), replace(force, channel="Fx"))},
            "not usable",
            "Fy: RMSE 49 N is 5.0 times the noise floor",
        ),
        ({"findings": Findings(clipped=(cut,))}, "not usable", "Fy is cut off at 2300 N in 16% of the rows"),
        (
            {"findings": Findings(characteristics=(low,))},
            "usable with limits",
            "the peak friction of Fy differs from the data by -20% at Fz 500 N",
        ),
        (
            {"findings": Findings(discontinuities=(step,))},
            "usable with limits",
            "Mx of the tire jumps by 28 N m at alpha 0.1 deg, Fz 2750 N",
        ),
        ({"margins": ()}, "usable with limits", "physical constraints not enforced: curvature:E_x"),
        ({"coefficients": (bounded,)}, "usable with limits", f"1 of 1 coefficients at bounds: {bounded.name}"),
        ({"excluded_rows": (excluded,)}, "usable with limits", "a.csv: 40% of the rows excluded (warm-up)"),
    ]
    for changed, word, reason in cases:
        verdict = judged(**changed)
        assert verdict.word == word, changed
        assert verdict.usable == (word != "not usable")
        assert reason in verdict.reasons[0]
        assert len(verdict.reasons) == 1 or "stiffness" in verdict.reasons[1]
    poor = judged(channels=(replace(lacking(0.05), fitted_r2=0.3), replace(force, channel="Fx")))
    assert poor.word == "not usable"
    assert "Fy is described poorly" in poor.reasons[0]


def test_reasons_are_in_order_of_weight(judged, side_fit):
    result, _ = side_fit
    wrong = replace(result.channels[0], channel="Fx", fitted_r2=-0.1)
    bounded = replace(result.coefficients[0], at_bound=True)
    verdict = judged(
        channels=(result.channels[0], wrong), coefficients=(bounded,),
        findings=Findings(stiffnesses=(stiffness(0.2), stiffness(0.3, 900.0))),
    )  # fmt: skip
    assert verdict.word == "not usable"
    for text, reason in zip(("Fx is not described", "+30% at 900 N", "at bounds"), verdict.reasons, strict=True):
        assert text in reason


def test_side_force_alone_is_a_limit(side_fit):
    result, _ = side_fit
    assert result.verdict.word == "usable with limits"
    assert result.verdict.reasons[0] == "Fx is not fitted: it was not measured over a varying kappa"
    plain = result.to_json()
    assert plain["ok"] is True
    assert (plain["verdict"], plain["reasons"]) == ("usable with limits", list(result.verdict.reasons))


def test_spikes_do_not_affect_the_quality_of_the_fitted_rows(known):
    """One row in a hundred is wrong and excluded: over all rows the error is that of the spikes."""
    program = alpha_sweeps((500.0, 1000.0), (0.0,), sample_rate=20.0)
    table = VirtualBench(known, Noise.none(), seed=1).run(program).table[["t", "alpha", "Fz", "Fy"]].copy()
    table.loc[5::100, "Fy"] = 3e4
    effects = ["load_friction", "load_stiffness", "plysteer", "conicity"]
    result = fit(Recording(table, "adapted-sae", "spiked"), "mf96", effects=effects, nominal={"Fz0": 700.0})
    (channel,) = result.channels
    assert channel.rows - channel.fitted_rows >= len(table) // 100
    assert channel.rmse > 2000.0
    assert channel.r2 < 0.5
    assert channel.fitted_rmse < 30.0
    assert channel.fitted_r2 > 0.999
    assert result.verdict.usable
