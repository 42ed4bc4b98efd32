"""How curves of a muscle's own lie in a table on the device, as `shaped_family.looked_up` reads them.

First come the ends of each curve, then each one's values and slopes times knot distance, at equal distances.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate

import numpy as np
import warp as wp


def places_of(intervals: Mapping[str, int]) -> tuple[dict[str, wp.vec3i], int]:
    """Where curves stand: the row with its ends, the row of its first knot, intervals; and the rows of the table.

    Args:
        intervals: of each curve, between its knots.
    """
    heads = len(intervals)
    starts = [heads, *(heads + end for end in accumulate(n + 1 for n in intervals.values()))]
    return {name: wp.vec3i(k, starts[k], n) for k, (name, n) in enumerate(intervals.items())}, starts[-1]


def put_curve(table: np.ndarray, place: wp.vec3i, x: np.ndarray, value: np.ndarray, slope: np.ndarray) -> None:
    """Put a curve into a table (rows, 2): x at equal distances, with values and slopes there."""
    head, first, intervals = (int(number) for number in place)
    table[head] = x[0], x[-1]
    table[first : first + intervals + 1] = np.stack([value, slope * (x[1] - x[0])], axis=1)
