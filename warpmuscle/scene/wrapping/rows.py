"""Paths over several surfaces in a row between two of their points, in float64; see `kernels.path.route_rows`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.path import Placed, Stop
from warpmuscle.scene.wrapping.touch import FREE

SWEEPS = 200  # over all surfaces of a path, at most
SETTLED = 1.0e-10  # m, by which no place of touch then moves any more

Bend = tuple[Floats, Floats, float]  # where a path reaches and leaves a surface, (3,) m, and how long it is there, m


def laid(points: Sequence[Floats], surfaces: Sequence[Placed]) -> list[Stop]:
    """The stops of the shortest path through points, over the surfaces between them in their order.

    Args:
        points: (3,) m each, world, which all count. surfaces: each between two neighbouring points.
    """
    bends: list[Bend | None] = [None if one.start is None else (one.start, one.start, 0.0) for one in surfaces]
    for _ in range(SWEEPS):
        moved = 0.0
        for w, one in enumerate(surfaces):
            before, after = _neighbours(w, points, surfaces, bends)
            ends = [one.rotation.T @ (place - one.position) for place in (before, after)]
            found = one.touch(*ends)
            old, bends[w] = bends[w], None
            if found.kind != FREE:
                places = [one.position + one.rotation @ place for place in (found.first, found.second)]
                bends[w] = places[0], places[1], found.length
            moved = max(moved, _moved(old, bends[w]))
        if moved < SETTLED:
            break
    stops: list[Stop] = []
    for k, point in enumerate(points):
        stops.append(Stop(point, point=k))
        for w, (one, bend) in enumerate(zip(surfaces, bends, strict=True)):
            if one.first == k and bend is not None:
                stops += [Stop(bend[0], wrap=w), Stop(bend[1], wrap=w, length=bend[2])]
    return stops


def _neighbours(
    w: int, points: Sequence[Floats], surfaces: Sequence[Placed], bends: Sequence[Bend | None]
) -> tuple[Floats, Floats]:
    """Where the segments before and behind a surface come from and lead to."""
    before, after = points[surfaces[w].first], points[surfaces[w].last]
    row = [k for k, one in enumerate(surfaces) if one.first == surfaces[w].first and bends[k] is not None]
    for k in (k for k in row if k < w):
        before = bends[k][1]  # type: ignore[index]
    for k in (k for k in reversed(row) if k > w):
        after = bends[k][0]  # type: ignore[index]
    return before, after


def _moved(old: Bend | None, new: Bend | None) -> float:
    """How far the farther place of touch has moved, m; without bounds where a path has come to a surface or left it."""
    if old is None or new is None:
        return 0.0 if old is new else np.inf
    return max(float(np.linalg.norm(old[k] - new[k])) for k in (0, 1))
