"""The temperature of the tread for effects that read it: recorded, or predicted from a heat balance.

A temperature in kelvin follows from the forces and from the temperatures of air and road, by the effect `temperature`
with the coefficients of the tire or their default values. Without these temperatures only the heat of sliding is known,
of which effects with a state of kind heat are functions.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ...measurements import Recording
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire

#: The effect that predicts temperatures, the input that effects of temperature read, and the surroundings.
EFFECT, TEMPERATURE, SURROUNDINGS = "temperature", "T", ("T_ambient", "T_road")
#: The temperatures with which a recording starts if the tire does not state them.
STARTS = ("THSTARTS", "THSTARTB", "THSTARTC", "THSTARTG")


def predicting(tire: Tire, recording: Recording) -> Tire:
    """Return a tire whose effects read the temperature that it predicts; it starts at that of its surroundings."""
    if EFFECT in tire.has:
        return tire.with_values(THACT=1.0)
    first = next(recording.table[name].iloc[0] for name in SURROUNDINGS if name in recording.table)
    return replace(tire, effects={*tire.has, EFFECT}).with_values(**dict.fromkeys(STARTS, float(first)), THACT=1.0)


def with_predicted_temperature(recording: Recording, tire: Tire) -> Recording:
    """Return a recording with the column T that a fitted tire predicts, deg C, if it was not recorded.

    A recording without time or speed, or without temperatures of the surroundings, is returned unchanged.
    """
    table = recording.table
    predictable = EFFECT in tire.has or any(name in table for name in SURROUNDINGS)
    if TEMPERATURE in table or not predictable or not {"t", "V"} <= set(table):
        return recording
    surface = evaluate(predicting(tire, recording), table, Conventions(recording.signs))["T_surface"]
    return replace(recording, table=table.assign(**{TEMPERATURE: surface - 273.15}))


def source_of_temperature(reading: Collection[str], identified: Collection[str], tire: Tire, recorded: bool) -> str:
    """Return which temperature identified effects read, in a sentence, or ''.

    `reading`: those that read T. `tire`: the baseline model with the equations of all candidates.

    >>> tire = Tire("mf96", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3})
    >>> source_of_temperature(["temp_friction"], ["temp_friction"], tire, recorded=True)
    'Temperature of temp_friction: recorded (T)'
    """
    heat = {effect.name for effect in tire.added if any(state.kind == "heat" for state in effect.states)}
    texts = {
        "recorded (T)" if recorded else f"predicted by the effect {EFFECT}": reading,
        "none in kelvin, but the heat of sliding": sorted(heat.intersection(identified)),
    }
    return "; ".join(f"Temperature of {' and '.join(names)}: {source}" for source, names in texts.items() if names)
