"""Where the ground pushed on each body of a recorded motion, and how much: the loads of an inverse dynamics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import normalized
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.simulation.stages import Stages

LEAST = 1.0  # N, of a force whose centre of pressure counts


@dataclass(frozen=True)
class GroundLoad:
    """The force of the ground on a body in F frames, world axes."""

    body: str
    force: Floats  # (F, 3) N
    point: Floats  # (F, 3) m, centre of pressure in the plane of the ground; the centre of mass where there is no force
    torque: Floats  # (F, 3) N m, about that point


def ground_loads(motion: Recording, scene: Scene) -> list[GroundLoad]:
    """Loads on all bodies that touched the ground.

    Contacts are computed again from recorded coordinates and speeds. The forces on a foot and its toes add up to the
    recorded one, of which they have parts as their contacts push.

    Raises:
        Error: a motion of another character, or one without coordinates.
    """
    check_motion_of(motion, scene)
    if not motion.coordinate_names:
        raise Error("this motion was recorded without coordinates, from which ground forces follow; record it again")
    scene = without_code(substitute(scene, start_values(scene)))
    stages = Stages(scene, max(motion.frames, 1), "cpu")
    coordinates, speeds = (np.asarray(part, np.float32) for part in (motion.coordinate, motion.speed))
    if motion.frames == 0 or coordinates.shape[1] != stages.names.coordinates:
        raise Error("this motion has no frames, or another character's coordinates")
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(speeds)
    force, moment = (part.astype(np.float64) for part in stages.contact_forces())
    normal = normalized(rows(list(scene.ground.normal)))[0]
    height = float(rows([scene.ground.height])[0, 0])
    touched = np.flatnonzero(np.abs(force).max(axis=(0, 2)) > LEAST)
    loads = {}
    for body in touched:
        name = stages.names.bodies[body]
        loads[name] = _load(name, force[:, body], moment[:, body], motion.position_of(name), normal, height)
    for foot, recorded in zip(scene.feet or (), (motion.foot_force_left, motion.foot_force_right), strict=False):
        own = [name for name in foot_bodies(scene.character, foot) if name in loads]
        loads |= _shared([loads[name] for name in own], np.asarray(recorded, np.float64), normal)
    return list(loads.values())


def _load(body: str, force: Floats, moment: Floats, center: Floats, normal: Floats, height: float) -> GroundLoad:
    """A body's load from force and moment about its centre of mass."""
    pushed = force @ normal
    loaded = (pushed > LEAST)[:, None]
    depth = height - center @ normal
    about = moment - depth[:, None] * np.cross(normal, force)
    arm = depth[:, None] * normal + np.cross(normal, about) / np.maximum(pushed, LEAST)[:, None]
    arm, force = np.where(loaded, arm, 0.0), np.where(loaded, force, 0.0)
    torque = np.where(loaded, normal * ((moment - np.cross(arm, force)) @ normal)[:, None], 0.0)
    return GroundLoad(body, force, center + arm, torque)


def _shared(loads: list[GroundLoad], recorded: Floats, normal: Floats) -> dict[str, GroundLoad]:
    """Loads of the bodies of a foot that add up to its recorded force (F, 3), at the places where they were."""
    pushed = np.array([load.force @ normal for load in loads]).reshape(len(loads), -1)
    total = np.maximum(pushed.sum(axis=0), LEAST) if loads else pushed
    scale = np.clip(recorded @ normal, 0.0, None) / total
    return {
        load.body: replace(load, force=(part / total)[:, None] * recorded, torque=load.torque * scale[:, None])
        for load, part in zip(loads, pushed, strict=True)
    }
