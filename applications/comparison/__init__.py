"""Two tires compared: coefficients that differ, error over recordings, figures, a page (`comparison.py`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .figures import comparison_figures, write_comparison

__getattr__, __dir__ = on_demand(__name__)
