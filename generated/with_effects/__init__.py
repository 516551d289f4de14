"""The models with the whole library of effects, as a diagnosis needs them: the same files as one folder above."""
