"""Short-range scatter of a residual, and the rows that are outliers in it."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...numerics.arrays import BoolArray, FloatArray

#: Outliers exceed twice this number of robust standard deviations of the short-range residual. Convention: twice,
#: because noise in proportion to the force is larger than its typical value where the force is.
OUTLIER = 7.0
#: Rows over which the short-range residual is centred. Convention: the mean of 15 rows has a quarter of their noise.
LOCAL_ROWS = 15


def short_range(residual: FloatArray, used: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Return the difference of a residual from its moving average, and the rows that are used and no outliers.

    `residual`, shape (n,): finite. `used`, shape (n,). Returns: both of shape (n,); the difference is 0 in rows that
    are not used.

    >>> residual = np.random.default_rng(0).normal(size=500)
    >>> residual[[7, 300]] = 60.0
    >>> np.flatnonzero(~short_range(residual, np.ones(500, dtype=bool))[1]).tolist()
    [7, 300]
    """
    scatter = np.where(used, residual - uniform_filter1d(residual, LOCAL_ROWS, mode="nearest"), 0.0)
    typical = 1.4826 * float(np.median(np.abs(scatter[used]))) + 1e-12 if used.any() else 0.0
    return scatter, np.asarray(used & (np.abs(scatter) < OUTLIER * 2.0 * typical))
