"""Which bodies of a character must not run into each other, and their shapes as the kernel wants them."""

from __future__ import annotations

from itertools import combinations, product
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import rotate
from warpmuscle.kernels import structs
from warpmuscle.kernels.memory.scratch import SHAPES_A_BODY, capacity_of
from warpmuscle.model.bodies import stacked
from warpmuscle.scene import Capsule, Character, Scene, Shape, Sphere
from warpmuscle.scene.initial_pose import initial_pose
from warpmuscle.scene.parameters import at_start, greatest
from warpmuscle.scene.topology import Topology

Pair = tuple[str, str]
CapsuleRows = tuple[Floats, Floats, Floats]

TEST_TIME = 0.002  # s between two tests
FASTEST = 5.0  # m/s, at which bodies come nearer to each other; faster ones touch up to a test later


def collision_pairs(scene: Scene, names: Topology) -> list[Pair]:
    """The pairs of bodies that fail an instance by running into each other; none if the scene does not test that.

    All bodies with shapes are paired unless the scene names pairs, but for those that a joint joins, and those that
    have a neighbour in common and overlap in the initial pose, free parameters at their start values.

    Args:
        scene: checked scene.

    Raises:
        SceneError: the scene tests for collisions, but there is no pair.
    """
    if greatest(scene, scene.failure.self_collision) <= 0.0:
        return []
    if scene.failure.self_collision_pairs:
        return list(scene.failure.self_collision_pairs)
    pairs = apart(scene, names)
    if not pairs:
        raise SceneError("no two bodies with shapes could collide", key="failure.self_collision")
    return pairs


def apart(scene: Scene, names: Topology) -> list[Pair]:
    """The pairs of bodies with shapes but those that a joint joins, and those that overlap beside a common neighbour.

    That is in the initial pose, free parameters at their start values.
    """
    plain = at_start(scene)
    poses, _ = initial_pose(plain)
    around = _neighbours(scene.character)
    bodies = [name for name in names.bodies if scene.character.bodies[name].shapes]
    placed = {name: [_placed(shape, *poses[name]) for shape in plain.character.bodies[name].shapes] for name in bodies}
    return [
        (a, b)
        for a, b in combinations(bodies, 2)
        if b not in around[a]
        and not (around[a] & around[b] and any(_overlap(*shapes) for shapes in product(placed[a], placed[b])))
    ]


def capsule_of(shape: Shape) -> CapsuleRows:
    """The capsule that stands for a shape: that of a box lies inside it, along its longest edge.

    Args:
        shape: of numbers, or (n,) arrays with one value an instance.

    Returns:
        Middle and half (rows, 3) of its segment, body axes, m, the latter from middle to end; and its radius (rows,).
    """
    if isinstance(shape, Sphere):
        return rows(shape.center), np.zeros((1, 3)), rows([shape.radius])[:, 0]
    if isinstance(shape, Capsule):
        start, end = rows(shape.start), rows(shape.end)
        return 0.5 * (start + end), 0.5 * (end - start), rows([shape.radius])[:, 0]
    low, high = rows(shape.low), rows(shape.high)
    size = high - low
    radius = 0.5 * size.min(axis=1)
    longest = np.arange(3) == size.argmax(axis=1)[:, None]
    return 0.5 * (low + high), np.where(longest, 0.5 * size - radius[:, None], 0.0), radius


def steps_between_tests(time_step: float) -> int:
    """Steps between two tests."""
    return max(round(TEST_TIME / time_step), 1)


def collisions_struct(
    scene: Scene, names: Topology, pairs: list[Pair], depth: Floats, device: Any
) -> structs.Collisions:
    """The device structure of the shapes that may collide (see `kernels.structs.Collisions`).

    Args:
        scene: its numbers are floats, or (n,) arrays with one value an instance.
        pairs: of bodies; not empty. depth: (rows,) m, how deep they may penetrate each other; 0: as deep as they like.

    Raises:
        SceneError: more shapes than there is room for.
    """
    bodies = [name for name in names.bodies if any(name in pair for pair in pairs)]
    shapes = [(name, capsule_of(shape)) for name in bodies for shape in scene.character.bodies[name].shapes]
    room = SHAPES_A_BODY * capacity_of(len(names.bodies))
    if len(shapes) > room:
        raise SceneError(
            f"{number_of(len(shapes), 'shape')} may collide, more than the {room} that there is room for; name "
            "fewer pairs",
            key="failure.self_collision_pairs",
        )
    of_body = {name: [i for i, (body, _) in enumerate(shapes) if body == name] for name in bodies}
    numbers = [of_shapes for a, b in pairs for of_shapes in product(of_body[a], of_body[b])]
    offset = {name: _joint_place(name, scene.character, names) for name in bodies}
    c = structs.Collisions()
    c.every = steps_between_tests(scene.time_step)
    c.body = to_device([names.bodies.index(name) for name, _ in shapes], int, device)
    c.middle = to_device(stacked([middle - offset[name] for name, (middle, _, _) in shapes]), wp.vec3, device)
    c.half = to_device(stacked([half for _, (_, half, _) in shapes]), wp.vec3, device)
    c.pair = to_device(numbers, int, device)
    c.nearest_sq = to_device(nearest_squared(scene, pairs, depth), wp.vec2, device)
    return c


def nearest_squared(scene: Scene, pairs: list[Pair], depth: Floats) -> Floats:
    """What `kernels.structs.Collisions.nearest_sq` is, (rows, pairs of shapes, 2), in the order of its pairs.

    Args:
        scene, pairs, depth: as of `collisions_struct`.
    """
    capsules = {
        name: [capsule_of(shape) for shape in scene.character.bodies[name].shapes] for pair in pairs for name in pair
    }
    return stacked(
        [_nearest_sq(a, b, depth) for one, other in pairs for a, b in product(capsules[one], capsules[other])]
    )


def _nearest_sq(a: CapsuleRows, b: CapsuleRows, depth: Floats) -> Floats:
    """Squared distances (rows, 2), m^2: of the middles, beyond which two capsules never collide; and of the segments.

    Args:
        depth: (rows,) m, how deep they may penetrate; 0: as deep as they like.
    """
    (_, half_a, radius_a), (_, half_b, radius_b) = a, b
    nearest = np.where(depth != 0.0, np.maximum(radius_a + radius_b - depth, 0.0), 0.0)
    beyond = nearest + np.linalg.norm(half_a, axis=1) + np.linalg.norm(half_b, axis=1)
    return np.stack(np.broadcast_arrays(np.where(nearest > 0.0, beyond, 0.0) ** 2, nearest**2), axis=1)


def segment_distance(middle: Floats, half_a: Floats, half_b: Floats) -> Floats:
    """Distances (n,) of segments, parallel ones and points included (Ericson 2005, section 5.1.9), m.

    Args:
        middle: (n, 3) from the middle of segment a to that of segment b. half_a, half_b: (n, 3) from middle to end.
    """
    a, b, r = 2.0 * half_a, 2.0 * half_b, half_b - half_a - middle
    normal = np.cross(a, b)
    on_a = _fraction(np.sum(np.cross(b, r) * normal, axis=-1), normal)
    on_b = _fraction(np.sum(b * (r + a * on_a[:, None]), axis=-1), b)
    on_a = _fraction(np.sum(a * (b * on_b[:, None] - r), axis=-1), a)
    return np.asarray(np.linalg.norm(r + a * on_a[:, None] - b * on_b[:, None], axis=-1))


def _joint_place(body: str, character: Character, names: Topology) -> Floats:
    """The joint of a body in the body's frame, (rows, 3), m; the root's frame is that of its centre of mass."""
    number = names.bodies.index(body)
    return rows(character.joints[names.joints[number - 1]].position_in_child if number else (0.0, 0.0, 0.0))


def _neighbours(character: Character) -> dict[str, set[str]]:
    """The bodies that joints connect to each body."""
    around: dict[str, set[str]] = {name: set() for name in character.bodies}
    for joint in character.joints.values():
        around[joint.parent].add(joint.child)
        around[joint.child].add(joint.parent)
    return around


def _placed(shape: Shape, position: Floats, orientation: Floats) -> tuple[Floats, Floats, float]:
    """The capsule of a shape of plain numbers where its body is: middle and half (3,), m, and radius, m."""
    middle, half, radius = capsule_of(shape)
    return position + rotate(orientation, middle[0]), rotate(orientation, half[0]), float(radius[0])


def _overlap(a: tuple[Floats, Floats, float], b: tuple[Floats, Floats, float]) -> bool:
    """Whether two placed capsules overlap."""
    return bool(segment_distance((b[0] - a[0])[None], a[1][None], b[1][None])[0] < a[2] + b[2])


def _fraction(product_along: Floats, along: Floats) -> Floats:
    square = np.sum(along * along, axis=-1)
    share = np.clip(product_along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    return np.asarray(share * (square > 0.0))
