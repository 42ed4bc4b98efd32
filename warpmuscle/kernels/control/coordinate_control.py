"""SIMBICON's PD control of joints of one coordinate, which follow a coordinate and no orientation."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_outer
from warpmuscle.kernels.body.coordinate_joint import coordinate_axis
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.control.simbicon_equations import strength_by_height
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at


@func
def target_coordinate(target: wp.quat, axis: wp.vec3) -> float:
    """The coordinate that a trajectory's rotation stands for: its turn about the joint's axis, as rad or m."""
    return 2.0 * wp.atan2(wp.dot(wp.vec3(target[0], target[1], target[2]), axis), target[3])


@func
def coordinate_torque(instance: int, body: int, factor: float, model: ModelRef, work: ScratchRef):
    """PD of the joint of a body towards its target, linearised over the step if PD is implicit, into `work`.

    Args:
        factor: of torque and implicit inertia, after the bound.
    """
    gains = at(model.simbicon.gains, instance, body)
    now = work.coordinate_state[body]
    local = at(model.skeleton.row, instance, body).axis_a
    strength = work.strength[body]
    damping = gains.kd
    inertia = wp.float32(0.0)
    if model.implicit_pd == 1:
        damping += model.time_step * gains.kp
        inertia = strength * model.time_step * damping
    error = target_coordinate(work.target[body], local) - now[0]
    wanted = strength * (damping * (now[1] - now[2]) - gains.kp * error)
    bounded = wp.clamp(wanted, -gains.torque_limit, gains.torque_limit)
    if bounded != wanted:
        inertia = 0.0
    axis = coordinate_axis(instance, body, model, work)
    work.torque[body] = axis * (bounded * factor)
    work.stiffness[body] = symmetric_outer(axis, inertia * factor)


@cache
def coordinate_control_stage_of(above: Any) -> Any:
    """The Warp function of this stage; above: see `simbicon.simbicon_stages_of`."""

    @func
    def coordinate_control_stage(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        """Torques of joints of one coordinate in place of what `simbicon.torques_stage` gave. Ends with a barrier."""
        factor = strength_by_height(above(instance, work.position[0], model))
        for body in range(1 + lane, model.body_count, lanes):
            if has_motion(model.skeleton.plan[body].joint_type):
                coordinate_torque(instance, body, wp.min(factor, 1.0), model, work)
        synchronize()

    return coordinate_control_stage


coordinate_control_stage = coordinate_control_stage_of(above_ground)
