"""Fit of the effect `temperature` to recorded temperatures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .optimum import optimum_temperature
    from .temperature_fit import STARTS, fit_temperature

__getattr__, __dir__ = on_demand(__name__)
