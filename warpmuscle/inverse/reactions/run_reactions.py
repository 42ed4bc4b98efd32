"""Joint reactions of a simulated run: what bones put on each other while its muscles pull and the ground pushes.

In every frame the recorded state, torques and tensions say all: forward dynamics gives the accelerations with the
contacts that belong to them, inverse dynamics what every joint transmits, and from that the muscles' pull is taken, as
for recorded motions. Nothing is differentiated in time, so that frames may be as far apart as one likes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.arguments import as_kind
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import rotate
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.reactions.joint_reactions import JointReactions, check_ends, transmitted
from warpmuscle.results.recording import Recording
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.masses import body_mass

NEEDED = ("coordinate", "speed", "joint_torque")


class RunReactions(NamedTuple):
    """Reactions of a run, and what they leave open.

    Attributes:
        reactions: of all joints. residual: (F,) N, that the root would need beside all that is known, where it
            moves freely.
        weight: N, of the body.
    """

    reactions: JointReactions
    residual: Floats
    weight: float


def run_reactions(
    scene: SceneLike,
    motion: Recording,
    *,
    on: str = "child",
    frame: str = "child",
    device: str | None = None,
    trust: bool = False,
) -> RunReactions:
    """Joint reactions of a simulated run in all recorded frames; signs and axes as in `joint_reactions`.

    Muscles pull along their lines of action, and the ground pushes on feet. What drives a joint besides, such as
    torques of motors, springs and stops, acts through the joint, and is part of its moment. Forces that the frame does
    not tell (water, objects, pushes, bodies that touch each other) are missing.

    Args:
        scene: that made the run. motion: with coordinates, speeds, torques, and forces of muscles if there are any.
        on: "child" or "parent", which body a joint acts on. frame: whose axes are meant, or "ground".

    Raises:
        ArgumentError: a quantity was not recorded, the motion is of another body, or muscles have no lines of action.
        SceneError: the scene cannot be read. RolloutError: no such device.
    """
    as_kind(Recording, motion, "motion")
    check_ends(on, frame)
    body = BodyModel(scene, device, trust=trust)
    _check(body, motion)
    states = _states(motion)
    parts = [_part(body, states, motion, part) for part in body.chunks(len(motion.time))]
    rates, *loads = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    states = States(states.coordinates, states.speeds, rates, states.by_root)
    on_bodies = BodyLoads(list(range(len(body.topology.bodies))), *loads)
    dynamics = body.dynamics(states, on_bodies)
    trials = Prepared([motion.time], states, on_bodies, np.zeros((len(motion.time), 0)))
    tension = motion.muscle_force if motion.muscle_names else None
    found = transmitted(body, trials, tension, dynamics, on, frame)[0]
    moving = len(root_type(body.scene.character).moving)
    weight = body_mass(body.scene.character) * first_number(body.scene.gravity)
    return RunReactions(found, np.linalg.norm(dynamics.effort[:, :moving], axis=1), weight)


def _check(body: BodyModel, motion: Recording) -> None:
    """Raise ArgumentError where a motion lacks what is needed, or is of another body."""
    needed = [*NEEDED, *(["muscle_force"] if motion.muscle_names else [])]
    lacking = [name for name in needed if name in motion.missing]
    if lacking:
        raise ArgumentError(f"the motion was recorded without {', '.join(lacking)}; record all quantities")
    if motion.body_names != tuple(body.topology.bodies) or motion.muscle_names != body.muscles:
        raise ArgumentError("the motion is of another body than the scene's, or its muscles are others")
    if not len(motion.time):
        raise ArgumentError("the motion has no frames")


def _states(motion: Recording) -> States:
    """Recorded states, of unknown rates."""
    q, v = np.asarray(motion.coordinate), np.asarray(motion.speed)
    return States(q, v, np.zeros_like(v), np.zeros((len(q), 0, 0)))


def _part(body: BodyModel, states: States, motion: Recording, part: slice) -> tuple[Floats, ...]:
    """Rates of speeds of some frames, and forces, points and moments of the ground on all bodies."""
    stages, n = body.stages(states, part), part.stop - part.start
    room, names = stages.instances, body.topology
    torque = np.zeros((room, len(names.joints), 3))
    torque[:n] = motion.joint_torque[part]
    found = stages.forward_dynamics(torque)
    placed, contacts = stages.forward_kinematics(), stages.contacts()
    turning, center = found["angular_acceleration"], placed["position"]
    arm = rotate(placed["orientation"], np.broadcast_to(_arms(body), center.shape))
    spin = placed["angular_velocity"]
    joint = found["acceleration"] - np.cross(turning, arm) - np.cross(spin, np.cross(spin, arm))
    force = contacts.force - _times(contacts.c, joint) - _times(contacts.b.swapaxes(2, 3), turning)
    moment = contacts.moment + np.cross(arm, contacts.force) - _times(contacts.a, turning) - _times(contacts.b, joint)
    point = center - arm
    return tuple(np.asarray(array[:n], np.float64) for array in (found["speed_rate"], force, point, moment))


def _arms(body: BodyModel) -> Floats:
    """Where centres of mass (B, 3) are from the joint that carries a body, m, body axes."""
    found = np.zeros((len(body.topology.bodies), 3))
    for number, name in enumerate(body.topology.joints, start=1):
        found[number] = -np.array(body.scene.character.joints[name].position_in_child, dtype=np.float64)
    return found


def _times(matrices: Floats, vectors: Floats) -> Floats:
    return np.asarray(np.einsum("nbij,nbj->nbi", matrices, vectors))
