"""The ground and the shapes that touch it, from geoms: a level plane, and spheres, capsules and boxes over it."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.mujoco.reference import WORLD, Reference
from warpmuscle.formats.osim.placement import vector
from warpmuscle.scene import Box, Capsule, Character, Ground, Shape, Sphere

PLANE, SPHERE, CAPSULE, BOX = 0, 2, 3, 6  # mjtGeom
LEVEL = 1.0e-6  # of a normal, or of a box's axes, across ours


def build_contact(reference: Reference, character: Character) -> Ground:
    """The ground; bodies get the shapes that may touch it, and the rest is noted."""
    model, data = reference.model, reference.data
    plane = _plane(reference)
    if plane is None:
        return Ground(stiffness=0.0)
    lost: dict[str, int] = {}
    for geom in range(model.ngeom):
        lead = reference.lead(int(model.geom_bodyid[geom]))
        meets = model.geom_contype[geom] & model.geom_conaffinity[plane]
        meets |= model.geom_contype[plane] & model.geom_conaffinity[geom]
        if lead == WORLD or not meets:
            continue
        moved = reference.moved[lead]
        shape = _shape(reference, geom, reference.point(data.geom_xpos[geom]) - moved.center)
        if shape is None:
            lost[moved.name] = lost.get(moved.name, 0) + 1
        else:
            body = character.bodies[moved.name]
            body.friction = float(model.geom_friction[geom, 0])
            body.shapes.append(shape)
    for name, count in lost.items():
        what = f"{number_of(count, 'geom')} of it {'touches' if count == 1 else 'touch'} nothing"
        reason = f"{what}: only spheres, capsules and upright boxes do"
        reference.lose(f"body {name}", reason)
    return Ground(height=float(reference.point(data.geom_xpos[plane])[1]))


def _plane(reference: Reference) -> int | None:
    """The first level plane that does not move."""
    model, data = reference.model, reference.data
    for geom in range(model.ngeom):
        if model.geom_type[geom] != PLANE or reference.lead(int(model.geom_bodyid[geom])) != WORLD:
            continue
        normal = reference.axes @ data.geom_xmat[geom].reshape(3, 3)[:, 2]
        if normal[1] > 1.0 - LEVEL and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            return geom
    return None


def _shape(reference: Reference, geom: int, center: Floats) -> Shape | None:
    """The shape of a geom with its centre in its body, if there is one for it."""
    model = reference.model
    turn = reference.axes @ reference.data.geom_xmat[geom].reshape(3, 3)
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == SPHERE:
        return Sphere(vector(center), float(size[0]))
    if kind == CAPSULE:
        along = turn[:, 2] * float(size[1])
        return Capsule(vector(center - along), vector(center + along), float(size[0]))
    if kind == BOX and np.all(np.min(np.abs(np.abs(turn)[..., None] - [0.0, 1.0]), axis=-1) < LEVEL):
        half = np.abs(turn) @ size
        return Box(vector(center - half), vector(center + half))
    return None
