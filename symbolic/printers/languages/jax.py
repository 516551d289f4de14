"""A tire as a Python module for JAX."""

from .python_arrays import JAX, printer_for

files = printer_for(JAX)
