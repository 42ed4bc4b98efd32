"""Bones whose parts flow into one another: the surface of a distance that rods and ellipsoids share; numbers only.

Distances are joined by a smooth minimum (Ricci 1973), and the surface is drawn by surface nets (Gibson 1998): a corner
in each cell that the surface passes, in the middle of where it crosses the cell's edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.ndimage import map_coordinates

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.view.hulls import Mesh

REACH = 7.0  # of the blend, beyond which a part counts for nothing
OUTSIDE = 1.0e-6  # of what parts add up to, where there is none
STEEP = 2.5  # cells, of the surface, within which distances are needed
MOST = 200_000  # cells, of the parts' own box


@dataclass(frozen=True)
class Rod:
    """A chain of round cones along points (N, 3), with a radius at each."""

    points: Floats
    radii: Floats

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest corner (3,) of a box around it."""
        radii = self.radii[:, None]
        return (self.points - radii).min(axis=0), (self.points + radii).max(axis=0)

    def seen_along(self, axes: Floats) -> Rod:
        """The same by its parts along axes, which are columns (3, 3)."""
        return Rod(self.points @ axes, self.radii)

    def distance(self, places: Floats) -> Floats:
        """From its surface to places (..., 3), below 0 within."""
        found = np.full(places.shape[:-1], np.inf)
        for k in range(len(self.points) - 1):
            along = self.points[k + 1] - self.points[k]
            away = places - self.points[k]
            part = np.clip(away @ along / max(float(along @ along), 1e-18), 0.0, 1.0)
            radius = self.radii[k] + part * (self.radii[k + 1] - self.radii[k])
            found = np.minimum(found, np.linalg.norm(away - part[..., None] * along, axis=-1) - radius)
        return found


@dataclass(frozen=True)
class Egg:
    """An ellipsoid about a point (3,), whose axes are the columns of `turn` (3, 3)."""

    center: Floats
    radii: Floats
    turn: Floats

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest corner (3,) of a box around it."""
        reach = np.linalg.norm(self.turn * self.radii, axis=1)
        return self.center - reach, self.center + reach

    def seen_along(self, axes: Floats) -> Egg:
        """The same by its parts along axes, which are columns (3, 3)."""
        return Egg(self.center @ axes, self.radii, axes.T @ self.turn)

    def distance(self, places: Floats) -> Floats:
        """From its surface to places (..., 3), of first order, below 0 within."""
        local = (places - self.center) @ self.turn / self.radii
        far, steep = np.linalg.norm(local, axis=-1), np.linalg.norm(local / self.radii, axis=-1)
        return np.asarray(far * (far - 1.0) / np.maximum(steep, 1e-9))


Part = Rod | Egg


def rod(points: Sequence[Floats | Sequence[float]] | Floats, radii: float | Sequence[float] | Floats) -> Rod:
    """A chain of round cones along points (N, 3), with one radius, or one at each."""
    way = np.asarray(points, dtype=np.float64)
    return Rod(way, np.broadcast_to(np.asarray(radii, dtype=np.float64), len(way)))


def egg(center: Floats | Sequence[float], radii: Sequence[float], turn: Floats | None = None) -> Egg:
    """An ellipsoid; `turn` has its axes as columns (3, 3), by default those of the body."""
    return Egg(
        np.asarray(center, dtype=np.float64), np.asarray(radii, dtype=np.float64), np.eye(3) if turn is None else turn
    )


def fan(lower: Floats, upper: Floats, thin: float, thick: float) -> list[Part]:
    """A plate of rods from points (N, 3) to as many others, with a radius at either end."""
    return [rod([a, b], [thin, thick]) for a, b in zip(lower, upper, strict=True)]


def blended(
    parts: Sequence[Part], cell: float, blend: float, hollows: Sequence[Part] = (), axes: Floats | None = None
) -> Mesh:
    """The surface of parts, less hollows, of triangles about as large as cells.

    Args:
        cell: edge of the cubic cells in which the surface is looked for; thinner parts are lost. Cells are larger where
            there would be more than `MOST`.
        blend: about how far from one another parts flow together, in the same unit.
        axes: of the cells, as columns (3, 3); few cells are needed where one axis is along the bone.
    """
    if axes is not None:
        corners, normals, faces = blended(
            [part.seen_along(axes) for part in parts], cell, blend, [part.seen_along(axes) for part in hollows]
        )
        return corners @ axes.T, normals @ axes.T, faces
    boxes = [part.bounds for part in parts]
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    cell = max(cell, float(np.cbrt(np.prod(high - low) / MOST)))
    low, high = low - 3.0 * cell, high + 3.0 * cell
    margin = max(REACH * blend, 2.0 * cell)
    count = np.ceil((high - low) / cell).astype(int) + 1
    inside = _shares(parts, low, cell, count, blend, margin)
    field = -blend * np.log(np.maximum(inside, OUTSIDE))
    if hollows:
        cut = blend * np.log(np.maximum(_shares(hollows, low, cell, count, blend, margin), OUTSIDE))
        field = np.maximum(field, cut)
    return _net(field, low, cell)


def _shares(
    parts: Sequence[Part], low: Floats, cell: float, count: Floats, blend: float, margin: float
) -> Floats:  # fmt: skip
    """Sum of exp(-distance / blend) over parts at the corners of a grid; those far from a part are left out."""
    found = np.zeros(count)
    for part in parts:
        begin, end = part.bounds
        first = np.maximum(np.floor((begin - margin - low) / cell).astype(int), 0)
        last = np.minimum(np.ceil((end + margin - low) / cell).astype(int) + 1, count)
        if (last <= first).any():
            continue
        axes = [low[k] + cell * np.arange(first[k], last[k]) for k in range(3)]
        places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        at = tuple(slice(a, b) for a, b in zip(first, last, strict=True))
        found[at] += np.exp(np.minimum(-part.distance(places) / blend, 60.0))
    return found


def _net(field: Floats, low: Floats, cell: float) -> Mesh:
    """Corners, normals and faces of where a field (X, Y, Z) is 0, counter-clockwise from where it is above."""
    inside = field < 0.0
    shape = np.array(field.shape) - 1
    sums, crossings = np.zeros((*shape, 3)), np.zeros(tuple(shape))
    for axis in range(3):
        others = [k for k in range(3) if k != axis]
        for steps in product((0, 1), repeat=2):
            begin = np.zeros(3, dtype=int)
            begin[others] = steps
            end = begin + np.eye(3, dtype=int)[axis]
            one, two = (field[tuple(slice(k, k + n) for k, n in zip(at, shape, strict=True))] for at in (begin, end))
            cut = (one < 0.0) != (two < 0.0)
            part = np.where(cut, one / np.where(cut, one - two, 1.0), 0.0)
            place = np.broadcast_to(begin.astype(np.float64), (*shape, 3)).copy()
            place[..., axis] += part
            sums += cut[..., None] * place
            crossings += cut
    held = crossings > 0
    number = np.full(tuple(shape), -1)
    number[held] = np.arange(int(held.sum()))
    places = np.argwhere(held) + sums[held] / crossings[held][:, None]
    faces = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for way in (True, False):
            near, far = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
            cut = np.moveaxis((near & ~far) if way else (~near & far), 0, axis)
            edges = np.argwhere(cut)
            da, db = np.eye(3, dtype=int)[a], np.eye(3, dtype=int)[b]
            ring = [number[tuple((edges - step).T)] for step in (0 * da, da, da + db, db)]
            p, q, r, s = ring if way else ring[::-1]
            faces += [np.stack([p, q, r], axis=1), np.stack([p, r, s], axis=1)]
    clipped = np.clip(field, -STEEP * cell, STEEP * cell)  # beyond, there are no shares any more
    slopes = np.gradient(clipped / cell)
    for _ in range(2):  # onto the surface between the corners of cells
        off = map_coordinates(clipped / cell, places.T, order=3)
        slope = np.stack([map_coordinates(one, places.T, order=1) for one in slopes], axis=1)
        places -= np.clip(off / np.maximum(np.sum(slope**2, axis=1), 0.25), -0.5, 0.5)[:, None] * slope
    normals = np.stack([map_coordinates(one, places.T, order=1) for one in slopes], axis=1)
    return low + cell * places, normalized(normals, 1e-9), np.concatenate(faces)
