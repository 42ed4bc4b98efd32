"""What the types of a scene cannot say about muscles' paths and the surfaces that they wrap around."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import (
    Character,
    Condition,
    CylinderSurface,
    Drive,
    Muscle,
    PolynomialPath,
    Pulley,
    SphereSurface,
    Surface,
    TorusSurface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import check_displacement
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.topology import followers, subtree
from warpmuscle.scene.validation.checks import Checks, known, near

GREATEST_EXPONENT = 20  # of a coordinate in a polynomial path; more is a mistake
MOST_VARIABLES = 6  # coordinates of a polynomial path
MOST_WRAPS, MOST_POINTS = 7, 24  # of one path that wraps, moves, or has points that come in at once


def check_surfaces(checks: Checks, character: Character) -> None:
    """Surfaces have a body and a size."""
    for name, surface in character.surfaces.items():
        key = f"character.surfaces.{name}"
        known(surface.body, character.bodies, "body", f"{key}.body")
        if isinstance(surface, TorusSurface):
            _torus(checks, key, surface)
        _mujoco_surface(key, surface, character.wrapping == "mujoco")


def _mujoco_surface(key: str, surface: Surface, mujoco: bool) -> None:
    """Side points belong to MuJoCo's wrapping, and halves and other surfaces than its own to OpenSim's."""
    if mujoco and not isinstance(surface, CylinderSurface | SphereSurface):
        raise SceneError("with wrapping 'mujoco', surfaces must be cylinders or spheres", key=f"{key}.type")
    if mujoco and surface.side:
        raise SceneError("with wrapping 'mujoco', give a `side_point` instead", key=f"{key}.side")
    if not mujoco and getattr(surface, "side_point", None) is not None:
        raise SceneError("is for wrapping 'mujoco' only; give a `side` instead", key=f"{key}.side_point")


def _torus(checks: Checks, key: str, torus: TorusSurface) -> None:
    """The ring has a thickness."""
    inner, outer = checks.interval(torus.inner_radius)[1], checks.interval(torus.outer_radius)[0]
    if inner >= outer:
        raise SceneError(f"must be less than the outer radius {outer:g}, is {inner:g}", key=f"{key}.inner_radius")


def check_route(checks: Checks, key: str, muscle: Muscle) -> None:
    """A muscle has either a path, or pulleys and a rest length, or a polynomial."""
    character = checks.checked.character
    if muscle.rest_length is not None and not muscle.pulleys:
        raise SceneError("only a muscle with pulleys has a rest length; a path has its own", f"{key}.rest_length")
    if muscle.polynomial is not None:
        other = next((name for name in ("path", "pulleys", "wraps", "branches") if getattr(muscle, name)), None)
        if other is not None:
            raise SceneError(f"give either a `polynomial` or `{other}`, not both", key=f"{key}.polynomial")
        check_polynomial(f"{key}.polynomial", muscle.polynomial, character)
        return
    if not muscle.pulleys:
        if not muscle.path:
            raise SceneError("a muscle needs a `path`, `pulleys` and a `rest_length`, or a `polynomial`", key=key)
        check_path(f"{key}.path", muscle.path, character, checks.interval)
        _motions(checks, f"{key}.path", muscle.path, character)
        _check_hard(f"{key}.path", muscle)
        check_wraps(f"{key}.wraps", muscle, character)
        _branches(checks, f"{key}.branches", muscle)
        return
    if muscle.path:
        raise SceneError("give either a `path` or `pulleys`, not both", key=f"{key}.pulleys")
    if muscle.wraps:
        raise SceneError("only a `path` wraps around surfaces; leave out `wraps` or `pulleys`", key=f"{key}.wraps")
    if muscle.branches:
        raise SceneError("only a `path` has branches; leave out `branches` or `pulleys`", key=f"{key}.branches")
    if muscle.rest_length is None:
        raise SceneError("a muscle with pulleys needs a `rest_length`", key=key)
    check_pulleys(f"{key}.pulleys", muscle.pulleys, character)


def _branches(checks: Checks, key: str, muscle: Muscle) -> None:
    """Branches follow one another, have two points or more that always count at their ends, and their own surfaces."""
    starts, count = [branch.first for branch in muscle.branches], len(muscle.path)
    if not starts:
        return
    ends = [*(first - 1 for first in starts[1:]), count]
    for index, (branch, end) in enumerate(zip(muscle.branches, ends, strict=True)):
        place = f"{key}.{index}"
        if not 1 <= branch.first <= count:
            raise SceneError(f"the path has points 1 to {count}, not {branch.first}", key=f"{place}.first")
        if end <= branch.first or starts[0] == 2:
            raise SceneError("each branch needs two points at least", key=f"{place}.first")
        last = branch.first - 1  # of the branch before
        if any(point.condition is not None for point in muscle.path[max(last - 1, 0) : last + 1]):
            raise SceneError("points at the ends of branches cannot have conditions", key=f"{place}.first")
        for number, wrap in enumerate(muscle.wraps):
            if (wrap.first or 1) <= last < (wrap.last or count):
                message = "a surface is between points of one branch; give its `first` and `last`"
                raise SceneError(message, key=f"{key.removesuffix('.branches')}.wraps.{number}.last")


def shares(muscle: Muscle) -> list[Any]:
    """What the way to each point of a path counts: 1 over the divisor of its branch, 0 to the first of a branch.

    Args:
        muscle: its numbers are floats, or (n,) arrays with one value an instance.
    """
    found: list[Any] = [1.0] * len(muscle.path)
    for branch in muscle.branches:
        own = 1.0 / cast("Any", branch.divisor)
        found[branch.first - 1 :] = [0.0, *[own] * (len(muscle.path) - branch.first)]
    return found


def is_hard(condition: Condition) -> bool:
    """Whether a point comes in at once at the ends of a condition's interval."""
    blend = condition.blend
    return blend.max == 0.0 if isinstance(blend, Free) else not np.any(blend)


def is_route(muscle: Muscle) -> bool:
    """Whether a muscle's path wraps, moves, has branches, or points that come in at once."""
    hard = any(point.condition is not None and is_hard(point.condition) for point in muscle.path)
    return bool(muscle.wraps or muscle.branches) or hard or any(point.motion for point in muscle.path)


def _check_hard(key: str, muscle: Muscle) -> None:
    """All conditions of a path that wraps, moves or has a hard one are hard; and it has not too many points."""
    if not is_route(muscle):
        return
    for index, point in enumerate(muscle.path):
        if point.condition is not None and not is_hard(point.condition):
            message = "must be 0 in a path that wraps, moves or has another such condition"
            raise SceneError(message, key=f"{key}.{index}.condition.blend")
    if len(muscle.path) > MOST_POINTS:
        message = f"a path that wraps, moves or has conditions of blend 0 has {MOST_POINTS} points at most"
        raise SceneError(f"{message}, got {len(muscle.path)}", key=key)


def check_wraps(key: str, muscle: Muscle, character: Character) -> None:
    """Check what the path of a muscle wraps around.

    Raises:
        SceneError: an unknown surface, a range of points that the path has not, or too many surfaces.
    """
    if len(muscle.wraps) > MOST_WRAPS:
        raise SceneError(f"a path wraps around {MOST_WRAPS} surfaces at most, got {len(muscle.wraps)}", key=key)
    for index, wrap in enumerate(muscle.wraps):
        known(wrap.surface, character.surfaces, "surface", f"{key}.{index}.surface")
        _range(f"{key}.{index}", wrap, len(muscle.path))
        if character.wrapping == "mujoco":
            _between_neighbours(f"{key}.{index}", wrap, muscle.wraps[:index], muscle)


def _between_neighbours(key: str, wrap: Wrap, before: Sequence[Wrap], muscle: Muscle) -> None:
    """A surface of MuJoCo's wrapping is between two neighbouring points, behind those that come before it."""
    first = wrap.first or 1
    if (wrap.last or len(muscle.path)) != first + 1:
        raise SceneError("with wrapping 'mujoco' each surface is between two neighbouring points", key=f"{key}.last")
    rows = has_rows(muscle)
    if rows and any((other.first or 1) > first for other in before):
        raise SceneError(
            "surfaces in a row must be listed in the order in which the path meets them", key=f"{key}.first"
        )
    if rows and any(point.condition is not None for point in muscle.path):
        raise SceneError("points of a path over surfaces in a row cannot have conditions", key=f"{key}.first")


def has_rows(muscle: Muscle) -> bool:
    """Whether a path goes over several surfaces between two of its points."""
    firsts = [wrap.first or 1 for wrap in muscle.wraps]
    return len(set(firsts)) < len(firsts)


def _range(key: str, wrap: Wrap, count: int) -> None:
    """A wrap is between two points of its path, which are counted from 1."""
    for field in ("first", "last"):
        point = getattr(wrap, field)
        if point is not None and not 1 <= point <= count:
            message = f"the path has points 1 to {count}, not {point}; leave `{field}` out for all of them"
            raise SceneError(message, key=f"{key}.{field}")
    if wrap.first is not None and wrap.last is not None and wrap.first > wrap.last:
        raise SceneError(f"must not come after `last`, {wrap.last}, is {wrap.first}", key=f"{key}.first")


def check_polynomial(key: str, polynomial: PolynomialPath, character: Character) -> None:
    """Check a path that is a polynomial of joints' coordinates.

    Raises:
        SceneError: an unknown joint, one without such a coordinate, or terms that do not fit together.
    """
    joints, axes = polynomial.joints, polynomial.axes or [0] * len(polynomial.joints)
    if len(joints) > MOST_VARIABLES:
        raise SceneError(f"a polynomial takes {MOST_VARIABLES} coordinates at most, got {len(joints)}", f"{key}.joints")
    if len(axes) != len(joints):
        raise SceneError(f"{number_of(len(axes), 'axis')} for {number_of(len(joints), 'joint')}", key=f"{key}.axes")
    for index, (joint, axis) in enumerate(zip(joints, axes, strict=True)):
        _coordinate(f"{key}.joints.{index}", f"{key}.axes.{index}", joint, axis, "polynomial", character)
    if not polynomial.exponents:
        raise SceneError("a polynomial needs at least one term", key=f"{key}.exponents")
    if len(polynomial.coefficients) != len(polynomial.exponents):
        coefficients = number_of(len(polynomial.coefficients), "coefficient")
        message = f"{coefficients} for {number_of(len(polynomial.exponents), 'row')} of exponents"
        raise SceneError(message, key=f"{key}.coefficients")
    for index, exponents in enumerate(polynomial.exponents):
        if len(exponents) != len(joints):
            message = f"{number_of(len(exponents), 'exponent')} for {number_of(len(joints), 'joint')}"
            raise SceneError(message, key=f"{key}.exponents.{index}")
        for joint_index, exponent in enumerate(exponents):
            if not 0 <= exponent <= GREATEST_EXPONENT:
                place = f"{key}.exponents.{index}.{joint_index}"
                raise SceneError(f"must be within 0 and {GREATEST_EXPONENT}, is {exponent}", key=place)


def check_path(
    key: str, path: Sequence[ViaPoint], character: Character, interval: Callable[[Number], tuple[float, float]]
) -> None:
    """Check the points of a muscle's path.

    Args:
        key: of the path.
        interval: gives the least and the greatest value of a number.

    Raises:
        SceneError: an unknown body or joint, fewer than two points, or a point or condition that cannot be used.
    """
    if len(path) < 2:
        raise SceneError(f"a path needs at least two points, got {len(path)}", key=key)
    for index, point in enumerate(path):
        if point.body not in character.bodies:
            message = f"there is no body {point.body!r}{near(point.body, character.bodies)}"
            raise SceneError(message, key=f"{key}.{index}.body")
        _on_body(f"{key}.{index}", point, interval)
        if point.condition is not None:
            _condition(f"{key}.{index}.condition", point.condition, character, interval)


def check_pulleys(key: str, pulleys: Sequence[Pulley], character: Character) -> None:
    """Check the pulleys of a muscle.

    Raises:
        SceneError: an unknown joint, or one without such an angle.
    """
    for index, pulley in enumerate(pulleys):
        _angle(f"{key}.{index}", pulley.joint, pulley.axis, "pulley", character)


def _angle(key: str, joint: str, axis: int, what: str, character: Character) -> None:
    """A joint has an angle of this number."""
    _coordinate(f"{key}.joint", f"{key}.axis", joint, axis, what, character)


def _coordinate(key: str, axis_key: str, joint: str, axis: int, what: str, character: Character) -> None:
    """The same, with the keys of the joint and of the number."""
    if joint not in character.joints:
        raise SceneError(f"there is no joint {joint!r}{near(joint, character.joints)}", key=key)
    kind = joint_type(character.joints[joint])
    if not kind.scalars:
        raise SceneError(f"a {kind.name} joint has no angle for a {what}", key=key)
    if not 0 <= axis < kind.scalars:
        raise SceneError(f"a {kind.name} joint has no angle {axis}", key=axis_key)


def _motions(checks: Checks, key: str, path: Sequence[ViaPoint], character: Character) -> None:
    """Points move along directions with joints of one coordinate."""
    for index, point in enumerate(path):
        for number, motion in enumerate(point.motion):
            place = f"{key}.{index}.motion.{number}"
            _angle(place, motion.joint, 0, "moving point", character)
            kind = joint_type(character.joints[motion.joint])
            if kind.scalars > 1:
                message = f"a point moves with a joint of one coordinate, not with a {kind.name} joint"
                raise SceneError(message, key=f"{place}.joint")
            check_displacement(checks, place, motion)
            if motion.within and (len(motion.within) != 2 or not motion.within[0] < motion.within[1]):
                raise SceneError("takes the lowest and the highest coordinate", key=f"{place}.within")


def _on_body(key: str, point: ViaPoint, interval: Callable[[Number], tuple[float, float]]) -> None:
    """A point has either a position, or a line and a place on it."""
    line = {name: getattr(point, name) for name in ("start", "end", "at")}
    given = [name for name, value in line.items() if value is not None]
    if point.position is not None and given:
        raise SceneError(f"give either `position`, or a line with `start`, `end` and `at`, not `{given[0]}` too", key)
    if point.position is None and len(given) < len(line):
        missing = next(name for name in line if name not in given)
        lacks = f"a line needs `start`, `end` and `at`; missing key '{missing}'"
        raise SceneError(lacks if given else "missing key 'position' (or `start`, `end` and `at` of a line)", key)
    if point.at is not None:
        least, greatest = interval(point.at)
        if least < 0.0 or greatest > 1.0:
            raise SceneError(f"must be within 0 and 1, is {least if least < 0.0 else greatest:g}", key=f"{key}.at")


def _condition(
    key: str, condition: Condition, character: Character, interval: Callable[[Number], tuple[float, float]]
) -> None:
    """A condition has an angle of a joint, and an interval of it."""
    joint = character.joints.get(condition.joint)
    if joint is not None and joint_type(joint).quaternion:
        if condition.blend != 0.0:
            raise SceneError("a path jumps with the angles of a ball joint: give a blend of 0", key=f"{key}.blend")
        if not joint.axes:
            message = f"the ball joint {condition.joint!r} has no axes, about which its angles would be"
            raise SceneError(message, key=f"{key}.joint")
        if not 0 <= condition.axis < 3:
            raise SceneError(f"a ball joint has no angle {condition.axis}", key=f"{key}.axis")
    else:
        _angle(key, condition.joint, condition.axis, "condition", character)
    low, high = interval(condition.low)[1], interval(condition.high)[0]
    if low >= high:
        raise SceneError(f"low must be less than high, but they are {low:g} and {high:g}", key=f"{key}.low")
    least, greatest = interval(condition.blend)
    if least < 0.0:
        raise SceneError(f"the blend must not be negative, is {least:g}", key=f"{key}.blend")
    if least == 0.0 < greatest:
        message = f"the blend must be 0 or always above 0, so that the path is smooth; it goes from 0 to {greatest:g}"
        raise SceneError(message, key=f"{key}.blend")


def crosses(muscle: Muscle, joint: str, character: Character) -> bool:
    """Whether a muscle acts on a joint: its path runs from one side to the other, or depends on the joint's angle."""
    path = muscle.path
    if muscle.pulleys:
        return any(pulley.joint == joint for pulley in muscle.pulleys)
    if muscle.polynomial is not None:
        return joint in muscle.polynomial.joints
    movers = (joint, *followers(character, joint))
    sides = [subtree(character, character.joints[mover].child) for mover in movers]
    on_angle = any(point.condition is not None and point.condition.joint == joint for point in path)
    moved = any(motion.joint == joint for point in path for motion in point.motion)
    bodies = [point.body for point in path] + [character.surfaces[wrap.surface].body for wrap in muscle.wraps]
    return on_angle or moved or any(len({body in beyond for body in bodies}) == 2 for beyond in sides)


def usual_drive(joint: str, character: Character) -> Drive:
    """What drives a joint of which the scene does not say it."""
    muscles = character.muscles.values()
    return "muscle" if any(crosses(muscle, joint, character) for muscle in muscles) else "torque"
