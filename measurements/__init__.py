"""Recordings of tire test benches, measured and virtual: reading, checks, operating conditions, excluded rows.

The names are loaded on first access: reading a table needs no SciPy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tirefmu.boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
    from .column_meaning.check import check_columns, column_notes
    from .column_meaning.limits import check_plausible
    from .files.reading import READERS, read_recording
    from .files.writing import write_table
    from .findings.data_findings import data_findings
    from .findings.finding import Finding
    from .findings.one_recording import incomplete_rows
    from .findings.residual_causes import residual_findings
    from .operating_conditions.grouping import Grouping, group_by_condition
    from .operating_conditions.levels import held_levels, level_tolerance, levels
    from .operating_conditions.phases import Phase, phases, transitions
    from .quality.coverage import Coverage, coverage, coverage_notes
    from .quality.outliers import Outlier, outliers
    from .quality.row_exclusion import EXCLUSION_REASONS, RowExclusion, exclude_rows
    from .recording import Recording
    from .row_selection.selected import selected
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

#: The module of each name.
_ON_DEMAND = {
    "CHANNELS": "channels",
    "EXCLUSION_REASONS": "quality.row_exclusion",
    "INPUTS": "channels",
    "OUTPUTS": "channels",
    "READERS": "files.reading",
    "Channel": "channels",
    "ChannelNoise": "virtual_bench.sensor_noise",
    "Coverage": "quality.coverage",
    "Finding": "findings.finding",
    "Grouping": "operating_conditions.grouping",
    "Noise": "virtual_bench.sensor_noise",
    "Outlier": "quality.outliers",
    "Phase": "operating_conditions.phases",
    "Program": "virtual_bench.programs",
    "Recording": "recording",
    "RowExclusion": "quality.row_exclusion",
    "TableLike": "table_argument",
    "TestedTire": "virtual_bench.bench",
    "VirtualBench": "virtual_bench.bench",
    "alpha_sweeps": "virtual_bench.programs",
    "channel": "channels",
    "check_columns": "column_meaning.check",
    "check_plausible": "column_meaning.limits",
    "column_notes": "column_meaning.check",
    "concatenate": "virtual_bench.programs",
    "coverage": "quality.coverage",
    "coverage_notes": "quality.coverage",
    "data_findings": "findings.data_findings",
    "exclude_rows": "quality.row_exclusion",
    "group_by_condition": "operating_conditions.grouping",
    "held_levels": "operating_conditions.levels",
    "incomplete_rows": "findings.one_recording",
    "kappa_sweeps": "virtual_bench.programs",
    "level_tolerance": "operating_conditions.levels",
    "levels": "operating_conditions.levels",
    "outliers": "quality.outliers",
    "phases": "operating_conditions.phases",
    "read_recording": "files.reading",
    "recording_from": "table_argument",
    "recordings_from": "table_argument",
    "residual_findings": "findings.residual_causes",
    "selected": "row_selection.selected",
    "small_tire_program": "virtual_bench.programs",
    "steady_points": "virtual_bench.programs",
    "to_si": "units",
    "transitions": "operating_conditions.phases",
    "trento_program": "virtual_bench.programs",
    "write_table": "files.writing",
}

__all__ = [
    "CHANNELS",
    "EXCLUSION_REASONS",
    "INPUTS",
    "OUTPUTS",
    "READERS",
    "Channel",
    "ChannelNoise",
    "Coverage",
    "Finding",
    "Grouping",
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
    "check_columns",
    "check_plausible",
    "column_notes",
    "concatenate",
    "coverage",
    "coverage_notes",
    "data_findings",
    "exclude_rows",
    "group_by_condition",
    "held_levels",
    "incomplete_rows",
    "kappa_sweeps",
    "level_tolerance",
    "levels",
    "outliers",
    "phases",
    "read_recording",
    "recording_from",
    "recordings_from",
    "residual_findings",
    "selected",
    "small_tire_program",
    "steady_points",
    "to_si",
    "transitions",
    "trento_program",
    "write_table",
]

__getattr__, __dir__ = on_demand(__name__, _ON_DEMAND)
