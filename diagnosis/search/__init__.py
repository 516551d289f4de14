"""Stepwise search for missing effects: probe, refit, rank, apply the acceptance criteria, repeat.

In each round the best candidates are refitted jointly with the baseline model and ranked by blocked cross-validation.
The best one that passes all criteria is accepted. An effect is preferred to unexplained structure if it explains most
of what the structure explains, alone or together with the effects that the next rounds would identify: if several
effects are missing, no single one explains the residual.

The search weights rows equally, because whitening amplifies errors in the functional form of a model. The final fits
use whitened residuals.
"""
