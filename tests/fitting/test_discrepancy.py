"""Errors of the form of a model widen intervals; noise alone does not."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from tirefmu.fitting import fit
from tirefmu.fitting.results.verdict import FORM_OF_FORCE

SPEC = importlib.util.spec_from_file_location(
    "coverage_benchmark", Path(__file__).parents[2] / "benchmarks" / "coverage.py"
)
coverage = importlib.util.module_from_spec(SPEC)
sys.modules["coverage_benchmark"] = coverage
SPEC.loader.exec_module(coverage)


@pytest.fixture(scope="module")
def fits():
    """Return made recordings and their fits by group."""
    found = {}
    for group in ("noise", "memory", "static effect"):
        case = coverage.made(group, 1)
        found[group] = case, fit([case.recording], "mf96", nominal=coverage.NOMINAL, recipe="joint")
    return found


def errors(fits, group):
    return {each.channel: each for each in fits[group][1].uncertainty.discrepancies}


@pytest.mark.slow
def test_noise_has_no_error_of_the_form(fits):
    for each in errors(fits, "noise").values():
        assert min(each.form_chance, each.state_chance) > 0.003
    assert not [reason for reason in fits["noise"][1].verdict.reasons if "diagnose" in reason]


@pytest.mark.slow
def test_a_memory_depends_on_time_and_an_effect_on_the_inputs(fits):
    memory, static = errors(fits, "memory")["Fy"], errors(fits, "static effect")["Fy"]
    assert memory.state_chance < 1e-6 < memory.form_chance
    assert memory.form < 0.5 * memory.state
    assert static.form_chance < 1e-6
    assert static.state < 0.5 * static.form
    # The memory changes the side force by 1 %, less than repeated measurements differ: it is in the intervals alone.
    reasons = {group: [text for text in fits[group][1].verdict.reasons if "diagnose" in text] for group in fits}
    assert bool(reasons["static effect"]) == (static.form > FORM_OF_FORCE)
    assert bool(reasons["memory"]) == (memory.state > FORM_OF_FORCE)


@pytest.mark.slow
@pytest.mark.parametrize("group", ["noise", "memory", "static effect"])
def test_intervals_contain_the_truth(fits, group):
    """In one recording of each group; `make coverage` counts ten."""
    shares = dict(coverage.covered(*fits[group]))
    assert np.mean([share for name, share in shares.items() if name != "coefficients"]) > 0.8


@pytest.mark.slow
def test_the_covariance_contains_the_error_of_the_form(fits):
    result = fits["memory"][1]
    places = [(each, each.names.index("PDY1")) for each in errors(fits, "memory").values()]
    added = sum(each.covariance[place, place] for each, place in places)
    assert 0.5 * result.covariance.loc["PDY1", "PDY1"] < added < result.covariance.loc["PDY1", "PDY1"]
