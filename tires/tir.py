"""Tire property files (.tir): text to tire and back.

The format is the field's; `tir_text` holds its form, `tir_names` and `tir_units` its words, `tir_reading` and
`tir_writing` the way to a tire and back. What it cannot say (the effects, where the tire comes from, what nobody gave)
stands in the sections [TIREFMU], [TIREFMU_ABOUT] and [TIREFMU_ASSUMED], which other readers skip.
"""

from .tir_names import not_given
from .tir_reading import TirReading, read_tir, read_tir_with_notes
from .tir_writing import tir_text, write_tir

__all__ = ["TirReading", "not_given", "read_tir", "read_tir_with_notes", "tir_text", "write_tir"]
