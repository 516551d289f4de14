"""Output of a diagnosis: the HTML report, figures of residuals, comparison of the FMUs with the recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .report import report_page

__getattr__, __dir__ = on_demand(__name__)
