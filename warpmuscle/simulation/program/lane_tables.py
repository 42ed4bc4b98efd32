"""Which lane gathers what, where the lanes of a warp share a programme."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import starts, to_device
from warpmuscle.kernels.program.lanes import LANES
from warpmuscle.kernels.program.structs import Columns

NONE = -1


def put_lane_tables(columns: Columns, rows: Sequence[Sequence[int]], coordinates: int, device: Any) -> None:
    """Put in the tables by which lanes gather what makes up the balance of a coordinate, and a place of its slope.

    Args:
        rows: of each control the coordinates on which it acts.
    """
    begin = starts(map(len, rows))
    owners = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
    lines: list[list[tuple[int, ...]]] = [[] for _ in range(coordinates)]
    pairs: list[list[tuple[int, ...]]] = [[] for _ in range(coordinates * (coordinates + 1) // 2)]
    for j, one in enumerate(rows):
        for a, i in enumerate(one):
            lines[i].append((begin[j] + a,))
            for b, k in enumerate(one[: a + 1]):
                pairs[i * (i + 1) // 2 + k].append((begin[j] + a, begin[j] + b))
    columns.owner = to_device(owners, int, device)
    for name, lists, dtype in (("line", lines, int), ("pair", pairs, wp.vec2i)):
        heights, target, cells = table_of(lists, 1 if dtype is int else 2)
        setattr(columns, name, to_device(starts(heights), int, device))
        setattr(columns, f"{name}_target", to_device(np.array(target), int, device))
        setattr(columns, f"{name}_entry", wp.array(cells, dtype=dtype, device=device))


def table_of(
    lists: Sequence[Sequence[tuple[int, ...]]], width: int
) -> tuple[list[int], list[int], np.ndarray[Any, Any]]:
    """Lists of so many numbers an item as columns of a table of `LANES` columns, long ones beside long ones.

    Lanes of a warp then read neighbouring numbers, and wait little for each other.

    Returns:
        How many rows each group of columns has, whose each of them is, and the cells of all rows one after the other;
        `NONE` stands where nothing does.
    """
    order = sorted(range(len(lists)), key=lambda k: -len(lists[k]))
    groups = [order[k : k + LANES] for k in range(0, len(order), LANES)]
    heights = [len(lists[group[0]]) for group in groups]
    cells = np.full((sum(heights), LANES, width), NONE, dtype=np.int32)
    first = 0
    for group, height in zip(groups, heights, strict=True):
        for column, k in enumerate(group):
            if lists[k]:
                cells[first : first + len(lists[k]), column] = lists[k]
        first += height
    target = [k for group in groups for k in group + [NONE] * (LANES - len(group))]
    flat = cells.reshape(-1, width)
    return heights, target, flat[:, 0] if width == 1 else flat
