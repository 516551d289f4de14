"""Many tires: fits of a list of jobs, on processes of this machine or on a Dask cluster.

Nothing is imported here: a process that runs tasks imports what they need.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .execution import Lost, completed, completed_on_cluster
    from .fit_many import Batch, run, task_of
    from .intervals import cross_validate
    from .jobs import OPTIONS, FitJob, read_jobs
    from .records import JobResult
    from .study_file import KEYS, read_study

__getattr__, __dir__ = on_demand(__name__)
