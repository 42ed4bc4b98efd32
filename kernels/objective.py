"""What a step costs, and when an instance has failed."""

import warp as wp

from warpmuscle.kernels.contact import above_ground
from warpmuscle.kernels.spatial import heading, heading_angle
from warpmuscle.kernels.structs import (
    CROSSED,
    DIVERGED,
    FELL,
    RUNNING,
    TOUCHED,
    TURNED,
    ModelRef,
    StateRef,
    WorkRef,
    at,
    rolled,
)


@wp.func
def has_fallen(height: float, start_height: float, fraction: float) -> bool:
    """Whether the centre of mass is below a fraction of its initial height (Bergmann 2017, section 6); NaN has."""
    return not (height >= fraction * start_height)


@wp.func
def has_turned(angle: float, desired: float, largest: float) -> bool:
    """Whether the heading is off by more than `largest` (Bergmann 2017, section 6: 45 degrees); never if 0."""
    error = wp.abs(angle - desired)
    error = wp.min(error, wp.static(2.0 * wp.PI) - error)
    return largest > 0.0 and not (error <= largest)


@wp.func
def has_crossed(apart: float, largest: float) -> bool:
    """Whether the left foot is farther to the right of the right foot than `largest`, m; NaN has."""
    return not (apart >= -largest)


@wp.func
def feet_apart(model: ModelRef, work: WorkRef) -> float:
    """How far the joint of the left foot is to the left of that of the right foot, as the character faces, m."""
    between = work.position[model.simbicon.left_foot] - work.position[model.simbicon.right_foot]
    return wp.quat_rotate_inv(heading(work.orientation[0]), between)[0]


@wp.func
def posture_status(instance: int, model: ModelRef, state: StateRef, work: WorkRef) -> int:
    """Status by the pose at the start of a step: RUNNING, FELL, TURNED or CROSSED."""
    limits = at(model.failure, instance, 0)
    if limits[0] > 0.0:
        height = above_ground(instance, work.center[0], model)
        if has_fallen(height, state.start_height[instance], limits[0]):
            return FELL
    desired = at(model.simbicon.hip, instance, 0)[3]
    if has_turned(heading_angle(work.orientation[0]), desired, limits[1]):
        return TURNED
    if limits[3] > 0.0 and has_crossed(feet_apart(model, work), limits[3]):
        return CROSSED
    return RUNNING


@wp.func
def step_status(model: ModelRef, work: WorkRef) -> int:
    """Status by what happened in a step: RUNNING, DIVERGED or TOUCHED."""
    if work.flags[1] == 1:
        return DIVERGED
    if model.fail_on_body_contact == 1 and work.flags[0] == 1:
        return TOUCHED
    return RUNNING


@wp.func
def effort_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: WorkRef):
    """Add this step's feedback torque of every joint to its integral (Bergmann 2017, section 6). No barrier.

    One sum a joint, in double precision, so that the result does not depend on lanes or on chunks of steps.
    """
    for i in range(1 + lane, model.body_count, lanes):
        rolled()
        effort = wp.length(work.torque[i])
        if effort < 1.0e12:  # also refuses NaN, which the integrator is about to report as divergence
            # not `+=`, which would be an atomic operation
            state.torque_integral[instance, i] = state.torque_integral[instance, i] + wp.float64(effort)
