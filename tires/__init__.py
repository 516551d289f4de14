"""Tires: values for a model's coefficients, .tir files, published tires, sign conventions.

The names are loaded on first access: the command line needs some of them without pandas and the models.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .forces import Forces
    from .property_file.reading import read_tir
    from .property_file.writing import write_tir
    from .published_tires import PUBLISHED, published
    from .signs import SIGNS, TABLE_INPUTS, TABLE_OUTPUTS, convert_signs
    from .tire import Tire
    from .tire_argument import TireLike, tire_from

__all__ = [
    "PUBLISHED",
    "SIGNS",
    "TABLE_INPUTS",
    "TABLE_OUTPUTS",
    "Forces",
    "Tire",
    "TireLike",
    "convert_signs",
    "published",
    "read_tir",
    "tire_from",
    "write_tir",
]

__getattr__, __dir__ = on_demand(__name__)
