"""Numbers of a scene multiplied, one by one or as the size of body segments asks for it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import is_number
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.scene import Character, Displacement, Joint, Scene, ViaPoint
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import initial_pose, plain_number, plain_vector
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.masses import massless
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.parameters import at_start, leaves, rebuilt
from warpmuscle.scene.validation.checks import near
from warpmuscle.scene.wrapping.path import path_length
from warpmuscle.scene.wrapping.route import route_stops

SURFACE_LENGTHS = ("position", "radius", "length", "radii", "inner_radius", "outer_radius")
GREATEST = 1.0e6  # factor of a body, or 1 over it; inertias grow by its fifth power


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
    numbers = {path for path, leaf in leaves(scene) if isinstance(leaf, Free) or is_number(leaf)}
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


def scaled_segments(scene: Scene, factors: Mapping[str, float], muscles: bool = False) -> Scene:
    """The scene with bodies of another size, of the same material.

    Lengths within a body are multiplied by its factor s: its shapes, the positions of joints and how far these shift,
    the muscles' via points on it and how far these move, the surfaces that muscles wrap around, markers; its mass by
    s^3 and its inertia by s^5, as for constant density. The root is moved up or down, so that the lowest point of all
    shapes is at the start where it was. Strengths and gains stay as they are.

    Args:
        scene: it is not changed.
        factors: by name of the body.
        muscles: whether optimal fibre and slack lengths are multiplied as the paths become longer at the start, as by
            OpenSim's ScaleTool. Else they stay (`warpmuscle fit-muscles` fits them to the new skeleton).

    Raises:
        SceneError: there is no such body, a factor is not positive, or a path is a polynomial over a joint of a body.
    """
    character = scene.character
    by_path: dict[str, float] = {}
    for name, factor in factors.items():
        if name not in character.bodies:
            raise SceneError(f"no body is called {name!r}{near(name, character.bodies)}", key=f"scale.{name}")
        if not 0.0 < factor < math.inf:
            raise SceneError(f"a body is scaled by a positive factor, not by {factor:g}", key=f"scale.{name}")
        if not 1.0 / GREATEST <= factor <= GREATEST:
            limits = f"{1.0 / GREATEST:g} and {GREATEST:g}"
            raise SceneError(f"a body is scaled by a factor between {limits}, not by {factor:g}", key=f"scale.{name}")
        by_path |= _of_body(character, name, factor)
        for marker_name, marker in (scene.opensim.markers if scene.opensim is not None else {}).items():
            if marker.body == name:
                by_path |= {f"opensim.markers.{marker_name}.position.{axis}": factor for axis in range(3)}
    scaled = multiplied(scene, by_path)
    if muscles:
        scaled = multiplied(scaled, muscle_length_factors(scene, scaled))
    return _lifted(scaled, _lowest_point(scene) - _lowest_point(scaled))


def _of_body(character: Character, name: str, factor: float) -> dict[str, float]:
    """Factors of all numbers that belong to a body, by path in the scene."""
    body, key = character.bodies[name], f"character.bodies.{name}"
    found = {f"{key}.mass": factor**3} | {f"{key}.inertia.{axis}": factor**5 for axis in range(3)}
    shapes = (path for path, _ in leaves(body.shapes, f"{key}.shapes") if "material" not in path.split("."))
    found |= dict.fromkeys(shapes, factor)
    for joint_name, joint in character.joints.items():
        joint_key = f"character.joints.{joint_name}"
        for field, owner in (("position_in_parent", joint.parent), ("position_in_child", joint.child)):
            if owner == name:
                found |= {f"{joint_key}.{field}.{axis}": factor for axis in range(3)}
        if _parent_with_mass(character, joint) == name:
            for number, shift in enumerate(joint.translations):
                found |= _of_displacement(shift, f"{joint_key}.translations.{number}", factor)
    for muscle_name, muscle in character.muscles.items():
        if muscle.polynomial is not None and _moves(character, muscle.polynomial.joints, name):
            message = f"its path is a polynomial, which cannot be scaled with the body {name!r}"
            raise SceneError(message, key=f"character.muscles.{muscle_name}.polynomial")
        for number, point in enumerate(muscle.path):
            if point.body == name:
                found |= _of_point(point, f"character.muscles.{muscle_name}.path.{number}", factor)
    for constraint_name, constraint in character.constraints.items():
        for field, owner in (("position", constraint.body), ("other_position", constraint.other_body)):
            if owner == name:
                found |= {f"character.constraints.{constraint_name}.{field}.{axis}": factor for axis in range(3)}
    for surface_name, surface in character.surfaces.items():
        if surface.body == name:
            lengths = {field: getattr(surface, field) for field in SURFACE_LENGTHS if hasattr(surface, field)}
            for field, value in lengths.items():
                found |= dict.fromkeys(_numbers(value, f"character.surfaces.{surface_name}.{field}"), factor)
    return found


def _of_point(point: ViaPoint, key: str, factor: float) -> dict[str, float]:
    """Factors of a point of a path: of its place, and of how far it moves."""
    given = [field for field in ("position", "start", "end") if getattr(point, field) is not None]
    found = {f"{key}.{field}.{axis}": factor for field in given for axis in range(3)}
    for number, motion in enumerate(point.motion):
        found |= _of_displacement(motion, f"{key}.motion.{number}", factor)
    return found


def _of_displacement(shift: Displacement, key: str, factor: float) -> dict[str, float]:
    """Factors of a displacement along an axis; one that is a coordinate itself, along it, stays as it is."""
    if isinstance(shift.slope, int | float) and shift.slope == 1.0 and not shift.x and not shift.polynomial:
        return {}
    fields = {"value": shift.value, "slope": shift.slope, "y": shift.y, "polynomial": shift.polynomial}
    return dict.fromkeys((path for name, value in fields.items() for path in _numbers(value, f"{key}.{name}")), factor)


def _numbers(value: Any, key: str) -> list[str]:
    """Paths of the numbers of a value: of one, or of a list."""
    return [f"{key}.{k}" for k in range(len(value))] if isinstance(value, list | tuple) else [key]


def _parent_with_mass(character: Character, joint: Joint) -> str:
    """The body that a joint is on; of joints in a row, through bodies without mass, that of the first one."""
    carrier = {one.child: one.parent for one in character.joints.values()}
    body = joint.parent
    while massless(character.bodies[body]) and body in carrier:
        body = carrier[body]
    return body


def _moves(character: Character, joints: Sequence[str], body: str) -> bool:
    """Whether one of these joints joins a body to another one."""
    ends = {end for name in joints for end in (character.joints[name].parent, character.joints[name].child)}
    return body in ends


def muscle_length_factors(scene: Scene, scaled: Scene) -> dict[str, float]:
    """Factors of the optimal fibre and slack lengths of muscles: those of their paths' lengths at the start."""
    before, after = path_lengths(scene), path_lengths(scaled)
    return {
        f"character.muscles.{name}.{field}": after[name] / length
        for name, length in before.items() if length > 0.0 and after[name] != length
        for field in ("l_opt", "l_slack")
    }  # fmt: skip


def path_lengths(scene: Scene) -> dict[str, float]:
    """Length of each path of points at the start, m; free parameters count with their start values."""
    plain = at_start(scene)
    poses, angles = initial_pose(plain)
    muscles = plain.character.muscles
    routes = {name: muscle for name, muscle in muscles.items() if muscle.path}
    return {name: path_length(route_stops(plain.character, muscle, poses, angles)) for name, muscle in routes.items()}


def _lowest_point(scene: Scene) -> float:
    """Height of the lowest point of all shapes at the start, m; 0 if there are no shapes."""
    plain = at_start(scene)
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
