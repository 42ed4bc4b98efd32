"""The bodies of a character as a kernel wants them: numbered breadth first, with their joints and contact points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, structs_to_device, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import normalized
from warpmuscle.kernels import structs
from warpmuscle.kernels.contact.hunt_crossley import MARGIN
from warpmuscle.kernels.memory.scratch import capacity_of, slots_of
from warpmuscle.model.joints import joint_number, root_number
from warpmuscle.model.terrain.bank import terrain_struct
from warpmuscle.model.terrain.belts import belt_arrays
from warpmuscle.scene import Box, ContactMaterial, Ground, Joint, Scene
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.joint_type import NO_AXIS, OTHER_AXIS
from warpmuscle.scene.masses import TINY_MASS
from warpmuscle.scene.topology import Topology


def stacked(by_body: Sequence[Floats]) -> Floats:
    """(rows, k) arrays of all bodies as one (rows, bodies, k), rows 1 or the common number of instances."""
    count = max(len(values) for values in by_body)
    return np.stack([np.broadcast_to(values, (count, *values.shape[1:])) for values in by_body], axis=1)


def foot_slots(scene: Scene, names: Topology) -> tuple[list[int], list[int]]:
    """Slot of every body whose contact force counts for a foot (-1 for others), and the side of every slot."""
    slot = [-1] * len(names.bodies)
    side: list[int] = []
    for which, foot in enumerate(scene.feet or ()):
        number = names.bodies.index(foot)
        first = names.first_child[number]
        for body in (number, *range(first, first + names.child_count[number])):
            slot[body] = len(side)
            side.append(which)
    if len(side) > slots_of(capacity_of(len(names.bodies))):
        raise SceneError(
            f"the feet have {number_of(len(side) - 2, 'body')} hanging on them, more than there is room for",
            key="controller.feet" if scene.character.feet is None else "character.feet",
        )
    return slot, side


def skeleton_struct(scene: Scene, names: Topology, points: list[int], device: Any) -> structs.Skeleton:
    """The device structure of bodies and joints of a scene (see `kernels.structs.Skeleton`).

    Args:
        points: (bodies + 1,) where the contact points of each body start, see `contacts_struct`.
    """
    character = scene.character
    bodies = [character.bodies[name] for name in names.bodies]
    joints: list[Joint | None] = [None, *(character.joints[name] for name in names.joints)]
    kinds = [root_number(character), *(joint_number(name, character) for name in names.joints)]
    speed_start = [names.speeds_of(i).start for i in range(len(bodies))]
    zero = (0.0, 0.0, 0.0)
    com = [-rows(zero if joint is None else joint.position_in_child) for joint in joints]
    anchors = [
        rows(zero) if joint is None else rows(joint.position_in_parent) + com[names.parents[i]]
        for i, joint in enumerate(joints)
    ]
    no_axes = rows(NO_AXIS), rows(OTHER_AXIS)
    axes = [no_axes if joint is None else joint_type(joint).frame(joint) for joint in joints]
    slot, side = foot_slots(scene, names)
    mass = rows([body.mass for body in bodies])

    s = structs.Skeleton()
    s.plan = records_to_device(
        structs.BodyPlan, device,
        parent=names.parents, joint_type=kinds,
        coordinate_start=[names.coordinates_of(i).start for i in range(len(bodies))], speed_start=speed_start,
        speed_end=[s + names.speed_start[i + 1] - names.speed_start[i] for i, s in enumerate(speed_start)],
        first_child=names.first_child, child_count=names.child_count,
        has_limits=[joint is not None and bool(joint.limits) for joint in joints], foot_slot=slot,
        first_point=points[:-1], end_point=points[1:],
    )  # fmt: skip
    s.foot_side = to_device(side or [0], int, device)
    s.total_mass = to_device(np.maximum(mass.sum(axis=1, keepdims=True), TINY_MASS), float, device)
    columns = {
        "mass": mass,
        "com": stacked(com),
        "inertia": rows([list(body.inertia) for body in bodies]),
        "anchor": stacked(anchors),
        "axis_a": stacked([a for a, _ in axes]),
        "axis_b": stacked([b for _, b in axes]),
    }
    s.row = structs_to_device(structs.BodyRow, columns, device)
    s.limits = structs_to_device(structs.LimitRow, _limit_columns(joints), device)
    return s


def _limit_columns(joints: list[Joint | None]) -> dict[str, Floats]:
    """Limits of all joints, by field of `kernels.structs.LimitRow`."""
    limits = [_limits(joint) for joint in joints]
    low = rows([[low for low, _ in limit] for limit in limits])
    high = rows([[high for _, high in limit] for limit in limits])
    half = 0.5 * (high - low)
    return {
        "low": low,
        "high": high,
        "cosine": np.cos(0.5 * (low + high)),
        "sine": np.sin(0.5 * (low + high)),
        "half_cosine": np.where(half < np.pi, np.cos(half), -2.0),
        "stiffness": rows([0.0 if joint is None else joint.limit_stiffness for joint in joints]),
        "damping": rows([0.0 if joint is None else joint.limit_damping for joint in joints]),
    }


def _limits(joint: Joint | None) -> list[tuple[Any, Any]]:
    """Three intervals, unbounded ones where a joint has fewer."""
    limits: list[tuple[Any, Any]] = list(joint.limits) if joint is not None else []
    return limits + [(-1.0e9, 1.0e9)] * (3 - len(limits))


def contacts_struct(scene: Scene, names: Topology, device: Any) -> tuple[structs.Contacts, list[int]]:
    """The device structure of contact points and ground of a scene, and where the points of each body start in it.

    See `kernels.structs.Contacts`; the starts are (bodies + 1,).
    """
    ground = scene.ground
    points_only, soft = ground.law in ("spring", "soft_constraint"), ground.law == "soft_constraint"
    touchable = ground.law != "spring" or bool(np.any(rows(ground.stiffness) > 0.0))
    start, points, radii, friction, reach = [0], [], [], [], []
    materials: list[dict[str, Any]] = []
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
                margin: Any = 0.0
                if not points_only and not isinstance(shape, Box):
                    materials.append(material_columns(shape.material or ground.material, radius, ground.law))
                    margin = materials[-1]["margin"]
                farthest = np.maximum(farthest, np.linalg.norm(points[-1], axis=-1) + rows(radius) + margin)
        reach.append(farthest)
        start.append(len(points))
    nothing = not points
    c = structs.Contacts()
    c.reach = to_device(stacked(reach), float, device)
    columns = {
        "place": stacked(points or [rows((0.0, 0.0, 0.0))]),
        "radius": rows([0.0] if nothing else radii),
        "friction": stacked(friction or [rows([0.0])[:, 0]]),
    }
    c.point = structs_to_device(structs.ContactPoint, columns, device)
    if soft:
        columns = {field: rows([getattr(ground, field)]) for field in structs.SoftConstraint.vars}
        c.soft = structs_to_device(structs.SoftConstraint, columns, device)
    if materials:
        columns = {field: stacked([one[field] for one in materials]) for field in structs.ContactMaterial.vars}
        c.material = structs_to_device(structs.ContactMaterial, columns, device)
    c.height = to_device(rows([ground.height]), float, device)
    columns = {field: rows([getattr(ground, field)]) for field in structs.Ground.vars}
    c.ground = structs_to_device(structs.Ground, columns, device)
    c.terrain = terrain_struct(ground, device)
    if ground.treadmill is not None:
        c.belts, c.belt_profile = belt_arrays(ground.treadmill, device)
    return c, start


def material_columns(material: ContactMaterial | None, radius: Any, law: str) -> dict[str, Floats]:
    """What a sphere is made of, (rows,) by field of `kernels.structs.ContactMaterial`."""
    material = material or ContactMaterial()
    numbers = {name: rows([getattr(material, name)])[:, 0] for name in material.__struct_fields__}
    half = 0.5 * numbers.pop("stiffness") ** (2.0 / 3.0)  # of equal sides, in the power in which they add up
    size = rows([radius])[:, 0]
    smoothing = numbers["hertz_smoothing"]
    margin = MARGIN / smoothing if law == "smooth_hunt_crossley" else 0.0 * smoothing
    hertz = 4.0 / 3.0 * half * np.sqrt(size * half)
    return numbers | {"constant": numbers.pop("constant_force"), "margin": margin, "hertz": hertz}


def ground_normal(ground: Ground, slope: Floats | None = None) -> Floats:
    """Normals of the ground, (rows, 1, 3), turned by each instance's slope if there is any.

    Args:
        slope: (instances,) rad, by which the ground rises forwards.
    """
    normal = normalized(rows([list(ground.normal)]))
    if slope is None or not np.any(slope):
        return normal
    level = normal[:, 0].astype(np.float32).astype(np.float64)  # as the device has it
    x, y, z = np.broadcast_to(level, (len(slope), 3)).T[:, :, None]
    sine, cosine = np.sin(slope)[:, None], np.cos(slope)[:, None]
    return np.stack([x, y * cosine + z * sine, z * cosine - y * sine], axis=-1)
