"""What reflexes by states of gait sense: fibres, joints, points and turns of bodies, and the centre of mass.

Sensors are those of SCONE (scone-core, `scone/model/Sensors.h`; Geijtenbeek 2019, JOSS 4(38), 1421).
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading
from warpmuscle.kernels.control.reflex import forward_lean
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.gait_state_structs import (
    ACTIVATION,
    ANGLE,
    ANGLE_RATE,
    BALANCE_SPEED,
    FIBRE_LENGTH,
    FIBRE_VELOCITY,
    LEAN_RATE,
    NOTHING,
    SPEED,
    SPINDLE,
    TURN,
    TURN_ANGLE,
    TURN_RATE,
    GaitSensor,
)
from warpmuscle.kernels.objective.accelerations import centre_of_mass
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@func
def rotation_vector(q: wp.quat) -> wp.vec3:
    """The rotation of a unit quaternion as axis times angle, rad, the angle from 0 to pi."""
    v = wp.vec3(q[0], q[1], q[2])
    w = q[3]
    if w < 0.0:
        v = -v
        w = -w
    length = wp.length(v)
    if length < 1.0e-6:
        return 2.0 * v
    return v * (2.0 * wp.atan2(length, w) / length)


@func
def turn_angles(q: wp.quat) -> wp.vec3:
    """Angles about x, y and z of a body that turns first about y, then about its x, then about its z, rad.

    Those about x are from -pi/2 to pi/2: heading, lean and list, which do not depend on the heading.
    """
    x = q[0]
    y = q[1]
    z = q[2]
    w = q[3]
    about_x = wp.asin(wp.clamp(2.0 * (w * x - y * z), -1.0, 1.0))
    about_y = wp.atan2(2.0 * (w * y + x * z), w * w - x * x - y * y + z * z)
    about_z = wp.atan2(2.0 * (w * z + x * y), w * w - x * x + y * y - z * z)
    return wp.vec3(about_x, about_y, about_z)


@func
def turned_about(q: wp.quat, axis: wp.vec3) -> float:
    """How far a body is turned about one of its axes: its rotation vector has the same parts in it and in the world."""
    return wp.dot(axis, rotation_vector(q))


@func
def level_direction(q: wp.quat, direction: wp.vec3) -> wp.vec3:
    """A direction of the root's in the world, without its vertical part, of unit length; none where it is upright."""
    along = wp.quat_rotate(q, direction)
    return wp.normalize(wp.vec3(along[0], 0.0, along[2]))


@func
def centre_velocity(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Velocity of a body's centre of mass, world, m/s."""
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    return work.velocity[body] + wp.cross(work.angular_velocity[body], c)


@func
def along_point(instance: int, sensor: GaitSensor, moving: bool, model: ModelRef, work: ScratchRef) -> float:
    """Where a point of a body is along a direction of the world, m, or its speed, m/s."""
    body = sensor.source
    r = work.rotation[body] * sensor.place
    if moving:
        velocity = centre_velocity(instance, body, model, work) + wp.cross(work.angular_velocity[body], r)
        return wp.dot(sensor.along, velocity)
    return wp.dot(sensor.along, centre_of_mass(instance, body, model, work) + r)


@func
def along_balance(instance: int, sensor: GaitSensor, moving: bool, model: ModelRef, work: ScratchRef) -> float:
    """Where the centre of mass is from its pivot along a level direction, m, or how fast it goes from there, m/s."""
    along = level_direction(work.orientation[0], sensor.along)
    left = wp.where(sensor.source != NOTHING, sensor.source, model.feet.left)
    right = wp.where(sensor.source != NOTHING, sensor.source, model.feet.right)
    if moving:
        both = centre_velocity(instance, left, model, work) + centre_velocity(instance, right, model, work)
        return wp.dot(along, work.center[1] - 0.5 * both)
    both = centre_of_mass(instance, left, model, work) + centre_of_mass(instance, right, model, work)
    return wp.dot(along, work.center[0] - 0.5 * both)


@func
def of_joint(instance: int, sensor: GaitSensor, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """A joint's coordinate or its rate, or how far a body leans forwards, or the rate of that."""
    kind = sensor.kind
    source = sensor.source
    plan = model.skeleton.plan[source]
    if kind == ANGLE:
        return state.coordinates[instance, plan.coordinate_start]
    if kind == ANGLE_RATE:
        return state.speeds[instance, plan.speed_start]
    up = work.rotation[source] * wp.vec3(0.0, 1.0, 0.0)
    lean = forward_lean(up, work.angular_velocity[source], heading(work.orientation[0]))
    return wp.where(kind == LEAN_RATE, lean[1], lean[0])


@func
def spindle_rate(length: float, velocity: float) -> float:
    """What a spindle tells of a fibre's length, l_opt, and its velocity, l_opt/s, as SCONE has it after Prochazka 1999.

    Source: scone-core, `scone/model/Muscle.cpp`, GetNormalizedSpindleRate.
    """
    return wp.max(length + 0.325 * wp.sign(velocity) * wp.sqrt(wp.abs(velocity)), 0.0)


@func
def of_muscle(instance: int, sensor: GaitSensor, state: StateRef) -> float:
    """What a spindle tells of a muscle's fibres, or how active the muscle is."""
    if sensor.kind == ACTIVATION:
        return state.muscles.activation[instance, sensor.source]
    fibre = state.muscles.sensed[instance, sensor.source]
    return spindle_rate(fibre[0], fibre[1])


@func
def sensed(instance: int, sensor: GaitSensor, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """What a sensor tells: of muscles as they were in the step before, else as it is."""
    kind = sensor.kind
    source = sensor.source
    if kind < ANGLE:
        fibre = state.muscles.sensed[instance, source]
        return wp.where(kind == FIBRE_LENGTH, fibre[0], wp.where(kind == FIBRE_VELOCITY, fibre[1], fibre[2]))
    if kind >= SPINDLE:
        return of_muscle(instance, sensor, state)
    if kind <= LEAN_RATE:
        return of_joint(instance, sensor, model, state, work)
    if kind <= SPEED:
        return along_point(instance, sensor, kind == SPEED, model, work)
    if kind == TURN:
        return turned_about(work.orientation[source], sensor.along)
    if kind == TURN_ANGLE:
        return wp.dot(sensor.along, turn_angles(work.orientation[source]))
    if kind == TURN_RATE:
        return wp.dot(work.rotation[source] * sensor.along, work.angular_velocity[source])
    return along_balance(instance, sensor, kind == BALANCE_SPEED, model, work)
