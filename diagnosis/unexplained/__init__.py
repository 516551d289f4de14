"""Structure in the residual that no candidate effect explains, and a formula proposed for it.

Structure is accepted if it improves the prediction of nearly every long stretch that is excluded from the regression.
Terms in the inputs of the steady-state core alone are an error of form: they are corrected first. Rates and memories
are computed from the recording at once; the proposed effect has states that resemble them: a direction is the
hysteresis of a lagged slip, a rate the difference between an input and its lag. The formula is added to the model only
if the error on the hold-out set decreases.
"""
