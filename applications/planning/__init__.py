"""Test programs of a bench: what a program determines, the program that determines the most, the one that separates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .bench_file import Bench, Heat, Limits, PlanError, example_text, read_bench
    from .program import change_time, program_from
    from .separation import pairs_of, plan_between

__getattr__, __dir__ = on_demand(__name__)
