"""Tires as FMUs: native export for FMI 2.0 and 3.0, simulation, and comparison with data."""

from .comparison.check import check
from .comparison.result import Channel, CheckResult, WorstPoint
from .packaging.export import export

__all__ = ["Channel", "CheckResult", "WorstPoint", "check", "export"]
