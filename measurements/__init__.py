"""Recordings of tire test benches, measured and virtual: reading, checks, operating conditions, excluded rows.

The names are loaded on first access: reading a table needs no SciPy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .channels import CHANNELS, INPUTS, OUTPUTS, Channel, channel
    from .files.reading import READERS, read_recording
    from .files.writing import write_table
    from .findings.data_findings import data_findings
    from .findings.finding import Finding
    from .findings.one_recording import incomplete_rows
    from .findings.residual_causes import residual_findings
    from .operating_conditions.grouping import Grouping, group_by_condition
    from .operating_conditions.levels import held_levels, level_tolerance, levels
    from .operating_conditions.phases import Phase, phases, transitions
    from .quality.convention import check_convention, convention_notes, fitting_conventions
    from .quality.coverage import Coverage, coverage, coverage_notes
    from .quality.outliers import Outlier, outliers
    from .quality.plausibility import check_plausible
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

#: The names of each module.
_NAMES = {
    "channels": "CHANNELS Channel INPUTS OUTPUTS channel",
    "files.reading": "READERS read_recording",
    "files.writing": "write_table",
    "findings.data_findings": "data_findings",
    "findings.finding": "Finding",
    "findings.one_recording": "incomplete_rows",
    "findings.residual_causes": "residual_findings",
    "operating_conditions.grouping": "Grouping group_by_condition",
    "operating_conditions.levels": "held_levels level_tolerance levels",
    "operating_conditions.phases": "Phase phases transitions",
    "quality.convention": "check_convention convention_notes fitting_conventions",
    "quality.coverage": "Coverage coverage coverage_notes",
    "quality.outliers": "Outlier outliers",
    "quality.plausibility": "check_plausible",
    "quality.row_exclusion": "EXCLUSION_REASONS RowExclusion exclude_rows",
    "recording": "Recording",
    "row_selection.selected": "selected",
    "table_argument": "TableLike recording_from recordings_from",
    "units": "to_si",
    "virtual_bench.bench": "TestedTire VirtualBench",
    "virtual_bench.programs": "Program alpha_sweeps concatenate kappa_sweeps "
    "small_tire_program steady_points trento_program",
    "virtual_bench.sensor_noise": "ChannelNoise Noise",
}
#: The module of each name.
_ON_DEMAND = {name: module for module, names in _NAMES.items() for name in names.split()}

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
    "check_convention",
    "check_plausible",
    "concatenate",
    "convention_notes",
    "coverage",
    "coverage_notes",
    "data_findings",
    "exclude_rows",
    "fitting_conventions",
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


def __getattr__(name: str) -> Any:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_ON_DEMAND[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)
