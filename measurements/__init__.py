"""Recordings of tire test benches, measured and virtual: reading, checks, operating conditions, excluded rows."""

from .channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
from .files.reading import READERS, read_recording
from .files.writing import write_table
from .operating_conditions.grouping import Grouping, group_by_condition
from .operating_conditions.levels import level_tolerance, levels
from .operating_conditions.phases import Phase, phases, transitions
from .operating_conditions.selection import Condition, Near, near, select
from .quality.coverage import Coverage, coverage, coverage_notes
from .quality.outliers import Outlier, outliers
from .quality.plausibility import check_plausible, convention_notes
from .quality.row_exclusion import EXCLUSION_REASONS, RowExclusion, exclude_rows
from .quality.tire_identity import identity_notes
from .recording import Recording
from .table_argument import TableLike, recording_from, recordings_from
from .units import to_si
from .virtual_bench.bench import TestedTire, VirtualBench
from .virtual_bench.programs import (
    Program,
    alpha_sweeps,
    concatenate,
    kappa_sweeps,
    small_tire_program,
    steady_points,
    trento_program,
)
from .virtual_bench.sensor_noise import ChannelNoise, Noise

__all__ = [
    "CHANNELS",
    "EXCLUSION_REASONS",
    "INPUTS",
    "OUTPUTS",
    "READERS",
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
    "RowExclusion",
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
    "exclude_rows",
    "group_by_condition",
    "identity_notes",
    "kappa_sweeps",
    "level_tolerance",
    "levels",
    "near",
    "outliers",
    "phases",
    "read_recording",
    "recording_from",
    "recordings_from",
    "select",
    "small_tire_program",
    "steady_points",
    "to_si",
    "transitions",
    "trento_program",
    "write_table",
]
