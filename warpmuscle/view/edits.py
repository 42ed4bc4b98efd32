"""What was changed of a scene by hand, and the scene with these changes; what was free in it stays free."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Excitation, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import rebuilt
from warpmuscle.view.editing.numbers import CurveKnots


class Point(NamedTuple):
    """A knot of a curve that was changed.

    Attributes:
        origin: its place in the scene's curve, -1 of a new one. at, value: None where they are the scene's.
    """

    origin: int
    at: float | None = None
    value: float | None = None


@dataclass(frozen=True)
class Edits:
    """Changes by key: of numbers, and of curves with all their knots in order."""

    numbers: Mapping[str, float] = field(default_factory=dict)
    curves: Mapping[str, tuple[Point, ...]] = field(default_factory=dict)

    def points(self, curve: CurveKnots) -> tuple[Point, ...]:
        """The knots of a curve as they are now."""
        return self.curves.get(curve.key, tuple(Point(place) for place in range(curve.knots)))


def edited(scene: Scene, curves: Mapping[str, CurveKnots], edits: Edits) -> Scene:
    """A copy of a scene with changes.

    A free parameter stays one, and its interval reaches as far as the new value. A number that follows another one
    stands alone once it is changed. Numbers that follow a knot go on doing so wherever it is now.

    Raises:
        SceneError: a number cannot have its value, or a change names no number or curve of the scene.
    """
    given = dict(edits.numbers)
    for key, points in edits.curves.items():
        for name, place in ((curves[key].across, 1), (curves[key].along, 2)):
            values = {f"{key}.{name}.{point.origin}": point[place] for point in points if point.origin >= 0}
            given |= {leaf: value for leaf, value in values.items() if value is not None}
    found: set[str] = set()

    def replaced(key: str, leaf: Any) -> Any:
        if isinstance(leaf, Free) and leaf.per:
            per = leaf.with_rates(lambda name, rate: replaced(f"{key}.{name}", rate))
            leaf = msgspec.structs.replace(leaf, per=per)
        if key not in given:
            return leaf
        found.add(key)
        return _with_value(key, leaf, given[key])

    changed = rebuilt(scene, replaced)
    if lost := given.keys() - found:
        raise SceneError("the scene has no such number", key=min(lost))
    return _rearranged(changed, curves, edits)


def _with_value(key: str, leaf: Any, value: float) -> Any:
    """What stands in place of a number so that it has another value."""
    if not isinstance(leaf, Free) or leaf.same_as:
        return value
    try:
        if leaf.min is None or leaf.max is None:
            return msgspec.structs.replace(leaf, value=value)
        return msgspec.structs.replace(leaf, value=value, min=min(leaf.min, value), max=max(leaf.max, value))
    except ValueError as error:
        raise SceneError(str(error), key=key) from None


def _rearranged(scene: Scene, curves: Mapping[str, CurveKnots], edits: Edits) -> Scene:
    """Put new knots into curves of a scene, which is changed, and take others out."""
    moved: dict[str, str] = {}
    gone: dict[str, float] = {}
    for key, points in edits.curves.items():
        curve, origins = curves[key], [point.origin for point in points]
        if origins == list(range(curve.knots)):
            continue
        owner = _at(scene, curve.path)
        if owner is None:  # the only curve that a scene may lack here
            owner = Excitation([], [])
            setattr(_at(scene, curve.path[:-1]), curve.path[-1], owner)
        for name, place in ((curve.across, 1), (curve.along, 2)):
            before = getattr(owner, name)
            setattr(owner, name, [point[place] if point.origin < 0 else before[point.origin] for point in points])
            for origin, number in enumerate(before):
                if origin in origins:
                    moved[f"{key}.{name}.{origin}"] = f"{key}.{name}.{origins.index(origin)}"
                elif isinstance(number, Free) and number.value is not None:
                    gone[f"{key}.{name}.{origin}"] = number.value
    if not moved and not gone:
        return scene

    def following(_: str, leaf: Any) -> Any:
        if not isinstance(leaf, Free) or not leaf.same_as:
            return leaf
        if leaf.same_as in gone:
            return leaf.following(gone[leaf.same_as])
        return msgspec.structs.replace(leaf, same_as=moved.get(leaf.same_as, leaf.same_as))

    return rebuilt(scene, following)


def _at(scene: Scene, path: tuple[str, ...]) -> Any:
    """The part of a scene at a path."""
    part: Any = scene
    for name in path:
        if isinstance(part, dict):
            part = part[name]
        elif isinstance(part, list | tuple):
            part = part[int(name)]
        else:
            part = getattr(part, name)
    return part


def key_now(curves: Mapping[str, CurveKnots], edits: Edits, key: str) -> str | None:
    """What a number of the scene is called after changes, None if it is gone with its knot."""
    owner, _, origin = key.rpartition(".")
    owner, _, name = owner.rpartition(".")
    curve = curves.get(owner)
    if curve is None or owner not in edits.curves or name not in (curve.across, curve.along):
        return key
    origins = [point.origin for point in edits.curves[owner]]
    return f"{owner}.{name}.{origins.index(int(origin))}" if int(origin) in origins else None
