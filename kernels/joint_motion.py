"""How joints of one coordinate hold and move their child: the motion subspace S(q) and its derivative.

`joint_motion` of a type is all that the device must know of it. A function here is compiled into the step of models
that have such joints, and into no other; `coordinate_joint` makes the stages of the step out of it.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.structs import FIRST_COORDINATE_JOINT, ModelRef, at


@wp.struct
class JointMotion:
    """A joint at one value of its coordinate q; in the parent's axes."""

    orientation: wp.quat  # of the child in its parent
    place: wp.vec3  # m, of the child's joint point from that of the parent
    turning: wp.vec3  # angular velocity of the child by a unit of q': the angular half of S
    moving: wp.vec3  # velocity of its joint point by a unit of q': the linear half
    turning_slope: wp.vec3  # dS/dq, angular half
    moving_slope: wp.vec3  # and linear half


class MotionOf(NamedTuple):
    """What is compiled in for a type of joint."""

    number: int  # of the type, `structs.FIRST_COORDINATE_JOINT` or greater
    motion: Any  # a Warp function (instance, body, q, model) -> JointMotion


@wp.func
def slide_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """Translation by q m along the joint's axis."""
    axis = at(model.skeleton.row, instance, body).axis_a
    m = JointMotion()
    m.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    m.place = axis * q
    m.moving = axis
    return m


@wp.func
def has_motion(joint_type: int) -> bool:
    """Whether a joint is one of those whose motion is a function of one coordinate."""
    return joint_type >= FIRST_COORDINATE_JOINT


@wp.func
def no_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """The motion of no joint at all."""
    return JointMotion()


@cache
def motion_of(joints: tuple[MotionOf, ...]) -> Any:
    """The Warp function (instance, body, q, model) -> JointMotion of the joint that carries a body."""
    if not joints:
        return no_motion
    number, motion, others = joints[0].number, joints[0].motion, motion_of(joints[1:])

    @wp.func
    def joint_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
        if model.skeleton.plan[body].joint_type == number:
            return motion(instance, body, q, model)
        return others(instance, body, q, model)

    return joint_motion
