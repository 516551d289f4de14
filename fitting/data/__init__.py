"""Data of a fit: preprocessed rows, initial values, test whether recordings are of one tire."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .fit_data import ExcludedRows, prepare
    from .initial_values import readings, starting_values

__getattr__, __dir__ = on_demand(__name__)
