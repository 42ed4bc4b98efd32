"""What warpmuscle computes of a scene from a MuJoCo model in drawn poses: for `mujoco_agreement.py`."""

from __future__ import annotations

import msgspec
import numpy as np
from mujoco_poses import Floats, Poses

from warpmuscle.core.pose import rotate
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages

INSTANT = 1e-7  # s, a step in which no activation changes


def computed(scene: Scene, found: Poses) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Lengths, speeds (N, M), arms (N, M, F), forces (N, M) and accelerations (N, F), as those of `Poses`."""
    ground = msgspec.structs.replace(scene.ground, stiffness=0.0)
    joints = {
        name: msgspec.structs.replace(joint, limit_stiffness=0.0, limit_damping=0.0)
        for name, joint in scene.character.joints.items()
    }
    character = msgspec.structs.replace(scene.character, joints=joints)
    scene = msgspec.structs.replace(
        scene, character=character, ground=ground, time_step=INSTANT, duration=INSTANT
    )  # fmt: skip
    names, count = topology(character), len(found.q)
    stages = Stages(scene, count, "cpu")
    places, speeds = stages.state.coordinates.numpy(), stages.state.speeds.numpy()
    first = names.speed_start[1]
    if first:
        places[:, :7], speeds[:, :6] = found.root[:, :7], found.root[:, 7:]
    column_of = {name: k for k, name in enumerate(found.names) if name != "root"}
    own = {}
    for body, name in enumerate(names.joints, start=1):
        if name in column_of:
            own[name] = names.coordinate_start[body], names.speed_start[body]
            places[:, own[name][0]] = found.q[:, column_of[name]]
            speeds[:, own[name][1]] = found.v[:, column_of[name]]
    stages.state.coordinates.assign(places)
    stages.state.speeds.assign(speeds)
    paths = stages.muscle_paths()
    order = [list(character.muscles).index(name) for name in found.muscles]
    arm = _arms(stages, found, order, column_of)
    simulated = list(stages.structure.actuation.muscles)
    levels = np.zeros((count, len(simulated)), dtype=np.float32)
    for k, name in enumerate(found.muscles):
        if name in simulated:
            levels[:, simulated.index(name)] = found.activation[:, k]
    stages.state.muscles.activation.assign(levels)
    torque, quantities = stages.muscle_torques(0.0)
    rates = stages.forward_dynamics(torque)["speed_rate"].astype(float)
    force = np.full(found.force.shape, np.nan)
    for k, name in enumerate(found.muscles):
        if name in simulated:
            force[:, k] = quantities["muscle_force"][:, simulated.index(name)]
    acceleration = np.zeros(found.acceleration.shape)
    acceleration[:, :first] = rates[:, :first]
    for name, column in column_of.items():
        acceleration[:, column] = rates[:, own[name][1]]
    return paths.length[:, order].astype(float), paths.speed[:, order].astype(float), arm, force, acceleration


def _arms(stages: Stages, found: Poses, order: list[int], column_of: dict[str, int]) -> Floats:
    """Lengths by coordinate (N, M, F) m, by virtual work of what the device keeps a crossing."""
    names, character = stages.names, stages.numeric.character
    paths, bodies = stages.muscle_paths(), stages.forward_kinematics()["orientation"].astype(float)
    places = stages.state.coordinates.numpy().astype(float)
    arm = np.zeros(found.arm.shape)
    where = {muscle: k for k, muscle in enumerate(order)}
    for crossing, (muscle, joint) in enumerate(zip(paths.muscle, paths.joint, strict=True)):
        name = names.joints[joint]
        if name not in column_of or muscle not in where:
            continue
        entry = character.joints[name]
        own = places[:, names.coordinate_start[joint + 1] : names.coordinate_start[joint + 2]]
        along = rotate(bodies[:, names.parents[joint + 1]], joint_type(entry).pulled_about(entry, own)[0])
        pulled = paths.moment_arm[:, crossing].astype(float)
        arm[:, where[muscle], column_of[name]] += np.sum(pulled * along, axis=1)
    return arm
