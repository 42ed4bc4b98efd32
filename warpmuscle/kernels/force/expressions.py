"""Forces of which a scene says by expressions what they are: along a coordinate, on a body, between two of them.

Programs of the expressions, see `kernels.algebra.programs`, lie in the table of curves; parameters say where.
"""

import warp as wp

from warpmuscle.kernels.algebra.programs import Variables, value_of
from warpmuscle.kernels.force.bushing import BushingFrames, bushing_motion, bushing_wrench
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.force.loads import time_since
from warpmuscle.kernels.force.point_spring import SHORTEST, points_apart
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class CoordinateExpression:
    """An effort along a coordinate: OpenSim's ExpressionBasedCoordinateForce, and actuators with a told control."""

    scale: float  # what the expression is multiplied by
    effort: float  # N m or N, of q, qdot and t


@func
def coordinate_expression(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, given: CoordinateExpression
) -> wp.vec3:
    """Effort along the first coordinate of a joint."""
    plan = model.skeleton.plan[body]
    v = Variables()
    v[0] = state.coordinates[instance, plan.coordinate_start]
    v[1] = state.speeds[instance, plan.speed_start]
    v[2] = time_since(instance, 0.0, model, state)
    return wp.vec3(given.scale * value_of(model.muscles.curve_table, int(given.effort), v), 0.0, 0.0)


@wp.struct
class PointExpression:
    """A pull between two points: OpenSim's ExpressionBasedPointToPointForce, PointToPointActuator."""

    scale: float
    first_x: float  # m, from the centre of mass of the first body
    first_y: float
    first_z: float
    second_x: float  # m, from that of the second body
    second_y: float
    second_z: float
    tension: float  # N, of their distance d, its rate ddot and t; negative pushes


@func
def point_expression(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    given: PointExpression,
) -> Wrench:  # fmt: skip
    """What the pull does to one of its bodies, of which `second` says whether it is the second one."""
    first_end = wp.vec3(given.first_x, given.first_y, given.first_z)
    second_end = wp.vec3(given.second_x, given.second_y, given.second_z)
    line = points_apart(instance, body, other, second, first_end, second_end, model, work)
    length = wp.length(line.apart)
    w = Wrench()
    if length > wp.static(SHORTEST):
        along = line.apart / length
        v = Variables()
        v[0] = length
        v[1] = wp.dot(line.moving, along)
        v[2] = time_since(instance, 0.0, model, state)
        w.force = along * (given.scale * value_of(model.muscles.curve_table, int(given.tension), v))
        w.moment = wp.cross(line.arm, w.force)
    return w


@wp.struct
class BodyExpression:
    """A force over time at a point of a body, and a moment: OpenSim's PrescribedForce and PointActuator."""

    scale: float  # of force and moment
    force_in_body: float  # 1: force and moment are in the body's axes, 0: the world's
    point_in_world: float  # 1: the point is one of the world, 0: of the body, from its centre of mass
    force_x: float  # N, of t
    force_y: float
    force_z: float
    moment_x: float  # N m
    moment_y: float
    moment_z: float
    point_x: float  # m
    point_y: float
    point_z: float


@func
def body_expression(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, given: BodyExpression
) -> Wrench:
    """The force as one at the centre of mass, with its moment."""
    v = Variables()
    v[0] = time_since(instance, 0.0, model, state)
    table = model.muscles.curve_table
    force = given.scale * wp.vec3(
        value_of(table, int(given.force_x), v),
        value_of(table, int(given.force_y), v),
        value_of(table, int(given.force_z), v),
    )
    moment = given.scale * wp.vec3(
        value_of(table, int(given.moment_x), v),
        value_of(table, int(given.moment_y), v),
        value_of(table, int(given.moment_z), v),
    )
    point = wp.vec3(
        value_of(table, int(given.point_x), v),
        value_of(table, int(given.point_y), v),
        value_of(table, int(given.point_z), v),
    )
    axes = work.rotation[body]
    arm = axes * point
    if given.point_in_world == 1.0:
        arm = point - work.position[body] - axes * at(model.skeleton.row, instance, body).com
    w = Wrench()
    w.force = wp.where(given.force_in_body == 1.0, axes * force, force)
    w.moment = wp.where(given.force_in_body == 1.0, axes * moment, moment) + wp.cross(arm, w.force)
    return w


@wp.struct
class TorqueExpression:
    """A torque over time about an axis, on a body and back on another one: OpenSim's TorqueActuator."""

    scale: float
    in_body: float  # 1: the axis is in the axes of the first body, 0: the world's
    axis_x: float
    axis_y: float
    axis_z: float
    torque: float  # N m on the first body, of t


@func
def torque_expression(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    given: TorqueExpression,
) -> Wrench:  # fmt: skip
    """What the torque does to one of its bodies, of which `second` says whether it is the second one."""
    v = Variables()
    v[0] = time_since(instance, 0.0, model, state)
    axis = wp.vec3(given.axis_x, given.axis_y, given.axis_z)
    if given.in_body == 1.0:
        axis = work.rotation[wp.where(second == 1, other, body)] * axis
    torque = given.scale * value_of(model.muscles.curve_table, int(given.torque), v)
    w = Wrench()
    w.moment = axis * wp.where(second == 1, -torque, torque)
    return w


@wp.struct
class BushingExpression:
    """Where two frames are on their bodies, and what acts between them: OpenSim's bushings of functions, expressions.

    Each is of the angles theta_x ... and shifts delta_x ... of the second frame in the first one, and holds it back.
    """

    first_x: float  # m, from the centre of mass of the first body
    first_y: float
    first_z: float
    first_turn_x: float  # rad, rotation vector from the frame's axes to those of the body
    first_turn_y: float
    first_turn_z: float
    second_x: float
    second_y: float
    second_z: float
    second_turn_x: float
    second_turn_y: float
    second_turn_z: float
    damping_tx: float  # N m s/rad
    damping_ty: float
    damping_tz: float
    damping_x: float  # N s/m
    damping_y: float
    damping_z: float
    mx: float  # N m
    my: float
    mz: float
    fx: float  # N
    fy: float
    fz: float


@func
def bushing_expression(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    given: BushingExpression,
) -> Wrench:  # fmt: skip
    """What the bushing does to one of its bodies, of which `second` says whether it is the second one."""
    frames = BushingFrames()
    frames.first = wp.vec3(given.first_x, given.first_y, given.first_z)
    frames.first_turn = wp.vec3(given.first_turn_x, given.first_turn_y, given.first_turn_z)
    frames.second = wp.vec3(given.second_x, given.second_y, given.second_z)
    frames.second_turn = wp.vec3(given.second_turn_x, given.second_turn_y, given.second_turn_z)
    m = bushing_motion(
        instance, wp.where(second == 1, other, body), wp.where(second == 1, body, other), frames, model, work
    )
    v = Variables()
    for k in range(3):
        v[k] = m.angles[k]
        v[3 + k] = m.shift[k]
    table = model.muscles.curve_table
    about = wp.vec3(
        value_of(table, int(given.mx), v), value_of(table, int(given.my), v), value_of(table, int(given.mz), v)
    )
    along = wp.vec3(
        value_of(table, int(given.fx), v), value_of(table, int(given.fy), v), value_of(table, int(given.fz), v)
    )
    about += wp.cw_mul(wp.vec3(given.damping_tx, given.damping_ty, given.damping_tz), m.rates)
    along += wp.cw_mul(wp.vec3(given.damping_x, given.damping_y, given.damping_z), m.speed)
    return bushing_wrench(about, along, second, m)
