"""How probable each explanation of a recording is: explanations refitted and compared under one score."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .additions import Gain, best_formula, projected, reproduced_terms, rivals_of
    from .answer import OneOf, RankedExplanation, answer_of, percent
    from .budget import Budget, Ended
    from .compare import compared
    from .discrepancy import effect_discrepancy, grip_drift, model_discrepancy, smooth_functions
    from .evidence import NormalEquations, Projected
    from .explanation import UNKNOWN, Explanation, Term, terms_of_form, unknown_terms
    from .final import balanced, coefficients_of, final_fits, refined_core, with_proven
    from .form import FORM, form_effect, form_of
    from .linearization import Addition, Linearization
    from .refit import refitted, shared_problem
    from .table import Table, without_folds

__getattr__, __dir__ = on_demand(__name__)
