"""The code of a model: generated or printed, compiled where necessary, behind one interface for all languages."""

from .batch_code import forces_of_each
from .interface import Code
from .selection import LANGUAGES, MANY_ROWS, code_for, fastest_code

__all__ = ["LANGUAGES", "MANY_ROWS", "Code", "code_for", "fastest_code", "forces_of_each"]
