"""Checks of a fit and its data: residuals, curves, consistency, what the data determine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .characteristics import Characteristic
    from .clipping import Clipped
    from .consistency import Disagreement, disagreeing_files, disagreeing_segments, sweep_differences
    from .continuity import Discontinuity
    from .curves import compare
    from .diagnostics import by_condition
    from .read_errors import ReadErrors
    from .residuals import Residuals
    from .slip_stiffness import SlipStiffness, slip_stiffnesses

__getattr__, __dir__ = on_demand(__name__)
