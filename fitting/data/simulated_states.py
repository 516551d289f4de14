"""States of effects in the data of a fit: simulated over each recording, then constant during a solution.

The states are simulated with the present values before each stage and again after it, and the stage is then repeated
(`STATE_ROUNDS`). Coefficients in the equations of states have no influence on a stage and stay at their values.
"""

from __future__ import annotations

from collections.abc import Collection

import pandas as pd

from ...measurements.recording import Recording
from ...measurements.state_starts import with_fitted_starts
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire
from .fit_data import FitData


def with_states(data: FitData, tire: Tire, free: Collection[str] = ()) -> pd.DataFrame:
    """Return the included rows of a fit with the states of a tire as columns.

    Excluded rows are simulated, too: a state remembers them. States with a fitted start begin each segment with the
    value that the measured forces determine (`tirefmu.measurements.state_starts`).

    `tire`: in adapted SAE, as the data. `free`: coefficients that are estimated together with fitted starts, but not
    returned.
    """
    names = list(tire.states)
    recordings = data.table.groupby("recording", sort=False)
    parts = [with_fitted_starts(tire, Recording(part, tire.signs, str(name)), free).table for name, part in recordings]
    courses = pd.concat([evaluate(tire, part, Conventions(tire.signs))[names] for part in parts])
    fitted = data.fitted
    return fitted.assign(**courses.loc[fitted.index])
