"""Which effects can be missing, the baseline model's fit, and the traces of effects in its residual."""
