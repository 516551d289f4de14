"""Effective sample size: the number of independent rows that contain the same information as correlated ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .correlation_length import correlation_length


def effective_sample_size(residuals: ArrayLike, segments: Sequence[slice] | None = None) -> float:
    """Return the effective sample size of residuals.

    Parameters
    ----------
    residuals : array_like, shape (n,)
        Measured minus model. NaN where nothing was measured.
    segments : sequence of slice, optional
        `Recording.segments`. Default: one segment.

    Returns
    -------
    float
        The number of finite residuals divided by their `correlation_length`.

    Raises
    ------
    DataError
        If no residual is finite.

    Examples
    --------
    >>> noise = np.random.default_rng(0).standard_normal(2000)
    >>> bool(effective_sample_size(noise) > 1700.0), bool(effective_sample_size(np.repeat(noise, 8)) < 2300.0)
    (True, True)
    """
    values = np.asarray(residuals, dtype=np.float64)
    return float(np.isfinite(values).sum() / correlation_length(values, segments))
