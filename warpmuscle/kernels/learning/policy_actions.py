"""Actions of a policy as what muscles and joints are told, and joints that follow targets of a policy."""

import warp as wp

from warpmuscle.kernels.body.kinematics import coordinate_quat
from warpmuscle.kernels.muscle.muscle_control import within
from warpmuscle.kernels.structs import BALL, FIXED, ModelRef, ScratchRef, StateRef, at

wp.set_module_options({"enable_backward": False})

LEAST_ANGLE = 1.0e-6  # rad


@wp.func
def finite(value: float) -> float:
    """The value, and nothing for what is none."""
    return wp.where(wp.abs(value) < 1.0e6, value, 0.0)


@wp.kernel
def take_actions(
    # in
    requested: wp.array2d[float],
    # in and out
    action: wp.array2d[float], previous: wp.array2d[float],
):  # fmt: skip
    """Take what a policy says, and keep what it said before. Launch with dim = (instances, actions)."""
    i, k = wp.tid()
    previous[i, k] = action[i, k]
    action[i, k] = finite(requested[i, k])


@wp.kernel
def excite(
    # in
    action: wp.array2d[float], offset: float, scale: float,
    # out
    excitation: wp.array2d[float],
):  # fmt: skip
    """Excitations clip(offset + scale action, 0, 1). Launch with dim = (instances, muscles)."""
    i, k = wp.tid()
    excitation[i, k] = within(offset + scale * action[i, k])


@wp.kernel
def excite_synergies(
    # in
    action: wp.array2d[float], offset: float, scale: float, weights: wp.array2d[float],
    # out
    excitation: wp.array2d[float],
):  # fmt: skip
    """Excitations by synergies of weights (synergies, muscles). Launch with dim = (instances, muscles)."""
    i, m = wp.tid()
    total = wp.float32(0.0)
    for s in range(weights.shape[0]):
        total += wp.max(offset + scale * action[i, s], 0.0) * weights[s, m]
    excitation[i, m] = within(total)


@wp.kernel
def aim(
    # in
    action: wp.array2d[float], middle: wp.array[float], scale: float,
    # out
    effort: wp.array2d[float],
):  # fmt: skip
    """Torques or targets: middle + scale action, in the first columns. Launch with dim = (instances, actions)."""
    i, k = wp.tid()
    effort[i, k] = middle[k] + scale * action[i, k]


@wp.func
def rotation_vector(q: wp.quat) -> wp.vec3:
    """Axis times angle of a rotation, on the shorter way, rad."""
    v = wp.vec3(q[0], q[1], q[2])
    sine = wp.length(v)
    if sine < LEAST_ANGLE:
        return v * wp.where(q[3] < 0.0, -2.0, 2.0)
    return v * (2.0 * wp.atan2(wp.where(q[3] < 0.0, -sine, sine), wp.abs(q[3])) / sine)


@wp.func
def rotation_by(v: wp.vec3) -> wp.quat:
    """The rotation of an axis times angle, rad."""
    angle = wp.length(v)
    if angle < LEAST_ANGLE:
        return wp.quat(0.0, 0.0, 0.0, 1.0)
    return wp.quat_from_axis_angle(v / angle, angle)


@wp.func
def target_effort(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """PD efforts of a joint towards targets of a policy, N m.

    `Actuation.effort` has three numbers for each speed of a joint: all targets, rad, then all stiffnesses, N m/rad, and
    all dampings, N m s/rad. The targets of a ball joint are a rotation vector.
    """
    plan = model.skeleton.plan[body]
    effort = wp.vec3(0.0)
    count = plan.speed_end - plan.speed_start
    if plan.joint_type == FIXED or count == 0:
        return effort
    column = plan.speed_start - model.skeleton.plan[1].speed_start
    width = model.actuation.effort.shape[1] / 3
    error = wp.vec3(0.0)
    if plan.joint_type == BALL:
        target = wp.vec3(
            at(model.actuation.effort, instance, column),
            at(model.actuation.effort, instance, column + 1),
            at(model.actuation.effort, instance, column + 2),
        )
        now = coordinate_quat(state, instance, plan.coordinate_start)
        error = rotation_vector(wp.quat_inverse(now) * rotation_by(target))
    else:
        for k in range(count):
            error[k] = (
                at(model.actuation.effort, instance, column + k)
                - state.coordinates[instance, plan.coordinate_start + k]
            )
    for k in range(count):
        stiffness = at(model.actuation.effort, instance, width + column + k)
        damping = at(model.actuation.effort, instance, 2 * width + column + k)
        effort[k] = stiffness * error[k] - damping * state.speeds[instance, plan.speed_start + k]
    return effort
