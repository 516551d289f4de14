"""Decisions on the gains of blocks: no block of time dominates."""

import numpy as np

from tirefmu.diagnosis.search.refits import consistent
from tirefmu.estimation.block_regression import error_of_sum


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
