"""How joints of one coordinate hold and move their child: the motion subspace S(q) and its derivative.

`joint_motion` of a type is all that the device must know of it. A function here is compiled into the step of models
that have such joints, and into no other; `coordinate_joint` makes the stages of the step out of it.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    FIRST_COORDINATE_JOINT,
    Couplings,
    CubicPiece,
    ModelRef,
    ScratchRef,
    StateRef,
    at,
    nonnegative,
)

AT_ONCE = 16  # pieces of a function whose starts are fetched without waiting for one another


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


@func
def slide_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """Translation by q m along the joint's axis."""
    axis = at(model.skeleton.row, instance, body).axis_a
    m = JointMotion()
    m.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    m.place = axis * q
    m.moving = axis
    return m


@func
def turning_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """Rotation by q rad about the joint's axis: a hinge whose coordinate other joints follow."""
    axis = at(model.skeleton.row, instance, body).axis_a
    m = JointMotion()
    m.orientation = hinge_rotation(axis, q)
    m.turning = axis
    return m


@func
def cubic_rates(c: wp.vec4, t: float) -> wp.vec3:
    """Value, first and second derivative of c0 + c1 t + c2 t^2 + c3 t^3."""
    return wp.vec3(
        c[0] + t * (c[1] + t * (c[2] + t * c[3])),
        c[1] + t * (2.0 * c[2] + 3.0 * t * c[3]),
        2.0 * c[2] + 6.0 * t * c[3],
    )


@func
def piece_of(pieces: wp.array2d[CubicPiece], instance: int, first: int, end: int, q: float) -> int:
    """The last of a function's pieces that starts at or before q, or the first one.

    Of a few, all are asked at once: each fetch that waits for the one before takes the time of hundreds of operations.
    """
    low = int(first)
    high = int(end)
    while high - low > AT_ONCE:
        middle = (low + high) // 2
        if at(pieces, instance, middle).start <= q:
            low = middle
        else:
            high = middle
    found = int(low)
    for k in range(low + 1, high):
        if at(pieces, instance, k).start <= q:
            found += 1
    return found


@func
def displacement_rates(couplings: Couplings, instance: int, function: int, q: float) -> wp.vec3:
    """Value, first and second derivative of one of the functions of a coupled joint."""
    own = at(couplings.function, instance, function)
    piece = at(couplings.piece, instance, piece_of(couplings.piece, instance, own.first_piece, own.end_piece, q))
    return cubic_rates(piece.c, q - piece.start)


@func
def coupled_motion(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
    """Turns about three axes in order, each riding on those before, and moves along three axes of the parent.

    With w = a_1 f_1' + R_1 a_2 f_2' + R_1 R_2 a_3 f_3' for the rotations R_k by angles f_k(q) about axes a_k.
    """
    m = JointMotion()
    m.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    first = model.couplings.joint[body].first
    for k in range(3):
        f = displacement_rates(model.couplings, instance, first + k, q)
        own = at(model.couplings.function, instance, first + k).axis
        axis = wp.quat_rotate(m.orientation, own)
        m.turning_slope = m.turning_slope + axis * f[2] + wp.cross(m.turning, axis) * f[1]
        m.turning = m.turning + axis * f[1]
        m.orientation = m.orientation * hinge_rotation(own, f[0])
    for k in range(3, 6):
        f = displacement_rates(model.couplings, instance, first + k, q)
        axis = at(model.couplings.function, instance, first + k).axis
        m.place = m.place + axis * f[0]
        m.moving = m.moving + axis * f[1]
        m.moving_slope = m.moving_slope + axis * f[2]
    return m


@func
def has_motion(joint_type: int) -> bool:
    """Whether a joint is one of those whose motion is a function of one coordinate."""
    return joint_type >= FIRST_COORDINATE_JOINT


@wp.func_native(
    snippet="""
auto& one = *wp::address(rates, body);
for (int i = 0; i < 3; ++i)
    one.data[row][i] = value[i];
"""
)
def set_rates(rates: wp.array[wp.mat33], body: int, row: int, value: wp.vec3): ...


@wp.func_native(
    snippet="""
auto& one = *wp::address(rates, body);
return wp::vec3(one.data[row][0], one.data[row][1], one.data[row][2]);
"""
)
def rates_of(rates: wp.array[wp.mat33], body: int, row: int) -> wp.vec3: ...  # fetched alone


@cache
def displacements_stage_of(sparse: bool) -> Any:
    """The Warp function of what the functions of all coupled joints are now, a function a lane. Ends with a barrier.

    Args:
        sparse: whether functions that are 0 everywhere are left out, see `displaced_motion_of`.
    """

    @func
    def displacements_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        couplings = model.couplings
        for k in range(lane, couplings.function.shape[1], lanes):
            body = at(couplings.function, instance, k).body
            if wp.static(sparse):
                body *= at(couplings.function, instance, k).counts
            if body > 0:
                q = state.coordinates[instance, nonnegative(model.skeleton.plan[body].coordinate_start)]
                rates = displacement_rates(couplings, instance, k, q)
                row = k - couplings.joint[body].first
                if row < 3:
                    set_rates(work.turn_rates, body, row, rates)
                else:
                    set_rates(work.move_rates, body, row - 3, rates)
        synchronize()

    return displacements_stage


@cache
def displaced_motion_of(sparse: bool) -> Any:
    """The Warp function of `coupled_motion` from what `displacements_stage` has left.

    Args:
        sparse: whether functions that are 0 everywhere are left out. That takes less time where numbers come from main
            memory, and more where they are near.
    """

    @func
    def displaced_motion(instance: int, body: int, model: ModelRef, work: ScratchRef) -> JointMotion:
        m = JointMotion()
        m.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
        first = model.couplings.joint[body].first
        for k in range(3):
            if wp.static(sparse) and at(model.couplings.function, instance, first + k).counts == 0:
                continue
            f = rates_of(work.turn_rates, body, k)
            own = at(model.couplings.function, instance, first + k).axis
            axis = wp.quat_rotate(m.orientation, own)
            m.turning_slope = m.turning_slope + axis * f[2] + wp.cross(m.turning, axis) * f[1]
            m.turning = m.turning + axis * f[1]
            m.orientation = m.orientation * hinge_rotation(own, f[0])
        for k in range(3):
            if wp.static(sparse) and at(model.couplings.function, instance, first + 3 + k).counts == 0:
                continue
            f = rates_of(work.move_rates, body, k)
            axis = at(model.couplings.function, instance, first + 3 + k).axis
            m.place = m.place + axis * f[0]
            m.moving = m.moving + axis * f[1]
            m.moving_slope = m.moving_slope + axis * f[2]
        return m

    return displaced_motion


@func
def no_motion(instance: int, body: int, q: float, model: ModelRef, work: ScratchRef) -> JointMotion:
    """The motion of no joint at all."""
    return JointMotion()


def has_displacements(joints: tuple[MotionOf, ...]) -> bool:
    """Whether some joints are coupled, so that `displacements_stage` comes before their motion."""
    return any(joint.motion is coupled_motion for joint in joints)


@cache
def motion_of(joints: tuple[MotionOf, ...], displaced: bool = False, sparse: bool = False) -> Any:
    """The Warp function (instance, body, q, model, work) -> JointMotion of the joint that carries a body.

    Args:
        displaced: whether `displacements_stage` comes before. sparse: see `displaced_motion_of`.
    """
    if not joints:
        return no_motion
    number, motion, others = joints[0].number, joints[0].motion, motion_of(joints[1:], displaced, sparse)
    prepared, from_rates = displaced and motion is coupled_motion, displaced_motion_of(sparse)

    @wp.func
    def joint_motion(instance: int, body: int, q: float, model: ModelRef, work: ScratchRef) -> JointMotion:
        if model.skeleton.plan[body].joint_type == number:
            if wp.static(prepared):
                return from_rates(instance, body, model, work)
            else:
                return motion(instance, body, q, model)
        return others(instance, body, q, model, work)

    return joint_motion
