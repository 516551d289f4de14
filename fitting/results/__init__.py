"""The result of a fit and its summary."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .fit_content import FitContent
    from .records import BoundConsequence, ChannelFit, quality
    from .verdict import FORM_OF_FORCE, GOOD, UNUSABLE, lacks_something, verdict_of

__getattr__, __dir__ = on_demand(__name__)
