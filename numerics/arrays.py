"""Types of NumPy arrays by their numbers, for annotations."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
#: Of indices of rows and columns, as NumPy returns them.
IndexArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]
