"""Tires: values for a model's coefficients, .tir files, published tires, sign conventions."""

from .forces import Forces
from .published import PUBLISHED, published
from .signs import SIGNS, TABLE_INPUTS, TABLE_OUTPUTS, convert_signs
from .tir import read_tir, write_tir
from .tire import Tire

__all__ = [
    "PUBLISHED",
    "SIGNS",
    "TABLE_INPUTS",
    "TABLE_OUTPUTS",
    "Forces",
    "Tire",
    "convert_signs",
    "published",
    "read_tir",
    "write_tir",
]
