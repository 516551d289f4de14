"""Candidate effects, the fit of the baseline model, and the test of each effect on its residual.

Finite probes represent each effect, because the derivative at the neutral value is zero for some. The response of the
forces to a probe is a regression column, with the baseline model projected out. Two tests give its p-value: one with
the covariance of coloured noise, one with a jackknife over time blocks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .baseline_fit import baseline_coefficients, fit_baseline, reweighted
    from .candidates import candidates_for, is_testable, refinements_for
    from .confounding import EXPLANATIONS, alias_columns, correlations, separating_measurement

__getattr__, __dir__ = on_demand(__name__)
