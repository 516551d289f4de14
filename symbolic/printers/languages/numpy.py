"""A tire as a Python module for NumPy."""

from .python_arrays import NUMPY, printer_for

files = printer_for(NUMPY)
