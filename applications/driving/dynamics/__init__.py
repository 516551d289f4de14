"""What an interval alone does not have of the car: what lags in it, and what no entry of its file explains."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .discrepancy import FORM, N_COLUMNS, SIZED, USUAL, discrepancy_columns, size_of
    from .lagging import DAMPING, behind_lags, heaving, measured_slips, wheel_motion, with_lags

__getattr__, __dir__ = on_demand(__name__)
