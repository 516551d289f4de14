"""The code of a model: generated or printed, compiled where necessary, behind one interface for all languages."""

from .batch_code import chosen_derivatives, forces_of_each, normal_equations
from .interface import Code
from .normal_equations import CHUNK, WeightedRows
from .selection import LANGUAGES, MANY_ROWS, code_for, fastest_code

__all__ = [
    "CHUNK",
    "LANGUAGES",
    "MANY_ROWS",
    "Code",
    "WeightedRows",
    "chosen_derivatives",
    "code_for",
    "fastest_code",
    "forces_of_each",
    "normal_equations",
]
