"""Objects of a scene: what a step has compiled in for them, and their arrays on a device."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import normalized
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.object_structs import MEMORY, ObjectCapsule, ObjectRow
from warpmuscle.kernels.objects.stage import ObjectsKind
from warpmuscle.model.bodies import stacked
from warpmuscle.model.collisions import capsule_of
from warpmuscle.model.joints import compiled_terrain, has_turned_axes
from warpmuscle.scene import Scene
from warpmuscle.scene.objects.part import AnyObject, BoxObject, Hinge
from warpmuscle.scene.objects.restitution import damping_ratio
from warpmuscle.scene.objects.shape import ROUNDING, inertia, rounded
from warpmuscle.scene.topology import Topology

ALWAYS = 1.0e30  # s, when what is never let go is


def objects_kind(scene: Scene) -> ForceKind:
    """What a step has compiled in for the objects of a scene that has some."""
    turned = any(map(has_turned_axes, scene.character.bodies.values()))
    terrain, moves = compiled_terrain(scene.ground), scene.ground.treadmill is not None
    hinged = any(solid.hinge is not None for solid in scene.objects.values())
    kind = ObjectsKind(len(scene.objects), len(object_pairs(scene)), hinged, turned, terrain, moves)
    return ForceKind(objects=kind, shipped=True)


def object_pairs(scene: Scene) -> tuple[tuple[int, int], ...]:
    """Numbers of objects that push each other, each pair once; two that are fixed do not."""
    number = {name: k for k, name in enumerate(scene.objects)}
    pairs = {
        (min(number[name], number[other]), max(number[name], number[other]))
        for name, solid in scene.objects.items()
        for other in solid.touches
        if not (solid.fixed and scene.objects[other].fixed)
    }
    return tuple(sorted(pairs))


def touching(scene: Scene, solid: AnyObject) -> list[str]:
    """The bodies that may touch an object: those that it names, or all with shapes; not the one that holds it."""
    named = solid.bodies or [name for name, body in scene.character.bodies.items() if body.shapes]
    return [name for name in named if solid.held is None or name != solid.held.body]


class ObjectPlaces(NamedTuple):
    """What is the same of objects whatever the numbers of a scene are, one of each an object."""

    fixed: tuple[bool, ...]
    holder: tuple[int, ...]  # number of the body that holds it, -1: none
    hinged: tuple[bool, ...]
    pairs: tuple[tuple[int, int], ...]  # of objects that push each other
    bodies: tuple[tuple[int, ...], ...]  # that may touch it, once for each of their shapes


def object_places(scene: Scene, names: Topology) -> ObjectPlaces:
    """Of the objects of a checked scene."""
    solids = scene.objects.values()
    return ObjectPlaces(
        tuple(solid.fixed for solid in solids),
        tuple(-1 if solid.held is None else names.bodies.index(solid.held.body) for solid in solids),
        tuple(solid.hinge is not None for solid in solids),
        object_pairs(scene),
        tuple(tuple(names.bodies.index(name) for name, _ in _shapes(scene, solid)) for solid in solids),
    )


def put_places(extension: Any, places: ObjectPlaces, instances: int, device: Any) -> None:
    """Let an extension have these, and memories that are zero."""
    extension.memory = wp.zeros((instances, len(places.fixed), MEMORY), dtype=float, device=device)
    extension.fixed = to_device(places.fixed, int, device)
    extension.hinged = to_device(places.hinged, int, device)
    extension.pairs = to_device(places.pairs or [(0, 0)], wp.vec2i, device)
    extension.holder = to_device(places.holder, int, device)
    extension.first_pair = to_device(starts(map(len, places.bodies)), int, device)
    extension.body = to_device(list(chain(*places.bodies)) or [0], int, device)


def put_numbers(extension: Any, scene: Scene, names: Topology, device: Any) -> None:
    """Let an extension have the numbers of a scene whose numbers are floats, or (n,) arrays."""
    solids = list(scene.objects.values())
    by_object = [_columns(scene, names, solid) for solid in solids]
    columns = {name: stacked([columns[name] for columns in by_object]) for name in by_object[0]}
    flat = {name: values[..., 0] if values.shape[-1] == 1 else values for name, values in columns.items()}
    extension.row = structs_to_device(ObjectRow, flat, device)
    extension.capsule = structs_to_device(ObjectCapsule, _capsules(scene, names, solids), device)


def _shapes(scene: Scene, solid: AnyObject) -> list[tuple[str, Any]]:
    return [(name, shape) for name in touching(scene, solid) for shape in scene.character.bodies[name].shapes]


def _columns(scene: Scene, names: Topology, solid: AnyObject) -> dict[str, Floats]:
    """`kernels.object_structs.ObjectRow` of an object by field, (rows, numbers) each."""
    half, radius = rounded(solid)
    place, orientation, until = rows(list(solid.position)), rows(list(solid.orientation)), rows([ALWAYS])
    if solid.held is not None:
        place = rows(list(solid.held.position)) - joint_in_body(scene, names, solid.held.body)
        orientation = rows(list(solid.held.orientation))
        until = rows([ALWAYS if solid.held.until is None else solid.held.until])
    rounding = np.minimum(ROUNDING, 0.5 * half.min(axis=1)) if isinstance(solid, BoxObject) else np.zeros(1)
    ground = np.minimum(rows([solid.friction]), rows([scene.ground.friction]))
    axle = solid.hinge or Hinge()
    axis = rows(list(axle.axis))
    columns = {
        "axis": normalized(axis), "pivot": rows(list(axle.position)),
        "bearing": rows([axle.damping]),
        "mass": rows([solid.mass]), "inertia": inertia(solid), "half": half, "radius": radius[:, None],
        "rounding": rounding[:, None], "reach": np.linalg.norm(half, axis=1)[:, None] + radius[:, None],
        "stiffness": rows([solid.stiffness]), "damping_ratio": damping_ratio(rows([solid.restitution])),
        "friction": rows([solid.friction]), "ground_friction": ground,
        "tangential_damping": rows([solid.tangential_damping]), "place": place,
        "orientation": normalized(orientation), "velocity": rows(list(solid.velocity)),
        "spin": rows(list(solid.angular_velocity)), "until": until,
    }  # fmt: skip
    return columns


def joint_in_body(scene: Scene, names: Topology, body: str) -> Floats:
    """Where the joint that carries a body is in its frame (rows, 3), m, from which kernels measure."""
    number = names.bodies.index(body)
    if number == 0:
        return np.zeros((1, 3))
    return rows(list(scene.character.joints[names.joints[number - 1]].position_in_child))


def _capsules(scene: Scene, names: Topology, solids: Sequence[AnyObject]) -> dict[str, Floats]:
    """`kernels.object_structs.ObjectCapsule` of all pairs by field, (rows, pairs, ...); one where there are none."""
    found = []
    for solid in solids:
        for body, shape in _shapes(scene, solid):
            middle, half, radius = capsule_of(shape)
            found.append((middle - joint_in_body(scene, names, body), half, radius[:, None]))
    if not found:
        found = [(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 1)))]
    middle, half, radius = (stacked(part) for part in zip(*found, strict=True))
    reach = np.linalg.norm(half, axis=-1) + radius[..., 0]
    return {"middle": middle, "half": half, "radius": radius[..., 0], "reach": reach}
