"""A window to work in: a page in the browser over a project, served on this computer only (`serve.py`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .data_view import recording_of
    from .project_state import ProjectState, Stale
    from .serve import Server
    from .work import Work

__getattr__, __dir__ = on_demand(__name__)
