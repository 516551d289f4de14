"""Uncertainty of a fit: noise that is correlated in time, errors of the form of the model, derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .correlated_noise import CorrelatedSums, NoiseCorrelation
    from .discrepancy import Features

__getattr__, __dir__ = on_demand(__name__)
