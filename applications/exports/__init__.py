"""Tires for other programs: code in their language (`printout.py`), property files that they accept.

`convert` and `lint` are modules here; their functions are `tirefmu.convert` and `tirefmu.lint`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .convert import relative_errors, without_added
    from .dialects import HOSTS
    from .lacking import acting
    from .printout import generate, printed, program_of
    from .self_test import operating_conditions, reference

__getattr__, __dir__ = on_demand(__name__)
