"""Equalities between bodies as constraints of a scene, as far as it can start where they are met."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.mujoco.reference import WORLD, Reference
from warpmuscle.formats.osim.build_skeleton import state_at
from warpmuscle.formats.osim.placement import quaternion
from warpmuscle.scene import Constraint, Scene
from warpmuscle.scene.constraints.pose import (
    MISSED,
    is_kinematic,
    meeting_speeds,
    met_pose,
    movers,
    start_coordinates,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import topology

CONNECT, WELD = 0, 1  # mjtEq
SITE = 6  # mjtObj
ENDLESS, NOTED = 1.0e3, 1.0e-6  # rad or m: how far coordinates may go; what is moved


def loops_of(reference: Reference) -> list[int]:
    """Numbers of the equalities that connect or weld two bodies that move apart."""
    model = reference.model
    return [
        eq
        for eq in range(model.neq)
        if model.eq_type[eq] in (CONNECT, WELD)
        and model.eq_active0[eq]
        and len({reference.lead(body) for body in _bodies(reference, eq)}) == 2
    ]


def loops_on_world(reference: Reference) -> bool:
    """Whether one of them is fixed to what does not move."""
    return any(WORLD in map(reference.lead, _bodies(reference, eq)) for eq in loops_of(reference))


def put_loops(reference: Reference, scene: Scene) -> None:
    """Put them into a scene and let it start where they are met; where there is no such pose near by they are noted."""
    model, constraints = reference.model, scene.character.constraints
    for eq in loops_of(reference):
        constraints[model.equality(eq).name or f"equality{eq}"] = _constraint(reference, eq)
    if constraints and not _close(reference, scene):
        for name in constraints:
            reference.lose(f"equality {name}", "holds nothing here: it cannot be met near the pose of the start")
        constraints.clear()
    for name in constraints:
        reference.lose(f"equality {name}", "holds exactly; MuJoCo's gives way")


def _bodies(reference: Reference, eq: int) -> tuple[int, int]:
    model = reference.model
    first, second = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
    if model.eq_objtype[eq] == SITE:
        first, second = int(model.site_bodyid[first]), int(model.site_bodyid[second])
    return first, second


def _constraint(reference: Reference, eq: int) -> Constraint:
    """The constraint of an equality: what it holds together are a point, or a frame, on each body."""
    model, data = reference.model, reference.data
    bodies, weld = _bodies(reference, eq), model.eq_type[eq] == WELD
    if model.eq_objtype[eq] == SITE:
        sites = (int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq]))
        places = [data.site_xpos[site] for site in sites]
        turns = [data.site_xmat[site].reshape(3, 3) for site in sites]
    else:
        own = [data.xmat[body].reshape(3, 3) for body in bodies]
        numbers = model.eq_data[eq]
        points = (numbers[3:6], numbers[:3]) if weld else (numbers[:3], numbers[3:6])  # a weld has its anchor first
        places = [data.xpos[body] + turn @ point for body, turn, point in zip(bodies, own, points, strict=True)]
        turns = [own[0] @ _matrix(numbers[6:10]), own[1]] if weld else own
    (body, place), (other, other_place) = (reference.on(*both) for both in zip(bodies, places, strict=True))
    made = Constraint("weld" if weld else "point", body, other, place, other_place)
    if weld:
        made.orientation, made.other_orientation = (quaternion(reference.axes @ turn) for turn in turns)
    return made


def _matrix(turn: Floats) -> Floats:
    """The rotation matrix of a quaternion w, x, y, z."""
    w, x, y, z = turn / np.linalg.norm(turn)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def _close(reference: Reference, scene: Scene) -> bool:
    """Move the start to the nearest pose that meets all constraints; whether there is one."""
    character, start = scene.character, scene.initial_state.joints
    names = topology(character)
    free = [
        name
        for name in movers(character, names)
        if not character.joints[name].follows
        and joint_type(character.joints[name]).scalars == 1
        and not is_kinematic(scene, name)
    ]
    chosen = [names.coordinates_of(names.body_of_joint(name)).start for name in free]
    before = start_coordinates(scene, names)
    far = np.full(len(free), ENDLESS)
    q, missing = met_pose(character, names, before, chosen, -far, far)
    if missing > MISSED:
        return False
    speeds = meeting_speeds(character, names, q, chosen, np.zeros(len(chosen)))
    changes = np.abs(q - before)[0, chosen]
    if changes.max(initial=0.0) > NOTED:
        for name, value, speed in zip(free, q[0, chosen], speeds, strict=True):
            start[name] = state_at(character.joints[name], float(value), float(speed))
        reference.lose("equality", "the scene starts where constraints are met, as near as can be to the model's pose")
    return True
