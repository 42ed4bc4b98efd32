"""Passive devices and drag: the kinds of forces that scenes know by name, see `forces.py`."""

import warp as wp

from warpmuscle.kernels.force.bushing import Bushing, bushing
from warpmuscle.kernels.force.cycle_torque import CycleTorque, cycle_torque
from warpmuscle.kernels.force.expressions import (
    BodyExpression,
    BushingExpression,
    CoordinateExpression,
    PointExpression,
    TorqueExpression,
    body_expression,
    bushing_expression,
    coordinate_expression,
    point_expression,
    torque_expression,
)
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.force.joint_motor import JointMotor, joint_motor
from warpmuscle.kernels.force.loads import JointLoad, Load, PointLoad, joint_load, load, point_load
from warpmuscle.kernels.force.point_spring import PointSpring, point_spring
from warpmuscle.kernels.force.push import Push, push
from warpmuscle.kernels.force.weight_support import WeightSupport, weight_support
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class BilinearSpring:
    """A torsion spring with another stiffness on either side of its rest angle, 0 where it is slack."""

    rest_angle: float  # rad
    stiffness_above: float  # N m/rad
    stiffness_below: float  # N m/rad
    damping: float  # N m s/rad, where it is not slack


@func
def bilinear_spring_effort(angle: float, speed: float, spring: BilinearSpring) -> float:
    """Effort of a spring that is engaged over part of the range, N m: -k (q - q0) - d v, k by the side of q0.

    As of a passive ankle exoskeleton whose spring is slack on one side (Collins, Wiggin, Sawicki 2015).
    """
    stretch = angle - spring.rest_angle
    stiffness = wp.where(stretch > 0.0, spring.stiffness_above, spring.stiffness_below)
    if stiffness == 0.0:
        return 0.0
    return -stiffness * stretch - spring.damping * speed


@func
def bilinear_spring(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, spring: BilinearSpring
) -> wp.vec3:
    """Effort along the first coordinate of a hinge or universal joint."""
    plan = model.skeleton.plan[body]
    angle = state.coordinates[instance, plan.coordinate_start]
    return wp.vec3(bilinear_spring_effort(angle, state.speeds[instance, plan.speed_start], spring), 0.0, 0.0)


@wp.struct
class CoordinateLimit:
    """Springs and dampers that set in beyond the ends of a range, on a coordinate that is an angle or a length."""

    low: float  # rad or m
    high: float
    stiffness_below: float  # N m/rad or N/m
    stiffness_above: float
    damping: float  # N m s/rad or N s/m, of either, as far as it has set in
    transition: float  # rad or m beyond an end, over which they set in


@func
def smooth_step(x: float) -> float:
    """A step from 0 at x = 0 to 1 at x = 1 whose first and second derivatives do not jump: 10 x^3 - 15 x^4 + 6 x^5."""
    t = wp.clamp(x, 0.0, 1.0)
    return t * t * t * (10.0 + t * (6.0 * t - 15.0))


@func
def coordinate_limit_effort(q: float, v: float, limit: CoordinateLimit) -> float:
    """Effort of springs and dampers beyond the ends of a range, N m or N: OpenSim's CoordinateLimitForce."""
    above = smooth_step((q - limit.high) / limit.transition)
    below = smooth_step((limit.low - q) / limit.transition)
    pushed = below * limit.stiffness_below * (limit.low - q) - above * limit.stiffness_above * (q - limit.high)
    return pushed - (above + below) * limit.damping * v


@func
def coordinate_limit(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, limit: CoordinateLimit
) -> wp.vec3:
    """Effort along the first coordinate of a joint."""
    plan = model.skeleton.plan[body]
    q, v = state.coordinates[instance, plan.coordinate_start], state.speeds[instance, plan.speed_start]
    return wp.vec3(coordinate_limit_effort(q, v, limit), 0.0, 0.0)


@wp.struct
class RangeLimit:
    """A spring beyond the ends of a range whose damper is the stronger, the more it is bent."""

    low: float  # rad or m
    high: float
    stiffness: float  # N m/rad or N/m
    damping: float  # s/rad or s/m, of the spring's own effort


@func
def range_limit_effort(q: float, v: float, limit: RangeLimit) -> float:
    """Effort -k e (1 + c e'), e the way beyond an end and e' its rate; never back out (Hyfydy's joint_force_pnld).

    Its manual has it after Hunt and Crossley 1975, as contact is.
    """
    excess = q - wp.clamp(q, limit.low, limit.high)
    rate = wp.where(excess < 0.0, -v, v)
    return -limit.stiffness * excess * wp.max(1.0 + limit.damping * rate, 0.0)


@func
def range_limit(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, limit: RangeLimit
) -> wp.vec3:
    """Effort along the first coordinate of a joint."""
    plan = model.skeleton.plan[body]
    q, v = state.coordinates[instance, plan.coordinate_start], state.speeds[instance, plan.speed_start]
    return wp.vec3(range_limit_effort(q, v, limit), 0.0, 0.0)


@wp.struct
class CoordinateSpring:
    """A spring and a damper along a coordinate."""

    rest: float  # rad or m
    stiffness: float  # N m/rad or N/m
    damping: float  # N m s/rad or N s/m


@func
def coordinate_spring(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, spring: CoordinateSpring
) -> wp.vec3:
    """Effort -k (q - q0) - d v along the first coordinate of a joint: OpenSim's SpringGeneralizedForce."""
    plan = model.skeleton.plan[body]
    q, v = state.coordinates[instance, plan.coordinate_start], state.speeds[instance, plan.speed_start]
    return wp.vec3(-spring.stiffness * (q - spring.rest) - spring.damping * v, 0.0, 0.0)


@wp.struct
class AirDrag:
    """What air does to a body that moves through it."""

    drag_area: float  # m^2, drag coefficient times frontal area
    density: float  # kg/m^3, some 1.2


@func
def drag_force(velocity: wp.vec3, drag: AirDrag) -> wp.vec3:
    """Quadratic drag, N: -1/2 rho (c_d A) |v| v."""
    return velocity * (-0.5 * drag.density * drag.drag_area * wp.length(velocity))


@func
def air_drag(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, drag: AirDrag) -> Wrench:
    """Drag at the centre of mass of a body in still air."""
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    w = Wrench()
    w.force = drag_force(work.velocity[body] + wp.cross(work.angular_velocity[body], c), drag)
    return w


def checked(name: str, kind: ForceKind) -> ForceKind:
    """A kind of forces.

    Raises:
        TypeError: it forgets what scenes are checked by; it names the force and what that is.
    """
    what = f"force {name!r} in FORCES of devices.py"
    if sum(function is not None for function in (kind.effort, kind.wrench, kind.pair)) != 1:
        raise TypeError(f"{what} needs one Warp function: `effort` of a joint, `wrench` of a body, or `pair` of two")
    fields = getattr(kind.parameters, "vars", {})
    if kind.parameters is not None and not fields:
        raise TypeError(f"{what}: its `parameters` are not a @wp.struct of floats")
    for field in ("positive", "programs"):
        named = getattr(kind, field)
        wrong = [one for one in named if one not in fields] if isinstance(named, tuple) else [named]
        if wrong:
            raise TypeError(f"{what}: `{field}` must be a tuple of names of parameters, {wrong[0]!r} is not")
    python = getattr(kind.effort, "func", kind.effort)
    if python is not None and "coordinate_start" in python.__code__.co_names and not kind.of_angle:
        raise TypeError(f"{what} reads a coordinate of its joint: say `of_angle=True`, since a ball joint has no angle")
    return kind


FORCES = {
    "bilinear_spring": ForceKind(effort=bilinear_spring, parameters=BilinearSpring, of_angle=True, device=True),
    "cycle_torque": ForceKind(effort=cycle_torque, parameters=CycleTorque, device=True, of_leg=True),
    "point_spring": ForceKind(pair=point_spring, parameters=PointSpring, device=True),
    "joint_motor": ForceKind(pair=joint_motor, parameters=JointMotor, device=True),
    "weight_support": ForceKind(wrench=weight_support, parameters=WeightSupport, device=True),
    "coordinate_limit": ForceKind(
        effort=coordinate_limit, parameters=CoordinateLimit, of_angle=True, positive=("transition",)
    ),
    "range_limit": ForceKind(effort=range_limit, parameters=RangeLimit, of_angle=True),
    "coordinate_spring": ForceKind(effort=coordinate_spring, parameters=CoordinateSpring, of_angle=True),
    "bushing": ForceKind(pair=bushing, parameters=Bushing),
    "coordinate_expression": ForceKind(
        effort=coordinate_expression,
        parameters=CoordinateExpression,
        of_angle=True,
        programs=("effort",),
        variables=("q", "qdot", "t"),
    ),
    "point_expression": ForceKind(
        pair=point_expression, parameters=PointExpression, programs=("tension",), variables=("d", "ddot", "t")
    ),
    "body_expression": ForceKind(
        wrench=body_expression,
        parameters=BodyExpression,
        variables=("t",),
        programs=tuple(f"{part}_{axis}" for part in ("force", "moment", "point") for axis in "xyz"),
    ),
    "torque_expression": ForceKind(
        pair=torque_expression, parameters=TorqueExpression, programs=("torque",), variables=("t",)
    ),
    "bushing_expression": ForceKind(
        pair=bushing_expression,
        parameters=BushingExpression,
        programs=("mx", "my", "mz", "fx", "fy", "fz"),
        variables=("theta_x", "theta_y", "theta_z", "delta_x", "delta_y", "delta_z"),
    ),
    "air_drag": ForceKind(wrench=air_drag, parameters=AirDrag),
    "push": ForceKind(wrench=push, parameters=Push, device=True),
    "load": ForceKind(wrench=load, parameters=Load),
    "point_load": ForceKind(wrench=point_load, parameters=PointLoad),
    "joint_load": ForceKind(effort=joint_load, parameters=JointLoad),
}
FORCES = {name: checked(name, force)._replace(shipped=not force.programs) for name, force in FORCES.items()}
