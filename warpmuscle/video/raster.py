"""Triangles as pixels: which of them is nearest to the eye in each, and where in it.

All triangles of a picture are taken apart into rows, and the rows into pixels; what is colour or light is computed
afterwards, once a pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers

MOST = 4_000_000  # rows, or pixels, that are taken apart at once


class Seen(NamedTuple):
    """The n pixels of a picture in which a triangle is seen."""

    pixel: Integers  # (n,) row * width + column
    face: Integers  # (n,) the triangle
    share: Floats  # (n, 3) of its corners in the point that is seen
    nearness: Floats  # (n,) 1/m, one over the depth

    def where(self, chosen: NDArray[np.bool_]) -> Seen:
        """Those of chosen pixels (n,)."""
        return Seen(self.pixel[chosen], self.face[chosen], self.share[chosen], self.nearness[chosen])


class _Rows(NamedTuple):
    """Pixels beside one another in the same triangle."""

    face: Integers  # (n,)
    pixel: Integers  # (n,) the first one
    length: Integers  # (n,)
    nearness: Floats  # (n,) 1/m in the first one
    change: Floats  # (n,) 1/m from each to the next

    def part(self, which: slice) -> _Rows:
        """Some of them."""
        face, pixel, length, nearness, change = self
        return _Rows(face[which], pixel[which], length[which], nearness[which], change[which])


def seen_triangles(flat: Floats, depth: Floats, faces: Integers, width: int, height: int) -> Seen:
    """The nearest triangle in each pixel.

    Args:
        flat: corners (V, 2), px from the left and the top. depth: (V,) m from the eye, above 0.
        faces: (T, 3), seen where they are clockwise in the picture, whose y points down.
    """
    corner, near = flat[faces], (1.0 / depth)[faces]
    run = corner - corner[:, :1]
    area = run[:, 1, 0] * run[:, 2, 1] - run[:, 1, 1] * run[:, 2, 0]
    top = np.maximum(np.ceil(corner[..., 1].min(axis=1) - 0.5), 0).astype(np.int64)
    bottom = np.minimum(np.floor(corner[..., 1].max(axis=1) - 0.5), height - 1).astype(np.int64)
    front = np.flatnonzero((area < 0.0) & (bottom >= top))
    corner, area, near = corner[front], area[front], near[front]
    factor = _edges(corner, area)
    slope = np.einsum("tk,tki->ti", near, factor)  # of the nearness, as of x, y and 1
    best_near = np.zeros(width * height)
    best_face = np.full(width * height, -1, dtype=np.int64)
    tall = bottom[front] - top[front] + 1
    for chosen in _chunks(tall):
        rows = _rows(chosen, tall[chosen], top[front][chosen], factor, slope, width)
        for part in _chunks(rows.length):
            _draw(rows.part(part), best_near, best_face)
    pixel = np.flatnonzero(best_face >= 0)
    face = best_face[pixel]
    place = np.stack([pixel % width + 0.5, pixel // width + 0.5, np.ones(len(pixel))], axis=1)
    weight = np.maximum(np.einsum("nki,ni->nk", factor[face], place), 0.0) * near[face]  # perspective
    share = weight / np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
    return Seen(pixel, front[face], share, best_near[pixel])


def _edges(corner: Floats, area: Floats) -> Floats:
    """Factors (T, 3, 3) of x, y and 1: their sum is the share of each corner (T, 3, 2) in a point."""
    start, end = np.roll(corner, -1, axis=1), np.roll(corner, -2, axis=1)  # of the edge opposite to a corner
    run = end - start
    constant = run[..., 1] * start[..., 0] - run[..., 0] * start[..., 1]
    return np.stack([-run[..., 1], run[..., 0], constant], axis=-1) / area[:, None, None]


def _chunks(count: Integers) -> list[slice]:
    """Parts of a list whose items count so much, each of at most `MOST`, or of one item."""
    ends, parts, begin = np.cumsum(count), [], 0
    while begin < len(count):
        before = ends[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, before + MOST, side="right")))
        parts.append(slice(begin, end))
        begin = end
    return parts


def _rows(chosen: slice, tall: Integers, top: Integers, factor: Floats, slope: Floats, width: int) -> _Rows:
    """The rows of triangles that have so many each, from their tops on."""
    face = np.repeat(np.arange(chosen.start, chosen.stop), tall)
    row = np.arange(len(face)) - np.repeat(np.cumsum(tall) - tall, tall) + np.repeat(top, tall)
    y = row + 0.5
    left, right = np.zeros(len(face)), np.full(len(face), float(width))
    for k in range(3):
        across, constant = factor[face, k, 0], factor[face, k, 1] * y + factor[face, k, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -constant / across
        left = np.where(across > 0.0, np.maximum(left, crossing), left)
        right = np.where(across < 0.0, np.minimum(right, crossing), right)
        right = np.where((across == 0.0) & (constant < 0.0), -1.0, right)
    first = np.ceil(left - 0.5).astype(np.int64)
    last = np.minimum(np.floor(right - 0.5).astype(np.int64), width - 1)
    there = np.flatnonzero(last >= first)
    face, row, first, last, y = face[there], row[there], first[there], last[there], y[there]
    nearness = slope[face, 0] * (first + 0.5) + slope[face, 1] * y + slope[face, 2]
    return _Rows(face, row * width + first, last - first + 1, nearness, slope[face, 0])


def _draw(rows: _Rows, best_near: Floats, best_face: Integers) -> None:
    """Put rows into the picture where they are nearer than what is there."""
    owner = np.repeat(np.arange(len(rows.length)), rows.length)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(rows.length) - rows.length, rows.length)
    pixel = rows.pixel[owner] + number
    nearness = rows.nearness[owner] + rows.change[owner] * number
    nearer = np.flatnonzero(nearness > best_near[pixel])
    order = nearer[np.argsort(nearness[nearer].astype(np.float32), kind="stable")]  # of several, the last is kept
    best_near[pixel[order]] = nearness[order]
    best_face[pixel[order]] = rows.face[owner[order]]
