"""Where the ground pushed on each body of a recorded motion, and how much: the loads of an inverse dynamics."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.surface import Surface, surface
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import body_accelerations, body_points

LEAST = 1.0  # N, of a force whose centre of pressure counts


@dataclass(frozen=True)
class GroundLoad:
    """The force of the ground on a body in F frames, world axes."""

    body: str
    force: Floats  # (F, 3) N
    point: Floats  # (F, 3) m, centre of pressure in the plane of the ground; the centre of mass where it hardly pushes
    torque: Floats  # (F, 3) N m, about that point


def ground_loads(motion: Recording, scene: Scene) -> list[GroundLoad]:
    """Loads on all bodies that touched the ground.

    Contacts are computed again from recorded coordinates and speeds. Where every step was recorded, accelerations
    follow from the speeds, and loads are those of the simulation. Else forces on a foot and its toes add up to the
    recorded one, of which they have parts as their contacts push, and moments miss what contacts give way over a step.

    Raises:
        Error: a motion of another character, or one without coordinates.
    """
    check_motion_of(motion, scene)
    if not motion.coordinate_names:
        raise Error("this motion was recorded without coordinates, from which ground forces follow; record it again")
    scene = without_code(at_start(scene))
    stages = Stages(scene, max(motion.frames, 1), "cpu")
    coordinates, speeds = (np.asarray(part, np.float32) for part in (motion.coordinate, motion.speed))
    if motion.frames == 0 or coordinates.shape[1] != stages.names.coordinates:
        raise Error("this motion has no frames, or another character's coordinates")
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(speeds)
    accelerations = step_accelerations(motion, float(scene.time_step))
    if accelerations is not None:
        before = np.concatenate([np.zeros_like(accelerations[:1]), accelerations[:-1]])
        stages.state.accelerations.assign(before.astype(np.float32))
        force, moment = _given_way(scene, motion, stages, accelerations)
    else:
        force, moment = (part.astype(np.float64) for part in stages.contact_forces())
    ground = surface(scene.ground)
    normal = ground.plane.normal
    touched = np.flatnonzero(np.abs(force).max(axis=(0, 2)) > LEAST)
    loads = {}
    for body in touched:
        name = stages.names.bodies[body]
        loads[name] = _load(name, force[:, body], moment[:, body], motion.position_of(name), ground)
    if accelerations is not None:
        return list(loads.values())
    for foot, recorded in zip(scene.feet or (), (motion.foot_force_left, motion.foot_force_right), strict=False):
        own = [name for name in foot_bodies(scene.character, foot) if name in loads]
        loads |= _shared([loads[name] for name in own], np.asarray(recorded, np.float64), normal)
    return list(loads.values())


def step_accelerations(motion: Recording, time_step: float) -> Floats | None:
    """Accelerations (F, S) of the steps that begin with each frame, rates of the speeds; the last one as that before.

    They follow from the recorded speeds, which leapfrog has put at the ends of steps (see `kernels.body.integration`).
    None unless every step was recorded.
    """
    if motion.frames < 3 or not np.allclose(np.diff(motion.time), time_step, rtol=0.01):
        return None
    rates = np.diff(np.asarray(motion.speed, np.float64), axis=0) / time_step
    found = np.zeros((motion.frames, rates.shape[1]))
    found[0] = rates[0]
    for k in range(1, len(rates)):
        found[k] = (rates[k] + 0.5 * found[k - 1]) / 1.5
    found[-1] = found[-2]
    return found


def _given_way(scene: Scene, motion: Recording, stages: Stages, accelerations: Floats) -> tuple[Floats, Floats]:
    """Forces and moments about centres of mass (F, B, 3) of contacts over the steps, which accelerate so."""
    contacts = stages.contacts()
    force, moment, a, b, c = (part.astype(np.float64) for part in contacts)
    state = (np.asarray(motion.coordinate, np.float64), np.asarray(motion.speed, np.float64), accelerations)
    moving = body_accelerations(scene, *state)
    places = body_points(scene, state[0])
    for number, name in enumerate(stages.names.bodies):
        linear, angular = moving[name]
        arm = motion.position_of(name) - places[name][0]
        less = np.einsum("nij,nj->ni", c[:, number], linear) + np.einsum("nji,nj->ni", b[:, number], angular)
        turned = np.einsum("nij,nj->ni", a[:, number], angular) + np.einsum("nij,nj->ni", b[:, number], linear)
        force[:, number] -= less
        moment[:, number] -= turned - np.cross(arm, less)
    return force, moment


def _load(body: str, force: Floats, moment: Floats, center: Floats, ground: Surface) -> GroundLoad:
    """A body's load from force and moment about its centre of mass.

    It acts in the plane that touches the ground below the point: of ground that is not flat, below the centre of mass
    first, and then below the point that follows from that.
    """
    point, torque = _on_plane(force, moment, center, ground, center)
    if ground.lie is not None:
        point, torque = _on_plane(force, moment, center, ground, point)
    return GroundLoad(body, force, point, torque)


def _on_plane(force: Floats, moment: Floats, center: Floats, ground: Surface, near: Floats) -> tuple[Floats, Floats]:
    """Where a force and a moment about a centre act in the plane that touches the ground below `near`; the torque."""
    normal = ground.normal_at(near[:, 0], near[:, 2])
    pushed = np.sum(force * normal, axis=1)
    loaded = (pushed > LEAST)[:, None]
    depth = np.sum((near - center) * normal, axis=1) - ground.above(near)
    about = moment - depth[:, None] * np.cross(normal, force)
    arm = depth[:, None] * normal + np.cross(normal, about) / np.maximum(pushed, LEAST)[:, None]
    arm = np.where(loaded, arm, 0.0)
    left = moment - np.cross(arm, force)
    torque = np.where(loaded, normal * np.sum(left * normal, axis=1, keepdims=True), left)
    return center + arm, torque


def _shared(loads: list[GroundLoad], recorded: Floats, normal: Floats) -> dict[str, GroundLoad]:
    """Loads of the bodies of a foot that add up to its recorded force (F, 3), at the places where they were."""
    pushed = np.array([load.force @ normal for load in loads]).reshape(len(loads), -1)
    pushed = np.where(pushed > LEAST, pushed, 0.0)
    total = np.maximum(pushed.sum(axis=0), LEAST) if loads else pushed
    scale = np.where(pushed > 0.0, np.clip(recorded @ normal, 0.0, None) / total, 0.0)
    return {
        load.body: replace(load, force=(part / total)[:, None] * recorded, torque=load.torque * factor[:, None])
        for load, part, factor in zip(loads, pushed, scale, strict=True)
    }
