"""Tire models as named, numbered equations, and the passes over them."""

#: The default model of a fit or a diagnosis.
DEFAULT_MODEL = "mf61"
