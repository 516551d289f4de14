"""Figure of a fit of the heat balance: recorded and predicted temperature over time, and the energy balance."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...boundary.escaping import figure_text
from ...drawing.figure import Figure, Panel, Series, in_rows
from ...drawing.style import BLUE, GRAY, GREEN, ORANGE, RED
from ...measurements import Recording
from ...tires.tire import Tire
from ..temperature.fitted_temperature import FittedTemperature
from ..temperature.heat_balance import ZERO_CELSIUS, HeatBalance
from ..temperature.selection import with_temperature


def temperature_over_time(tire: Tire, fitted: FittedTemperature, recordings: Iterable[Recording]) -> Figure:
    """Return a figure with two panels for each recording with a recorded temperature."""
    panels = []
    chosen = with_temperature(list(recordings), fitted.column)
    balances = HeatBalance.of_all(tire, chosen, fitted.column)
    for balance, start in zip(balances, fitted.starts, strict=True):
        course = balance.temperatures({}, np.array(start))
        supplied, stored = balance.energy({}, course)
        recorded = Series("points", balance.t, balance.measured - ZERO_CELSIUS, GRAY, "recorded", marker="o", size=2.0)
        colors = (BLUE, ORANGE, GREEN, RED)
        lines = [
            Series("line", balance.t, values - ZERO_CELSIUS, color, name)
            for name, values, color in zip(balance.states, course.T, colors, strict=True)
        ]
        title = figure_text(balance.source)
        panels.append(Panel("t (s)", "temperature (deg C)", (*lines, recorded), title=title))
        heats = {"from sliding and rolling": supplied, "to road and air": supplied - stored, "stored": stored}
        drawn = [
            Series("line", balance.t, heat / 1e3, color, name)
            for (name, heat), color in zip(heats.items(), (ORANGE, BLUE, GREEN), strict=True)
        ]
        panels.append(Panel("t (s)", "heat (kJ)", tuple(drawn), title=f"energy balance, {title}"))
    return Figure("temperature", "Temperature", in_rows(panels, 2), fitted.text())
