"""The gait of people by a norm alone, for bodies that no controller moves yet, and states of it to start from.

Hips, knees and ankles bend as the norm says; all other joints stay as the scene starts, and the root is upright. So
every imported model whose feet touch the ground can begin to learn.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.learning.imitation.gait import BINS, Gait, changed
from warpmuscle.learning.imitation.pelvis import FORWARD, UP, orientation_of
from warpmuscle.learning.imitation.table import run_from
from warpmuscle.learning.poses import States, started
from warpmuscle.learning.starts import ControllerGait
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.scene import Scene
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.scene.initial_pose import Poses
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.learning import Imitation, Task
from warpmuscle.scene.norms import PERCENT_OF_BIN, REFERENCES, is_run, running_force, running_stance
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import Stepper

CYCLE_TIME = 2.0 * 60.0 / REFERENCES["cadence"].low  # s, two of people's steps


def by_norm_alone(scene: Scene, imitation: Imitation | None) -> bool:
    """Whether a task's gait is that of people alone: it has no file, and no controller makes one, or none counts."""
    if imitation is None or not imitation.norm or imitation.file:
        return False
    return imitation.norm_alone or scene.simbicon is None


def people_gait(rollout: Rollout, imitation: Imitation, body: BodySymmetry | None = None) -> Gait:
    """One cycle of a norm, whose right foot lands half a cycle after the left one."""
    start = rollout.state.coordinates.numpy()[0].astype(float)
    cycle_time = imitation.cycle_time or CYCLE_TIME
    landings = np.array([0.0, cycle_time])
    gait = Gait(np.tile(start, (BINS, 1)), np.tile(UP, (BINS, 1)), cycle_time, landings, 0.5, is_run(imitation.norm))
    return changed(gait, rollout, imitation, body)


def people_starts(gait: Gait, rollout: Rollout, stepper: Stepper, task: Task) -> ControllerGait:
    """States of the gait to start from, at the middle of the wanted speeds; the rollout is at its own start again.

    Of a gait that becomes a run half of them run, at the middle of the speeds at which it does.
    """
    (low, high), count, switch = task.speed, task.variation.start_states, run_from(task)
    if gait.running is None or switch is None:
        wanted = [people_states(gait, rollout, 0.5 * (low + high), count)]
    else:
        wanted = [
            people_states(gait, rollout, 0.5 * (low + switch), max(count // 2, 1)),
            people_states(gait.running, rollout, 0.5 * (switch + high), max(count // 2, 1)),
        ]
    states = [state for some in wanted for state in started(rollout, stepper, some)]
    return ControllerGait(states, [0.0] * len(states), None)


def people_states(gait: Gait, rollout: Rollout, speed: float, count: int) -> States:
    """States evenly over the cycle, in which the lowest point touches level ground and the root goes forward.

    The root of who runs rises and falls as people's force on the feet lets it, and no point is below the ground.

    Args:
        speed: m/s, of the root. count: how many, at most one a bin of the cycle.
    """
    chosen = np.arange(0, BINS, max(BINS // max(count, 1), 1))
    root, names, zero = root_type(rollout.numeric.character), rollout.names, np.zeros((BINS, 3))
    orientation = orientation_of(gait.up)
    lowest = lowest_points(gait.coordinate, rollout, orientation)
    height = first_number(rollout.numeric.ground.height) - lowest
    rise: Floats = np.zeros(BINS)
    if gait.runs:
        above, rise = bounced(gait, first_number(rollout.numeric.gravity), running_stance(speed))
        carried = running_force(PERCENT[:BINS], running_stance(speed)) > 0.0
        height = np.maximum(height, above + (height - above)[carried].mean())
    place, velocity = zero + height[:, None] * UP, zero + speed * FORWARD + rise[:, None] * UP
    at, moving = root.coordinates_of(place, orientation, velocity, zero)
    at[:, list(root.on_ground)] = gait.coordinate[:, list(root.on_ground)]
    coordinates = np.concatenate([at, gait.coordinate[:, names.coordinate_start[1] :]], axis=1)
    speeds = np.concatenate([moving, joint_speeds(gait, rollout)[:, names.speed_start[1] :]], axis=1)
    return States(coordinates[chosen], speeds[chosen], None)


def bounced(gait: Gait, gravity: float, stance: float) -> tuple[Floats, Floats]:
    """How far a runner's centre of mass is above its mean, m, and how fast it rises, m/s, over the cycle (BINS,).

    Args:
        stance: % of the cycle in which a foot carries.
    """
    time = gait.cycle_time / BINS
    later = (PERCENT_OF_BIN - 100.0 * gait.right) % 100.0
    force = running_force(PERCENT_OF_BIN, stance) + running_force(later, stance)
    speed = np.roll(np.cumsum(force / force.mean() - 1.0), 1) * gravity * time
    speed -= speed.mean()
    height = np.roll(np.cumsum(0.5 * (speed + np.roll(speed, -1))), 1) * time
    return height - height.mean(), speed


def joint_speeds(gait: Gait, rollout: Rollout) -> Floats:
    """Speeds (BINS, S) of all joints in the gait, by central differences over the cycle; those of the root are 0."""
    names, joints = rollout.names, rollout.numeric.character.joints
    found = np.zeros((BINS, len(rollout.speed_names)))
    step = 2.0 * gait.cycle_time / BINS
    after, before = (np.roll(gait.coordinate, shift, axis=0) for shift in (-1, 1))
    for body, name in enumerate(names.joints, start=1):
        kind, span = joint_type(joints[name]), names.joint_coordinates(body)
        own = slice(*names.speed_start[body : body + 2])  # none, of a joint that follows another one
        if kind.quaternion:
            turned = Rotation.from_quat(after[:, span]) * Rotation.from_quat(before[:, span]).inv()
            _, speeds = kind.nearest(joints[name], gait.coordinate[:, span], turned.as_rotvec() / step)
        else:
            speeds = (after[:, span] - before[:, span]) / step
        found[:, own] = speeds
    return found


def poses_over(coordinates: Floats, rollout: Rollout, orientation: Floats) -> Poses:
    """Places and orientations of all bodies over a root at the origin of orientations (n, 4), at coordinates (n, C)."""
    character, names = rollout.numeric.character, rollout.names
    n = len(coordinates)
    poses: Poses = {character.root: (np.zeros((n, 3)), orientation)}
    for body, name in enumerate(names.joints, start=1):
        joint, (moving, speeds) = character.joints[name], names.arguments_of(body)
        motion = joint_type(joint).motion(joint, coordinates[:, moving], np.zeros((n, len(speeds))))
        position, orientation = poses[joint.parent]
        anchor = position + rotate(orientation, first_row(joint.position_in_parent) + motion.place)
        turned = multiply(orientation, motion.orientation)
        poses[joint.child] = anchor - rotate(turned, first_row(joint.position_in_child)), turned
    return poses


def lowest_points(coordinates: Floats, rollout: Rollout, orientation: Floats) -> Floats:
    """Heights (n,) of the lowest point of all shapes over a root of orientations (n, 4), m, at coordinates (n, C)."""
    return np.asarray(lowest_point(rollout.numeric.character, poses_over(coordinates, rollout, orientation)))
