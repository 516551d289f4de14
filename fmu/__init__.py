"""Tires as FMUs: native export for FMI 2.0 and 3.0, and the check against data."""

from .build import export
from .check import Channel, CheckResult, WorstPoint, check

__all__ = ["Channel", "CheckResult", "WorstPoint", "check", "export"]
