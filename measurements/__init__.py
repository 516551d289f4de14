"""Recordings of tire test benches, measured and virtual: reading, checking, screening, slicing, making."""

from .bench import TestedTire, VirtualBench
from .channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
from .conditions import Condition, Near, levels, near, select, usual_tolerance
from .coverage import Coverage, coverage, coverage_notes, identity_notes
from .independence import Grouping, group_by_condition
from .noise import ChannelNoise, Noise
from .outliers import Outlier, outliers
from .phases import Phase, phases, transitions
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
from .screening import REASONS, Screening, screen
from .table_argument import TableLike, recording_from, recordings_from
from .units import to_si
from .writing import write_table

__all__ = [
    "CHANNELS",
    "INPUTS",
    "OUTPUTS",
    "READERS",
    "REASONS",
    "Channel",
    "ChannelNoise",
    "Condition",
    "Coverage",
    "Grouping",
    "Near",
    "Noise",
    "Outlier",
    "Phase",
    "Program",
    "Recording",
    "Screening",
    "TableLike",
    "TestedTire",
    "VirtualBench",
    "alpha_sweeps",
    "channel",
    "check_plausible",
    "concatenate",
    "convention_notes",
    "coverage",
    "coverage_notes",
    "group_by_condition",
    "identity_notes",
    "kappa_sweeps",
    "levels",
    "near",
    "outliers",
    "phases",
    "read_recording",
    "recording_from",
    "recordings_from",
    "screen",
    "select",
    "small_tire_program",
    "steady_points",
    "to_si",
    "transitions",
    "trento_program",
    "usual_tolerance",
    "write_table",
]
