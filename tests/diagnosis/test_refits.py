"""Decisions on the gains of blocks: no block of time dominates."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tirefmu.diagnosis.search import effect_search
from tirefmu.diagnosis.search.effect_search import Search
from tirefmu.diagnosis.search.memory import _simpler
from tirefmu.diagnosis.search.refits import REFINEMENT, Refit, Tried, consistent, distinct, preferred, rivals
from tirefmu.estimation.block_regression import error_of_sum
from tirefmu.symbolic.detection import Form


def refit(name, gains):
    """Return a candidate of which only the gains are known."""
    unknown = cast(Any, None)
    return Refit(name, unknown, unknown, unknown, 0.0, 0.5, 0.01, gains, unknown)


class CompletedSearch:
    """The outcome of a search: what it found, the structure that remains, and the squared misfit of each block."""

    def __init__(self, found, structures, loss, rivals=frozenset()):
        self.found = [refit(name, np.ones(4)) for name in found]
        self.structures = [SimpleNamespace(depends_on=variables) for variables in structures]
        self.screen = SimpleNamespace(baseline=SimpleNamespace(loss=np.full(4, loss)))
        self.candidates = {"temp_friction": 1, "slip_history": 2}
        self.rivals, self.completed, self.progress = rivals, False, lambda sentence: None

    def run(self):
        """Remember which candidates were tested."""
        self.completed, self.tested = True, set(self.candidates)


def test_a_search_that_its_rounds_end_states_it(at_true_values, monkeypatch):
    ended = []
    for rounds in (0, 1):
        search = Search(at_true_values.problem, at_true_values.solution, {}, lambda sentence: None)
        monkeypatch.setattr(effect_search, "ROUNDS", rounds)
        search.run()
        ended.append(search.stopped)
    assert ended == [True, False]


@pytest.mark.parametrize(
    ("structure", "near", "outcome", "loss", "repeated", "replaced"),
    [
        (("memory",), {"slip_history"}, (["slip_history"], []), 1.0, True, True),
        (("memory",), {"slip_history"}, (["slip_history"], []), 9.0, True, False),  # explains less
        (("memory",), {"slip_history"}, ([], [("memory",)]), 1.0, True, False),  # the past without an effect
        (("memory",), set(), (["slip_history"], []), 1.0, False, False),  # nothing else explained as much
        (("Fz",), {"slip_history"}, (["slip_history"], []), 1.0, False, False),  # nothing of the past remains
    ],
)
def test_two_findings_are_replaced_by_one_that_explains_as_much(structure, near, outcome, loss, repeated, replaced):
    search = CompletedSearch(["temp_friction"], [structure], 5.0, near)
    other = CompletedSearch(*outcome, loss)
    assert _simpler(search, other) is (other if replaced else search)
    assert other.completed == repeated
    if repeated:
        assert other.tested == {"slip_history"}
    if replaced:
        assert set(other.candidates) == {"temp_friction", "slip_history"}  # what is confounded with it is reported


def test_a_dominating_block_does_not_veto_an_effect_that_others_confirm():
    gains = np.concatenate([[5e5, 3e3, 3e3, 2e3, 2e3, 2e3], np.zeros(34)])
    assert gains.sum() < 1.1 * error_of_sum(gains)  # as if it were uncertain
    assert consistent(gains)


def test_a_dominating_block_alone_is_no_evidence():
    others = np.random.default_rng(0).normal(0.0, 5.0, 40)
    others -= others.mean()
    assert not consistent(np.concatenate([[5e5], others]))


def test_equal_gains_are_consistent_and_noise_is_not():
    assert consistent(np.full(12, 3.0))
    assert not consistent(np.tile([1.0, -1.0], 20))


def test_an_effect_with_states_must_be_clearly_better_than_one_without():
    noise = np.random.default_rng(1).normal(0.0, 1.0, 40)
    near, far, static = refit("near", 6.2 + noise), refit("far", 9.0 + noise), refit("static", 6.0 - noise)
    for refit_with_states, states, best in [(near, True, static), (near, False, near), (far, True, far)]:
        candidates = {
            refit_with_states.name: SimpleNamespace(contains=None, has_states=states),
            "static": SimpleNamespace(contains=None, has_states=False),
        }
        assert preferred([refit_with_states, static], candidates) is best


def test_a_rival_explains_nearly_as_much_in_the_blocks_of_time():
    noise = np.random.default_rng(1).normal(0.0, 1.0, 40)
    best, near, far = (
        refit(name, gains) for name, gains in (("a", 6.0 + noise), ("b", 5.9 - noise), ("c", 3.0 + noise))
    )
    refined = refit(f"{REFINEMENT}core", 5.9 - noise)
    assert rivals(best, [best, near, far, refined]) == {"b"}


def test_a_form_of_both_axes_must_explain_significantly_more_than_one_of_one_axis():
    noise = np.random.default_rng(2).normal(0.0, 1.0, 40)

    def tried(names, loss, name="slip_history"):
        return Tried(name, Form.each(dict.fromkeys(names, 0.03)), cast(Any, SimpleNamespace(loss=loss)))

    both, one_axis = tried(("SHMUX", "SHMUY"), 20.0 + noise), tried(("SHMUY",), 20.1 + noise[::-1])
    worse, other = tried(("SHMUY",), 26.0 + noise[::-1]), tried(("SHMUX",), 20.1 + noise[::-1], name="another")
    assert distinct([both, one_axis]) == [one_axis]
    assert distinct([both, worse]) == [both]
    assert distinct([both, other]) == [both, other]
