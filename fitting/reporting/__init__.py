"""Figures, text and HTML report of a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .figures import figures_of, weighting_figure
    from .load_figures import data_text, friction_over_load, largest_friction, stiffness_over_load
    from .load_table import stiffness_by_load
    from .report import overview, report_page, write_report
    from .report_text import constraint_rows, extrapolation_text, ripple_texts, significant_differences

__getattr__, __dir__ = on_demand(__name__)
