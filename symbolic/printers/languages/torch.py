"""A tire as a Python module for PyTorch."""

from .python_arrays import TORCH, printer_for

files = printer_for(TORCH)
