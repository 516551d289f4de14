"""Which effects can be missing, the baseline model's fit, and the responses of effects in its residual."""
