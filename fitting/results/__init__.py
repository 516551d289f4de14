"""The result of a fit, its summary, and the checkpoint from which it is resumed."""
