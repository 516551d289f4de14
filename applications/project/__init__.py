"""A project file: which data, fit, export and checks belong together, and the run that redoes what has changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .project_file import SECTIONS, Project, project_text, read_project
    from .records import Records
    from .run import TimeLimitReached, run_limited, run_project
    from .steps import steps_of

__getattr__, __dir__ = on_demand(__name__)
