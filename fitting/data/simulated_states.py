"""States of effects in the data of a fit: simulated over each recording, then constant during a solution."""

from __future__ import annotations

import pandas as pd

from tirefmu.tires.tire import Tire

from .fit_data import FitData


def with_states(data: FitData, tire: Tire) -> pd.DataFrame:
    """Return the included rows of a fit with the states of a tire as columns.

    Excluded rows are simulated, too: a state remembers them.

    Parameters
    ----------
    data : FitData
    tire : Tire
        In adapted SAE, as the data.

    Returns
    -------
    pandas.DataFrame
    """
    names = list(tire.states)
    recordings = data.table.groupby("recording", sort=False)
    courses = pd.concat([tire.evaluate(part, signs=tire.signs)[names] for _, part in recordings])
    fitted = data.fitted
    return fitted.assign(**courses.loc[fitted.index])
