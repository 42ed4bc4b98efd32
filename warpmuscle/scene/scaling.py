"""Numbers of a scene multiplied, one by one or as the size of body segments asks for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.scene import Character, Scene
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import initial_pose, plain_number, plain_vector
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.parameters import leaves, rebuilt, start_values, substitute
from warpmuscle.scene.validation.checks import near


def multiplied(scene: Scene, factors: Mapping[str, float]) -> Scene:
    """The scene with some of its numbers multiplied, and no others.

    Of a free parameter value, interval and step are. A number that follows another one goes on following it, by a
    factor that accounts for what became of both.

    Args:
        scene: it is not changed.
        factors: by path of the number.

    Raises:
        SceneError: there is no number at a path, a free parameter cannot be multiplied so, or a number follows one
            that becomes 0.
    """
    numbers = {path for path, leaf in leaves(scene) if isinstance(leaf, Free) or _is_plain(leaf)}
    for path in factors:
        if path not in numbers:
            raise SceneError("there is no number here that could be multiplied", key=path)

    def replaced(path: str, leaf: Any) -> Any:
        factor = factors.get(path, 1.0)
        if not isinstance(leaf, Free):
            return leaf * factor if factor != 1.0 else leaf
        source = factors.get(leaf.same_as, 1.0) if leaf.same_as else 1.0
        if factor == source == 1.0 or (leaf.same_as and factor == source and not leaf.through):
            return leaf
        if source == 0.0:
            raise SceneError(f"follows {leaf.same_as}, which would be 0: name both of them, or neither", key=path)
        if leaf.through:
            return Free(same_as=leaf.same_as, through=tuple(sorted((s * source, v * factor) for s, v in leaf.through)))
        return _times(path, leaf, factor / source)

    return rebuilt(scene, replaced)


def scaled_segments(scene: Scene, factors: Mapping[str, float]) -> Scene:
    """The scene with bodies of another size, of the same material.

    Lengths within a body are multiplied by its factor s: its shapes, the positions of joints and of the muscles' via
    points on it; its mass by s^3 and its inertia by s^5, as for constant density. The root is moved up or down, so that
    the lowest point of all shapes is at the start where it was. Nothing else changes: not strengths, fibre lengths and
    slack lengths of muscles (`warpmuscle fit-muscles` fits them to the new skeleton), nor gains.

    Args:
        scene: it is not changed.
        factors: by name of the body.

    Raises:
        SceneError: there is no such body, or a factor is not positive.
    """
    character = scene.character
    by_path: dict[str, float] = {}
    for name, factor in factors.items():
        if name not in character.bodies:
            raise SceneError(f"no body is called {name!r}{near(name, character.bodies)}", key=f"scale.{name}")
        if not 0.0 < factor < math.inf:
            raise SceneError(f"a body is scaled by a positive factor, not by {factor:g}", key=f"scale.{name}")
        by_path |= _of_body(character, name, factor)
    scaled = multiplied(scene, by_path)
    return _lifted(scaled, _lowest_point(scene) - _lowest_point(scaled))


def _of_body(character: Character, name: str, factor: float) -> dict[str, float]:
    """Factors of all numbers that belong to a body, by path in the scene."""
    body, key = character.bodies[name], f"character.bodies.{name}"
    found = {f"{key}.mass": factor**3} | {f"{key}.inertia.{axis}": factor**5 for axis in range(3)}
    shapes = (path for path, _ in leaves(body.shapes, f"{key}.shapes") if "material" not in path.split("."))
    found |= dict.fromkeys(shapes, factor)
    for joint_name, joint in character.joints.items():
        for field, owner in (("position_in_parent", joint.parent), ("position_in_child", joint.child)):
            if owner == name:
                found |= {f"character.joints.{joint_name}.{field}.{axis}": factor for axis in range(3)}
    for muscle_name, muscle in character.muscles.items():
        for number, point in enumerate(muscle.path):
            for field in ("position", "start", "end"):
                if point.body == name and getattr(point, field) is not None:
                    point_key = f"character.muscles.{muscle_name}.path.{number}.{field}"
                    found |= {f"{point_key}.{axis}": factor for axis in range(3)}
    return found


def _lowest_point(scene: Scene) -> float:
    """Height of the lowest point of all shapes at the start, m; 0 if there are no shapes."""
    plain = substitute(scene, start_values(scene))
    state = plain.initial_state
    root = normalized(plain_vector(state.root_orientation))
    poses, _ = initial_pose(plain)
    heights = [
        plain_number(state.root_position[1]) + float(rotate(root, place)[1]) - plain_number(radius)
        for name, (position, orientation) in poses.items()
        for shape in plain.character.bodies[name].shapes
        for point, radius in contact_points(shape)
        for place in (position + rotate(orientation, plain_vector(point)),)
    ]
    return min(heights, default=0.0)


def _lifted(scene: Scene, height: float) -> Scene:
    """The scene with its root so much higher at the start, m; a fixed root stays where it is."""
    if not root_type(scene.character).moving or height == 0.0:
        return scene

    def replaced(path: str, leaf: Any) -> Any:
        if path != "initial_state.root_position.1":
            return leaf
        if not isinstance(leaf, Free):
            return leaf + height
        if leaf.same_as:
            return leaf
        numbers = {name: getattr(leaf, name) for name in ("value", "min", "max")}
        moved = {name: number + height for name, number in numbers.items() if number is not None}
        return msgspec.structs.replace(leaf, **moved)

    return rebuilt(scene, replaced)


def _is_plain(leaf: Any) -> bool:
    """Whether this is a number as such."""
    return isinstance(leaf, int | float | np.number) and not isinstance(leaf, bool)


def _times(path: str, free: Free, factor: float) -> Free:
    """A free parameter times a factor; raises SceneError with its path."""
    if free.same_as:
        return Free(same_as=free.same_as, factor=free.factor * factor)

    def rate_times(name: str, rate: Number) -> Number:
        return _times(f"{path}.{name}", rate, factor) if isinstance(rate, Free) else rate * factor

    assert free.value is not None
    low, high = free.min, free.max
    if low is not None and high is not None:
        low, high = sorted((low * factor, high * factor))
    per = free.with_rates(rate_times)
    try:
        return Free(free.value * factor, low, high, step=free.step * abs(factor), scale=free.scale, per=per)
    except ValueError as error:
        raise SceneError(f"cannot be multiplied by {factor:g}: {error}", key=path) from None
