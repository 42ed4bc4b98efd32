"""Paths that go round several surfaces one after the other, as OpenSim 4.6 finds them (GeometryPath)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.touch import BESIDE, FREE, INSIDE, THROUGH, Touch

ROUNDS = 8  # of a path with several surfaces, each beginning where the one before ended ...
SETTLED = 5e-4  # m, by which the length then changes no more


class Placed(NamedTuple):
    """A surface that a path may wrap around, in one pose of the body that has it."""

    touch: Callable[[Floats, Floats], Touch]  # of a segment, in the axes of the surface
    rotation: Floats  # (3, 3) from these axes to the world's
    position: Floats  # (3,) m, world
    name: str
    first: int  # of the points between which the path wraps, counted from 0
    last: int
    start: Floats | None = None  # (3,) m, world, where a path in a row touches it at first


@dataclass(frozen=True)
class Stop:
    """A point that a path runs through: one of its own, or where it reaches or leaves a surface."""

    place: Floats  # (3,) m, world
    point: int = -1  # which of the path's own points
    wrap: int = -1  # or which wrap
    length: float = 0.0  # m, from the stop before on a surface; only of the one that leaves it
    share: float = 1.0  # what the way from the stop before counts, see `validation.paths.shares`


def wrapped(
    points: Sequence[Floats], active: Sequence[bool], surfaces: Sequence[Placed], exact: bool = False
) -> list[Stop]:
    """The stops of a path, in order.

    OpenSim measures straight segments between the places where the path first reached and left each surface, which
    are cached in its state, though all rounds go on from the new ones; lengths on surfaces are those of the last round.
    Between these places it also measures the detours of which it chooses the shortest.

    Args:
        points: (3,) m each, world. active: which of them count. surfaces: in the order of the path's wraps.
        exact: whether the places follow, too, so that the path of several surfaces becomes the shortest one.
    """
    first: dict[int, list[Floats]] = {}
    stops = [Stop(place, point=k) for k, (place, on) in enumerate(zip(points, active, strict=True)) if on]
    order, before = list(range(len(surfaces))), np.inf
    for turn in range(min(len(surfaces), 1) if len(surfaces) < 2 else ROUNDS):
        kinds = []
        for wrap in order:
            stops = [stop for stop in stops if stop.wrap != wrap]
            stops, kind = _round(stops, wrap, surfaces, first)
            if not exact and (around := [stop.place for stop in stops if stop.wrap == wrap]):
                first.setdefault(wrap, around)
            kinds.append(kind)
        length = path_length(_kept(stops, first))
        if abs(length - before) < SETTLED:
            break
        before = length
        if turn == 0 and kinds[:2] == [FREE, INSIDE]:
            order[:2] = 1, 0
            stops = [stop for stop in stops if stop.wrap != 0]
    return _kept(stops, first)


def _kept(stops: list[Stop], first: Mapping[int, list[Floats]]) -> list[Stop]:
    """The stops with those on surfaces where the path first touched them."""
    left = {wrap: iter(places) for wrap, places in first.items()}
    return [replace(stop, place=next(left[stop.wrap])) if stop.wrap in left else stop for stop in stops]


def path_length(stops: Sequence[Stop]) -> float:
    """Length of a path, m."""
    total = 0.0
    for before, stop in itertools.pairwise(stops):
        on = stop.wrap >= 0 and before.wrap == stop.wrap
        total += stop.share * (stop.length if on else float(np.linalg.norm(stop.place - before.place)))
    return total


def _round(
    stops: list[Stop], wrap: int, surfaces: Sequence[Placed], first: Mapping[int, list[Floats]]
) -> tuple[list[Stop], int]:
    """The stops with those where the path reaches and leaves a surface, and what its last segment did there."""
    surface, kind, measured = surfaces[wrap], FREE, _kept(stops, first)
    own = [k for k, stop in enumerate(stops) if stop.point >= 0 and surface.first <= stop.point <= surface.last]
    best: tuple[float, int, list[Stop]] | None = None
    for k in range(own[0], own[-1]) if own else ():
        a, b = stops[k], stops[k + 1]
        if a.wrap >= 0 and b.wrap >= 0 and surfaces[a.wrap].name == surfaces[b.wrap].name:
            continue
        ends = [surface.rotation.T @ (stop.place - surface.position) for stop in (a, b)]
        touch = surface.touch(*ends)
        kind = touch.kind
        if kind in (BESIDE, THROUGH):
            reached, left = (surface.position + surface.rotation @ place for place in (touch.first, touch.second))
            around = [Stop(reached, wrap=wrap), Stop(left, wrap=wrap, length=touch.length)]
            a, b = measured[k], measured[k + 1]
            detour = path_length([a, *around, b]) - float(np.linalg.norm(b.place - a.place))
            if kind == THROUGH or best is None or detour < best[0]:
                best = detour, k, around
            if kind == THROUGH:
                break
    if best is None:
        return stops, kind
    _, k, around = best
    return [*stops[: k + 1], *around, *stops[k + 1 :]], kind
