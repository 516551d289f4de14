"""Recordings of tire test benches, measured and virtual: reading, checks, operating conditions, excluded rows.

The names are loaded on first access: reading a table needs no SciPy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..boundary.on_demand import on_demand

if TYPE_CHECKING:
    from ..symbolic.channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
    from .checks.columns.check import check_columns, column_notes
    from .checks.columns.limits import check_plausible
    from .checks.recordings.data_findings import data_findings
    from .checks.recordings.finding import DataFinding
    from .checks.recordings.one_recording import incomplete_rows
    from .checks.recordings.residual_causes import residual_findings
    from .checks.rows.coverage import Coverage, coverage, coverage_notes
    from .checks.rows.outliers import Outlier, outliers
    from .checks.rows.row_exclusion import EXCLUSION_REASONS, RowExclusion, exclude_rows
    from .evaluation import predicted_outputs
    from .files.reading import READERS, read_recording
    from .files.writing import write_table
    from .inspection.figures import inspection_figures
    from .inspection.inspection import inspected
    from .interpretation import Interpretation
    from .nominal_values import check_nominal, check_radius, rounded_median
    from .operating_conditions.grouping import Grouping, group_by_condition
    from .operating_conditions.levels import held_levels, level_tolerance, levels
    from .operating_conditions.phases import Phase, phases, transitions
    from .provenance import table_digest
    from .recording import Recording
    from .row_selection.selected import selected
    from .state_starts import with_fitted_starts
    from .table_argument import TableLike, recording_from, recordings_from
    from .terms import TERMS, words_of
    from .turn_slip import with_turn_slip
    from .units import POUND, PSI, UNITS, to_si, unit_named
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
    from .virtual_bench.sensor_noise import ChannelNoise, Noise, correlated

__all__ = [
    "CHANNELS", "EXCLUSION_REASONS", "INPUTS", "OUTPUTS", "READERS", "Channel", "ChannelNoise", "Coverage",
    "DataFinding", "Grouping", "Noise", "Outlier", "Phase", "Program", "Recording", "RowExclusion", "TableLike",
    "TestedTire", "VirtualBench", "alpha_sweeps", "channel", "check_columns", "check_plausible",
    "column_notes", "concatenate",
    "coverage", "coverage_notes", "data_findings", "exclude_rows", "group_by_condition", "held_levels",
    "incomplete_rows", "kappa_sweeps", "level_tolerance", "levels", "outliers", "phases", "read_recording",
    "recording_from", "recordings_from", "residual_findings", "selected", "small_tire_program", "steady_points",
    "to_si", "transitions", "trento_program", "write_table",
]  # fmt: skip

__getattr__, __dir__ = on_demand(__name__)
