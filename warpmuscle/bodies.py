"""The bodies of a character as a kernel wants them: numbered breadth first, with their joints and contact points."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.arrays import Floats, orthogonal, rows, structs_to_device, to_device
from warpmuscle.errors import SceneError
from warpmuscle.kernels import structs
from warpmuscle.kernels.lanes import capacity_of, slots_of
from warpmuscle.pose import normalized
from warpmuscle.scene import Box, Capsule, Joint, Scene, Shape, Sphere
from warpmuscle.topology import Topology

KIND = {"ball": structs.BALL, "universal": structs.UNIVERSAL, "hinge": structs.HINGE, "fixed": structs.FIXED}
ROOT_KIND = {"free": structs.ROOT_FREE, "planar": structs.ROOT_PLANAR, "fixed": structs.ROOT_FIXED}
NO_AXIS = (1.0, 0.0, 0.0)


def joint_axes(joint: Joint | None) -> tuple[Floats, Floats]:
    """Axes a and b of a joint as (rows, 3) unit vectors; a ball's second one made orthogonal to its first."""
    axes: list[Any] = list(joint.axes) if joint is not None else []
    a = normalized(rows(axes[0] if axes else NO_AXIS))
    b = normalized(rows(axes[-1] if axes else (0.0, 1.0, 0.0)))
    if joint is not None and joint.type == "ball":
        b = orthogonal(b, a)
    return a, b


def stacked(by_body: list[Floats]) -> Floats:
    """(rows, k) arrays of all bodies as one (rows, bodies, k), rows 1 or the common number of instances."""
    count = max(len(values) for values in by_body)
    return np.stack([np.broadcast_to(values, (count, *values.shape[1:])) for values in by_body], axis=1)


def foot_slots(names: Topology, feet: tuple[str, str]) -> tuple[list[int], list[int]]:
    """Slot of every body whose contact force counts for a foot (-1 for others), and the side of every slot."""
    slot = [-1] * len(names.bodies)
    side: list[int] = []
    for which, foot in enumerate(feet):
        number = names.bodies.index(foot)
        first = names.first_child[number]
        for body in (number, *range(first, first + names.child_count[number])):
            slot[body] = len(side)
            side.append(which)
    if len(side) > slots_of(capacity_of(len(names.bodies))):
        raise SceneError(
            f"the feet have {len(side) - 2} bodies hanging on them, more than there is room for",
            key="controller.feet",
        )
    return slot, side


def skeleton_struct(scene: Scene, names: Topology, device: Any) -> structs.Skeleton:
    """The device structure of bodies and joints of a scene (see `kernels.structs.Skeleton`)."""
    character = scene.character
    bodies = [character.bodies[name] for name in names.bodies]
    joints: list[Joint | None] = [None, *(character.joints[name] for name in names.joints)]
    kinds = [ROOT_KIND[character.root_joint], *(KIND[joint.type] for joint in joints if joint is not None)]
    zero = (0.0, 0.0, 0.0)
    com = [-rows(zero if joint is None else joint.position_in_child) for joint in joints]
    anchors = [
        rows(zero) if joint is None else rows(joint.position_in_parent) + com[names.parents[i]]
        for i, joint in enumerate(joints)
    ]
    axes = [joint_axes(joint) for joint in joints]
    limits = [_limits(joint) for joint in joints]
    slot, side = foot_slots(names, scene.controller.feet) if scene.controller is not None else ([-1] * len(bodies), [])
    mass = rows([body.mass for body in bodies])

    s = structs.Skeleton()
    s.parent = to_device(names.parents, int, device)
    s.joint_type = to_device(kinds, int, device)
    s.coordinate_start = to_device(names.coordinate_start, int, device)
    s.speed_start = to_device(names.speed_start, int, device)
    s.first_child = to_device(names.first_child, int, device)
    s.child_count = to_device(names.child_count, int, device)
    s.has_limits = to_device([int(joint is not None and bool(joint.limits)) for joint in joints], int, device)
    s.foot_slot = to_device(slot, int, device)
    s.foot_side = to_device(side or [0], int, device)
    s.total_mass = to_device(mass.sum(axis=1, keepdims=True), float, device)
    s.mass = to_device(mass, float, device)
    s.com = to_device(stacked(com), wp.vec3, device)
    s.inertia = to_device(rows([list(body.inertia) for body in bodies]), wp.vec3, device)
    s.anchor = to_device(stacked(anchors), wp.vec3, device)
    s.axis_a = to_device(stacked([a for a, _ in axes]), wp.vec3, device)
    s.axis_b = to_device(stacked([b for _, b in axes]), wp.vec3, device)
    low = rows([[low for low, _ in limit] for limit in limits])
    high = rows([[high for _, high in limit] for limit in limits])
    half = 0.5 * (high - low)
    s.limit_low = to_device(low, wp.vec3, device)
    s.limit_high = to_device(high, wp.vec3, device)
    s.limit_cosine = to_device(np.cos(0.5 * (low + high)), wp.vec3, device)
    s.limit_sine = to_device(np.sin(0.5 * (low + high)), wp.vec3, device)
    s.limit_half_cosine = to_device(np.where(half < np.pi, np.cos(half), -2.0), wp.vec3, device)
    s.limit_stiffness = to_device(rows([0.0 if j is None else j.limit_stiffness for j in joints]), float, device)
    s.limit_damping = to_device(rows([0.0 if j is None else j.limit_damping for j in joints]), float, device)
    return s


def _limits(joint: Joint | None) -> list[tuple[Any, Any]]:
    """Three intervals, unbounded ones where a joint has fewer."""
    limits: list[tuple[Any, Any]] = list(joint.limits) if joint is not None else []
    return limits + [(-1.0e9, 1.0e9)] * (3 - len(limits))


def contact_points(shape: Shape) -> list[tuple[list[Any], Any]]:
    """Points and radii at which a shape meets a plane: a sphere's centre, a capsule's ends, a box's eight corners."""
    if isinstance(shape, Sphere):
        return [(list(shape.center), shape.radius)]
    if isinstance(shape, Capsule):
        return [(list(shape.start), shape.radius), (list(shape.end), shape.radius)]
    assert isinstance(shape, Box)
    (x0, y0, z0), (x1, y1, z1) = shape.low, shape.high
    return [([x, y, z], 0.0) for y in (y0, y1) for x in (x0, x1) for z in (z0, z1)]


def contacts_struct(scene: Scene, names: Topology, device: Any) -> structs.Contacts:
    """The device structure of contact points and ground of a scene (see `kernels.structs.Contacts`)."""
    ground = scene.ground
    touchable = bool(np.any(rows(ground.stiffness) > 0.0))
    start, points, radii, friction, reach = [0], [], [], [], []
    for i, name in enumerate(names.bodies):
        body = scene.character.bodies[name]
        offset = (
            rows((0.0, 0.0, 0.0)) if i == 0 else rows(scene.character.joints[names.joints[i - 1]].position_in_child)
        )
        farthest = rows([0.0])[:, 0]
        for shape in body.shapes if touchable else []:
            for point, radius in contact_points(shape):
                points.append(rows(point) - offset)
                radii.append(radius)
                friction.append(np.minimum(rows(body.friction), rows(ground.friction)))
                farthest = np.maximum(farthest, np.linalg.norm(points[-1], axis=-1) + rows(radius))
        reach.append(farthest)
        start.append(len(points))
    nothing = not points
    c = structs.Contacts()
    c.start = to_device(start, int, device)
    c.reach = to_device(stacked(reach), float, device)
    columns = {
        "place": stacked(points or [rows((0.0, 0.0, 0.0))]),
        "radius": rows([0.0] if nothing else radii),
        "friction": stacked(friction or [rows([0.0])[:, 0]]),
    }
    c.point = structs_to_device(structs.ContactPoint, columns, device)
    c.normal = to_device(normalized(rows([list(ground.normal)])), wp.vec3, device)
    c.height = to_device(rows([ground.height]), float, device)
    columns = {field: rows([getattr(ground, field)]) for field in structs.Ground.vars}
    c.ground = structs_to_device(structs.Ground, columns, device)
    return c
