"""PD control of every joint towards an angle of its own, for characters that no gait controller moves."""

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.control.control import CustomController, ExplicitDamping
from warpmuscle.kernels.control.joint_values import joint_coordinate, joint_speed, joint_speeds
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BALL, ModelRef, ScratchRef, StateRef


@wp.struct
class JointGains:
    """Of a joint; of a slide in N/m, N s/m and m."""

    kp: float  # N m/rad
    kd: float  # N m s/rad
    angle: float  # rad, about its first axis; about others, and of a ball, it is held where it is in the reference pose


@func
def pd_effort(error: float, speed: float, gains: JointGains) -> float:
    """Effort along one speed of a joint, N m: kp error - kd speed."""
    return gains.kp * error - gains.kd * speed


@func
def joint_pd_effort(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, gains: JointGains
) -> wp.vec3:
    """Efforts along the speeds of the joint that carries a body."""
    count = joint_speeds(body, model)
    error = wp.vec3(0.0)
    if model.skeleton.plan[body].joint_type == BALL:
        q = wp.quat(
            joint_coordinate(instance, body, 0, model, state),
            joint_coordinate(instance, body, 1, model, state),
            joint_coordinate(instance, body, 2, model, state),
            joint_coordinate(instance, body, 3, model, state),
        )
        error = pd_error(q, wp.quat(0.0, 0.0, 0.0, 1.0))
    elif count > 0:
        error[0] = gains.angle - joint_coordinate(instance, body, 0, model, state)
        if count > 1:
            error[1] = -joint_coordinate(instance, body, 1, model, state)
    effort = wp.vec3(0.0)
    for k in range(count):
        effort[k] = pd_effort(error[k], joint_speed(instance, body, k, model, state), gains)
    return effort


@func
def joint_pd_damping(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, gains: JointGains
) -> wp.vec3:
    """That of each speed of the joint."""
    return wp.vec3(gains.kd)


joint_pd = CustomController(
    effort=joint_pd_effort,
    damping=joint_pd_damping,
    explicit=ExplicitDamping(),
    by_joint=JointGains,
    description="PD of every joint towards an angle of its own",
)
