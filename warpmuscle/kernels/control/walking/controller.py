"""The walking controller, as scenes choose it by `type = "walking"`."""

import warp as wp

from warpmuscle.kernels.control.control import CustomController, ExplicitDamping
from warpmuscle.kernels.control.walking.body import damping_of, torque_on
from warpmuscle.kernels.control.walking.parameters import OF_BODY, RECORDED, STATE, Walking, WalkingJoint
from warpmuscle.kernels.control.walking.plan import renew_plan
from warpmuscle.kernels.control.walking.torques import renew_torques
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BALL, FIXED, UNIVERSAL, ModelRef, ScratchRef, StateRef, at


@func
def walking_update(
    instance: int, model: ModelRef, state: StateRef, work: ScratchRef, parameters: Walking,
    joints: wp.array[WalkingJoint], memory: wp.array[float],
):  # fmt: skip
    """Plan and torques of this moment, into the memory."""
    renew_plan(instance, parameters, model, state, work, memory)
    renew_torques(instance, parameters, joints, model, state, work, memory)


@func
def walking_effort(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> wp.vec3:
    """Efforts along the speeds of the joint that carries a body: the parts of its torque along their axes, N m."""
    torque = torque_on(body, memory)
    kind = model.skeleton.plan[body].joint_type
    if kind == FIXED:
        return wp.vec3(0.0)
    if kind == BALL:
        return wp.transpose(work.rotation[body]) * torque
    row = at(model.skeleton.row, instance, body)
    effort = wp.vec3(wp.dot(torque, work.rotation[body] * row.axis_a), 0.0, 0.0)
    if kind == UNIVERSAL:
        effort[1] = wp.dot(torque, work.rotation[model.skeleton.plan[body].parent] * row.axis_b)
    return effort


@func
def walking_damping(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> wp.vec3:
    """Damping of the joint that carries a body; a hinge or universal joint has the same about all axes."""
    return damping_of(body, memory)


walking = CustomController(
    effort=walking_effort,
    damping=walking_damping,
    explicit=ExplicitDamping(of_body=True),
    update=walking_update,
    parameters=Walking,
    by_joint=WalkingJoint,
    state=STATE,
    state_a_body=OF_BODY,
    recorded=RECORDED,
    legs=True,
    description="walking at any speed and heading, by an inverted pendulum and virtual forces",
)
