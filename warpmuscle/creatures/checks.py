"""What the types of a description cannot say."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.creatures.description import (
    Attachment,
    Creature,
    CreatureMuscle,
    Range,
    Segment,
    is_paired,
    joint_of,
    sided,
)
from warpmuscle.creatures.gait import moving_joints, side_joints
from warpmuscle.scene.validation.checks import known

LOWEST_ROOT = 0.45  # m; SIMBICON lets its torques go below 0.4 m
MOST = 1.0e6  # of any number of a description


def check_creature(creature: Creature) -> None:
    """Names resolve, segments make a tree, boxes have corners in order, and there is a gait for all joints.

    Raises:
        SceneError: the first thing that is wrong, with its key.
    """
    _check_numbers(creature)
    _check_segments(creature)
    _check_names(creature)
    for name, muscle in creature.muscles.items():
        _check_muscle(creature, f"muscles.{name}", muscle)
    _check_gait(creature)


def _check_numbers(creature: Creature) -> None:
    for key in ("density", "duration", "time_step", "fall"):
        _positive(key, getattr(creature, key))
    if creature.fall >= 1.0:
        raise SceneError(f"must be less than 1, of the height at the start, is {creature.fall:g}", key="fall")


def _positive(key: str, number: float) -> None:
    if not 0.0 < number <= MOST:
        raise SceneError(f"must be greater than 0 and at most {MOST:g}, is {number:g}", key=key)


def _check_names(creature: Creature) -> None:
    """No two parts of the scene get the same name, as lThigh of `Thigh`, of `thigh`, and of one that is called so."""
    segments, muscles = creature.segments, creature.muscles
    _distinct("body", {f"segments.{name}": (name, one.paired) for name, one in segments.items()}, {})
    joints = {
        f"segments.{name}.joint": (joint_of(name, one), one.paired) for name, one in segments.items() if one.parent
    }
    _distinct("joint", joints, {"root": "what carries the whole body"})
    if all(point.on in segments for muscle in muscles.values() for point in muscle.path):
        _distinct("muscle", {f"muscles.{name}": (name, is_paired(creature, one)) for name, one in muscles.items()}, {})


def _distinct(kind: str, called: Mapping[str, tuple[str, bool]], taken: Mapping[str, str]) -> None:
    """Raise SceneError if names by key, and whether there is one on each side, make one that is `taken` by another."""
    found = dict(taken)
    for key, (name, paired) in called.items():
        for own in [sided(name, side) for side in "lr"] if paired else [name]:
            if own in found:
                raise SceneError(f"the {kind} would be called {own!r}, as {found[own]} is", key=key)
            found[own] = f"that of {key.removesuffix('.joint')}"


def _finite(key: str, numbers: Iterable[float]) -> None:
    for number in numbers:
        if not abs(number) <= MOST:
            raise SceneError(f"must be a number between {-MOST:g} and {MOST:g}, is {number:g}", key=key)


def _ordered(key: str, interval: Range, positive: bool = False) -> None:
    _finite(key, interval)
    if interval[0] > interval[1]:
        raise SceneError(f"low {interval[0]:g} is greater than high {interval[1]:g}", key=key)
    if positive:
        _positive(key, interval[0])


def _check_segments(creature: Creature) -> None:
    check_size("bodies", 2 * len(creature.segments), lambda text: SceneError(text, key="segments"))
    roots = [name for name, segment in creature.segments.items() if not segment.parent]
    if len(roots) != 1:
        found = ", ".join(map(repr, roots)) or "none"
        raise SceneError(f"one segment alone has no parent, here: {found}", key="segments")
    root = creature.segments[roots[0]]
    if root.paired:
        raise SceneError("the root is one alone, and not paired", key=f"segments.{roots[0]}.paired")
    for name, segment in creature.segments.items():
        key = f"segments.{name}"
        _check_size(key, segment)
        if segment.parent:
            known(segment.parent, creature.segments, "segment", f"{key}.parent")
            if creature.segments[segment.parent].paired and not segment.paired:
                raise SceneError("hangs on a paired segment, and so is paired", key=f"{key}.paired")
        if segment.side is not None and not creature.spatial:
            raise SceneError("only in space does a joint turn to the side: set spatial = true", key=f"{key}.side")
    for name in creature.segments:
        _reaches_root(creature, name)
    if 0.5 * (root.start[1] + root.end[1]) < LOWEST_ROOT:
        message = f"the middle of the root must be at least {LOWEST_ROOT:g} m high, where its controller has strength"
        raise SceneError(message, key=f"segments.{roots[0]}.start")


def _check_size(key: str, segment: Segment) -> None:
    for field in ("start", "end"):
        _finite(f"{key}.{field}", getattr(segment, field))
    if math.dist(segment.start, segment.end) < 1e-3:
        raise SceneError("start and end are the same place", key=f"{key}.end")
    _positive(f"{key}.radius", segment.radius)
    for field in ("mass", "density"):
        if getattr(segment, field) is not None:
            _positive(f"{key}.{field}", getattr(segment, field))
    if segment.mass is not None and segment.density is not None:
        raise SceneError("give a mass or a density, not both", key=f"{key}.density")
    if segment.range is not None:
        _ordered(f"{key}.range", segment.range)
        if not segment.range[0] <= 0.0 <= segment.range[1]:
            raise SceneError("must have the standing pose, 0, within it", key=f"{key}.range")
    _check_side(f"{key}.side", segment)
    for field in ("damping", "friction"):
        if not 0.0 <= getattr(segment, field) <= MOST:
            raise SceneError(f"must not be negative, is {getattr(segment, field):g}", key=f"{key}.{field}")


def _check_side(key: str, segment: Segment) -> None:
    """A second axis of a joint that has a first one."""
    if segment.side is None:
        return
    if segment.range is None:
        raise SceneError("a joint that turns to the side turns about x, too: give its `range`", key=key)
    _ordered(key, segment.side)
    if not segment.side[0] <= 0.0 <= segment.side[1]:
        raise SceneError("must have the standing pose, 0, within it", key=key)


def _reaches_root(creature: Creature, name: str) -> None:
    above = name
    for _ in creature.segments:
        if not creature.segments[above].parent:
            return
        above = creature.segments[above].parent
    raise SceneError("hangs on itself", key=f"segments.{name}.parent")


def _check_muscle(creature: Creature, key: str, muscle: CreatureMuscle) -> None:
    if len(muscle.path) < 2:
        raise SceneError(f"needs an origin and an insertion, has {number_of(len(muscle.path), 'point')}", f"{key}.path")
    for number, point in enumerate(muscle.path):
        _check_box(creature, f"{key}.path.{number}", point)
    if all(one.on == other.on for one, other in pairwise(muscle.path)):
        raise SceneError("crosses no joint: all of its points are on one segment", key=f"{key}.path")
    for number, bend in enumerate(muscle.over):
        known(bend.joint, moving_joints(creature), "joint", f"{key}.over.{number}.joint")
        _ordered(f"{key}.over.{number}.radius", bend.radius, positive=True)
        _check_clear(creature, key, muscle, number)
    _ordered(f"{key}.f_max", muscle.f_max, positive=True)
    _ordered(f"{key}.l_opt", muscle.l_opt, positive=True)
    _positive(f"{key}.fibre", muscle.fibre)
    if not 0.0 <= muscle.delay <= 1.0:
        raise SceneError(f"must be between 0 and 1, is {muscle.delay:g}", key=f"{key}.delay")


def _check_clear(creature: Creature, key: str, muscle: CreatureMuscle, number: int) -> None:
    """No point can lie within a cylinder, which the path then could not go round."""
    bend = muscle.over[number]
    segment = next(one for name, one in creature.segments.items() if one.parent and joint_of(name, one) == bend.joint)
    _, *joint = segment.start if segment.at is None else segment.at
    for place, point in enumerate(muscle.path):
        nearest = [min(max(at, low), high) for at, low, high in zip(joint, point.low[1:], point.high[1:], strict=True)]
        if math.dist(nearest, joint) <= bend.radius[1]:
            message = (
                f"comes within {math.dist(nearest, joint):.3g} m of the joint {bend.joint!r}, about which the path "
                f"wraps at up to {bend.radius[1]:g} m"
            )
            raise SceneError(message, key=f"{key}.path.{place}.low")


def _check_box(creature: Creature, key: str, point: Attachment) -> None:
    known(point.on, creature.segments, "segment", f"{key}.on")
    for axis, (low, high) in enumerate(zip(point.low, point.high, strict=True)):
        _ordered(f"{key}.low.{axis}", (low, high))
    if point.start is not None:
        for axis, (low, at, high) in enumerate(zip(point.low, point.start, point.high, strict=True)):
            if not low <= at <= high:
                raise SceneError(f"{at:g} is outside of its box, {low:g} to {high:g}", key=f"{key}.start.{axis}")


def _check_gait(creature: Creature) -> None:
    gait, moving = creature.gait, moving_joints(creature)
    pairs = [name for name, paired in moving.items() if paired]
    known(gait.hips, pairs, "pair of joints", "gait.hips")
    known(gait.feet, [name for name, one in creature.segments.items() if one.paired], "pair", "gait.feet")
    for field in ("speed", "time", "ground_time", "freedom"):
        _positive(f"gait.{field}", getattr(gait, field))
    _finite("gait.lean", [gait.lean])
    for field in ("crossed", "level"):
        for number, name in enumerate(getattr(gait, field)):
            known(name, pairs, "pair of joints", f"gait.{field}.{number}")
    for name, angle in gait.apart.items():
        known(name, sorted(side_joints(creature)), "joint with a side that carries a leg", f"gait.apart.{name}")
        _finite(f"gait.apart.{name}", [angle])
    _check_targets("gait.swing", gait.swing, pairs, "pair of joints")
    _check_targets("gait.stance", gait.stance, pairs, "pair of joints")
    _check_targets("gait.steady", gait.steady, [name for name in moving if name not in pairs], "joint without a side")
    for name, stiffness in gait.stiffness.items():
        known(name, ("root", *moving), "joint", f"gait.stiffness.{name}")
        _positive(f"gait.stiffness.{name}", stiffness)
    for name, angle in gait.start.items():
        names = [
            one
            for joint, paired in moving.items()
            for one in ((joint, sided(joint, "l"), sided(joint, "r")) if paired else (joint,))
        ]
        known(name, names, "joint", f"gait.start.{name}")
        _finite(f"gait.start.{name}", [angle])


def _check_targets(key: str, table: Mapping[str, list[float]], names: Iterable[str], kind: str) -> None:
    for name, angles in table.items():
        known(name, names, kind, f"{key}.{name}")
        if not angles:
            raise SceneError("needs at least one angle", key=f"{key}.{name}")
        _finite(f"{key}.{name}", angles)
