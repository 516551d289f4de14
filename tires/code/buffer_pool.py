"""Memory of large results, reused after the caller has dropped them.

The C library returns a large array to the system as soon as it is dropped, and the system clears the pages of the next
one. For the derivatives of a million rows this takes a quarter of the time of their computation; on a virtual machine
that returns free pages to its host, up to three times that time. The memory of a dropped result is therefore reused for
the next one.
"""

from __future__ import annotations

import math
from collections import deque
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: Numbers from which the C library requests memory from the system for each array (glibc: from at most 32 MB on).
LARGE = 2**22


class BufferPool:
    """Memory for large results, which is used again when a result and all its views are gone.

    `most`: numbers that are kept for later results (2**26: 512 MB).

    >>> memory = BufferPool()
    >>> first = memory.empty((5, 1_000_000))
    >>> address, view = first.ctypes.data, first[0]
    >>> del first
    >>> memory.empty((5, 1_000_000)).ctypes.data == address  # the view still uses it
    False
    >>> del view
    >>> memory.empty((1_000_000, 5)).ctypes.data == address
    True
    """

    def __init__(self, most: int = 2**26) -> None:
        self._most = most
        # Each of its operations is atomic for other threads and for objects that are deleted meanwhile.
        self._kept: deque[FloatArray] = deque()

    def empty(self, shape: tuple[int, ...]) -> FloatArray:
        """Return an array whose values are arbitrary, as `numpy.empty` does."""
        size = math.prod(shape)
        return np.empty(shape) if size < LARGE else np.asarray(_Loan(self, self._of_size(size), shape))

    def keep(self, memory: FloatArray) -> None:
        """Keep memory without references, and release the oldest kept memory."""
        if memory.size > self._most:
            return
        self._kept.append(memory)
        with suppress(IndexError):  # another thread was faster
            while sum(kept.size for kept in tuple(self._kept)) > self._most:
                self._kept.popleft()

    def _of_size(self, size: int) -> FloatArray:
        """Return memory for numbers: the last kept memory if it is at most a quarter larger, otherwise new memory."""
        others: deque[FloatArray] = deque()
        suitable = None
        with suppress(IndexError):
            while suitable is None:
                memory = self._kept.pop()
                if size <= memory.size <= size + size // 4:
                    suitable = memory
                else:
                    others.appendleft(memory)
        self._kept.extend(others)
        return np.empty(size) if suitable is None else suitable


class _Loan:
    """Lends memory to an array and its views, which refer to this object as long as one of them exists."""

    def __init__(self, owner: BufferPool, memory: FloatArray, shape: tuple[int, ...]) -> None:
        self._owner, self._memory = owner, memory
        self.__array_interface__: dict[str, Any] = {**memory.__array_interface__, "shape": shape}

    def __del__(self) -> None:
        self._owner.keep(self._memory)


#: The memory of this process.
RESULTS = BufferPool()
