"""Tires: values for a model's coefficients, .tir files, published tires, sign conventions."""

from .published import PUBLISHED, published
from .signs import SIGNS, convert_signs
from .tir import read_tir, write_tir
from .tire import TABLE_INPUTS, TABLE_OUTPUTS, Forces, Tire

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
