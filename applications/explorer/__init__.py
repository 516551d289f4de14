"""One offline page for a tire: sliders, curves, measured points, computed by the tire's JavaScript (`explore.py`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .explore import fit_intervals, page_text

__getattr__, __dir__ = on_demand(__name__)
