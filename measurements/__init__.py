"""Recordings of tire test benches, measured and virtual: reading, checking, slicing, making."""

from .bench import TestedTire, VirtualBench
from .channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
from .conditions import Condition, Near, levels, near, select, usual_tolerance
from .noise import ChannelNoise, Noise
from .plausibility import check_plausible, convention_notes
from .programs import (
    Program,
    alpha_sweeps,
    concatenate,
    kappa_sweeps,
    small_tire_program,
    steady_points,
    trento_program,
)
from .reading import READERS, read_recording
from .recording import Recording
from .units import to_si
from .writing import write_table

__all__ = [
    "CHANNELS",
    "INPUTS",
    "OUTPUTS",
    "READERS",
    "Channel",
    "ChannelNoise",
    "Condition",
    "Near",
    "Noise",
    "Program",
    "Recording",
    "TestedTire",
    "VirtualBench",
    "alpha_sweeps",
    "channel",
    "check_plausible",
    "concatenate",
    "convention_notes",
    "kappa_sweeps",
    "levels",
    "near",
    "read_recording",
    "select",
    "small_tire_program",
    "steady_points",
    "to_si",
    "trento_program",
    "usual_tolerance",
    "write_table",
]
