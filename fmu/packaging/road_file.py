"""The file of an FMU with the road inside it, which wrapper/road.c reads."""

from __future__ import annotations

import struct

import numpy as np

from ...tires.roads.road import Road

#: The file inside an FMU, its format, and the length over which slopes are taken: that of a contact patch, m.
ROAD_FILE = "resources/road.bin"
_FORMAT, _LENGTH = b"TIREROAD", 0.1


def road_file(road: Road) -> bytes:
    """Return the file with a road, little-endian.

    >>> road_file(Road(1.0, np.array([-1.0, 1.0]), np.zeros((2, 2)), np.zeros(2)))[:8]
    b'TIREROAD'
    """
    n, m = road.heights.shape
    header = struct.pack("<8sQQdd", _FORMAT, n, m, road.increment, _LENGTH)
    numbers = (road.nodes, road.ahead, road.across, road.v, road.heights)
    return header + b"".join(np.ascontiguousarray(values, dtype="<f8").tobytes() for values in numbers)
