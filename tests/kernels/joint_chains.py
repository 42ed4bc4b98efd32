"""Chains of bodies in random states: their velocities, and accelerations where some coordinates are prescribed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.pose import normalized
from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.body.inertia import body_inertia_of
from warpmuscle.kernels.body.joint_motion import MotionOf, coupled_motion, slide_motion
from warpmuscle.kernels.body.joint_stages import SkeletonKind, joint_stages_of
from warpmuscle.kernels.body.speed_axes import speed_rate_of
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.stages import work_of
from warpmuscle.kernels.structs import FIRST_OF_TABLE, SECOND_HINGE, Model, State
from warpmuscle.model.prescribed_motion import speed_numbers
from warpmuscle.scene import Actuation, Body, Character, Displacement, Failure, Ground, Joint, Motion, Scene
from warpmuscle.simulation.rollout import Rollout

JOINTS = MotionOf(FIRST_OF_TABLE, slide_motion), MotionOf(FIRST_OF_TABLE + 1, coupled_motion)
OF = joint_stages_of(SkeletonKind(JOINTS))
kinematics, prescribe, acceleration, hybrid_acceleration = (
    OF.kinematics, OF.prescribe, OF.acceleration, OF.hybrid_acceleration,
)  # fmt: skip
body_inertia = body_inertia_of(False)
AXES = {
    "hinge": [(0.9, 0.3, -0.2)], "universal": [(0.1, 0.2, 1.0), (1.0, 0.2, 0.0)],
    "ball": [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], "slide": [(0.4, -0.7, 0.5)], "coupled": [],
}  # fmt: skip
COUNT = {"hinge": 1, "universal": 2, "ball": 3, "slide": 1, "coupled": 1}


@cache
def accelerate_of(prescribed: bool) -> Any:
    """The kernel (model, state, workspace, rate) of accelerations (n, S), where some coordinates are prescribed."""

    @wp.kernel(module="unique", enable_backward=False, module_options={"max_unroll": 1})
    def accelerate(model: Model, state: State, workspace: wp.array2d[float], rate: wp.array2d[float]):
        i = wp.tid()
        work = work_of(i, model, workspace)
        kinematics(i, 0, 1, model, state, work)
        for body in range(model.body_count):
            work.torque[body] = wp.vec3(0.0)
            work.stiffness[body] = symmetric(0.0)
        if wp.static(prescribed):
            prescribe(i, 0, 1, model, state, work)
        for body in range(model.body_count):
            body_inertia(i, body, model, work)
        if wp.static(prescribed):
            hybrid_acceleration(i, 0, 1, model, state, work)
        else:
            acceleration(i, 0, 1, model, work)
        for body in range(model.body_count):
            first = model.skeleton.plan[body].speed_start
            for k in range(model.skeleton.plan[body].speed_end - first):
                rate[i, first + k] = speed_rate_of(body, k, model, work)

    return accelerate


@wp.kernel(module="unique", enable_backward=False, module_options={"max_unroll": 1})
def move(model: Model, state: State, workspace: wp.array2d[float], velocity: wp.array3d[wp.vec3]):
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics(i, 0, 1, model, state, work)
    for body in range(model.body_count):
        velocity[i, body, 0] = work.velocity[body]
        velocity[i, body, 1] = work.angular_velocity[body]
        velocity[i, body, 2] = work.lag_velocity[body]
        velocity[i, body, 3] = work.lag_angular[body]


def chain(*drives: tuple[str, Any], root: str = "free") -> Scene:
    """Bodies that hang one on the other from a root, each on a joint of a type with what drives its axes."""
    bodies = {f"body{i}": Body(1.5 - 0.1 * i, (0.02, 0.005 + 0.002 * i, 0.03)) for i in range(len(drives) + 1)}
    joints, actuation, motion = {}, {}, {}
    for i, (kind, drive) in enumerate(drives):
        more: dict[str, Any] = {"axes": AXES[kind]} if AXES[kind] else {
            "rotations": [Displacement((0.0, 0.6, 0.8), 0.1, 1.2)],
            "translations": [Displacement((0.8, 0.0, 0.6), x=[-2.0, -0.3, 0.4, 2.0], y=[-0.1, 0.1, -0.05, 0.1])],
        }  # fmt: skip
        joints[f"joint{i}"] = Joint(kind, f"body{i}", f"body{i + 1}", (0.01, -0.2, 0.02), (0.0, 0.2, 0.01), **more)
        actuation[f"joint{i}"] = Actuation(drive)
        count = ([drive] * COUNT[kind] if isinstance(drive, str) else drive).count("kinematic")
        if count:
            ones = [[0.0, 0.1]] * count
            motion[f"joint{i}"] = Motion([0.0, 1.0], value=ones if count > 1 else ones[0])
    scene = Scene("chain", Character("body0", bodies, joints, root), failure=Failure(0.0, 0.0), duration=0.5)
    scene.ground, scene.actuation, scene.motion = Ground(stiffness=0.0), actuation, motion
    return scene


@dataclass(frozen=True)
class Accelerated:
    """A chain in n states, and how it accelerates where the prescribed coordinates do as given."""

    coordinates: np.ndarray  # (n, C)
    speeds: np.ndarray  # (n, S)
    accelerations: np.ndarray  # (n, S)
    others: np.ndarray  # numbers of the speeds that are not prescribed


def lagging(scene: Scene, count: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (n, bodies, 4, 3) of joints and bodies, and of both what speeds gained in the last half step.

    And what they should have gained: velocities are linear in the speeds, so that their difference is that of these.
    """
    rollout, rng = Rollout(scene, count, "cpu"), np.random.default_rng(2)
    state, names, step = rollout.state, rollout.names, 0.1
    rollout.model.time_step = step
    q = state.coordinates.numpy().astype(float)
    q += 0.4 * rng.normal(size=q.shape)
    if scene.character.root_joint != "planar":
        q[:, 3:7] = normalized(q[:, 3:7])
    for i, name in enumerate(names.joints, 1):
        if scene.character.joints[name].type == "ball":
            at = slice(names.coordinate_start[i], names.coordinate_start[i] + 4)
            q[:, at] = normalized(q[:, at])
    v, a = rng.normal(size=(2, count, names.speeds))
    room = wp.zeros((count, work_floats(capacity_of(len(names.bodies)), True)), dtype=float, device="cpu")
    found = []
    for speeds in (v, v - 0.5 * step * a):
        for array, values in ((state.coordinates, q), (state.speeds, speeds), (state.accelerations, a)):
            array.assign(values.astype(np.float32))
        velocity = wp.zeros((count, len(names.bodies), 4), dtype=wp.vec3, device="cpu")
        wp.launch(move, count, [rollout.model, state, room, velocity], device="cpu")
        found.append(velocity.numpy().astype(float))
    return found[0], found[0][:, :, :2] - found[1][:, :, :2]


def accelerated(scene: Scene, count: int = 8) -> Accelerated:
    """Random states, prescribed accelerations among them, and the accelerations of all coordinates."""
    rollout, rng = Rollout(scene, count, "cpu"), np.random.default_rng(7)
    names, state, model = rollout.names, rollout.state, rollout.model
    q, v = state.coordinates.numpy().astype(float), rng.normal(size=(count, names.speeds)) * 1.5
    q[:, 7:] += 0.5 * rng.normal(size=q[:, 7:].shape)
    q[:, :3], q[:, 3:7] = rng.normal(size=(count, 3)), normalized(rng.normal(size=(count, 4)))
    for i, name in enumerate(names.joints, 1):
        if scene.character.joints[name].type == "ball":
            at = slice(names.coordinate_start[i], names.coordinate_start[i] + 4)
            q[:, at] = normalized(q[:, at])
    numbers = speed_numbers(rollout.structure.kinematic)
    given = np.zeros_like(v)
    given[:, numbers] = 10.0 * rng.normal(size=(count, len(numbers)))
    for array, values in ((state.coordinates, q), (state.speeds, v), (state.accelerations, given)):
        array.assign(values.astype(np.float32))
    model.time_step = 0.0  # speeds are those of the moment itself
    room = wp.zeros((count, work_floats(capacity_of(len(names.bodies)), True)), dtype=float, device="cpu")
    rate = wp.zeros((count, names.speeds), dtype=float, device="cpu")
    wp.launch(accelerate_of(len(numbers) > 0), count, [model, state, room, rate], device="cpu")
    found = rate.numpy().astype(float)
    for body, kind in enumerate(rollout.structure.kinematic.remaining if len(numbers) else ()):
        if kind == SECOND_HINGE:
            first = names.speed_start[body]
            found[:, first + 1] = found[:, first]
    found[:, numbers] = given[:, numbers]
    return Accelerated(q, v, found, np.setdiff1d(np.arange(names.speeds), numbers))
