"""How an object moves: from its start, with the body that holds it, and by forces, over a step."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import (
    cross_rows,
    full,
    shifted_angular,
    symmetric,
    symmetric_inverse,
    symmetric_product,
    symmetric_rotated,
    symmetric_times,
    turn,
)
from warpmuscle.kernels.body.inertia import gyroscopic_moment, inertia_about_joint
from warpmuscle.kernels.contact.contact import ContactSum
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import (
    BEGUN,
    HELD,
    MOMENTUM,
    ORIENTATION,
    PLACE,
    VELOCITY,
    ObjectExtension,
    ObjectMotion,
    ObjectRow,
)
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@func
def is_held(instance: int, number: int, row: ObjectRow, model: ModelRef, state: StateRef, own: ObjectExtension) -> bool:
    """Whether a body holds an object in this step."""
    return own.holder[number] >= 0 and float(state.step[instance]) * model.time_step < row.until


@func
def spin_of(momentum: wp.vec3, orientation: wp.quat, row: ObjectRow) -> wp.vec3:
    """Angular velocity, rad/s, of an angular momentum, kg m^2/s."""
    own = wp.quat_rotate_inv(orientation, momentum)
    return wp.quat_rotate(orientation, wp.cw_div(own, row.inertia))


@func
def momentum_of(spin: wp.vec3, orientation: wp.quat, row: ObjectRow) -> wp.vec3:
    """Angular momentum, kg m^2/s, of an angular velocity, rad/s."""
    own = wp.quat_rotate_inv(orientation, spin)
    return wp.quat_rotate(orientation, wp.cw_mul(own, row.inertia))


@func
def vector_in(memory: wp.array[float], first: int) -> wp.vec3:
    """Three numbers of a memory."""
    return wp.vec3(memory[first], memory[first + 1], memory[first + 2])


@func
def keep_vector(memory: wp.array[float], first: int, v: wp.vec3):
    """Put three numbers into a memory."""
    for i in range(3):
        memory[first + i] = v[i]


@func
def started(row: ObjectRow) -> ObjectMotion:
    """Where an object starts, and how it moves then."""
    m = ObjectMotion()
    m.place = row.place
    m.orientation = row.orientation
    m.velocity = row.velocity
    m.spin = row.spin
    m.momentum = momentum_of(m.spin, m.orientation, row)
    return m


@func
def carried(holder: int, row: ObjectRow, time_step: float, work: ScratchRef) -> ObjectMotion:
    """The same of one that a body holds: in the middle of the step before, as all that implicit forces start from."""
    arm = work.rotation[holder] * row.place
    spin = work.angular_velocity[holder] - work.lag_angular[holder]
    m = ObjectMotion()
    m.place = work.position[holder] + arm
    m.orientation = work.orientation[holder] * row.orientation
    then = arm - wp.cross(spin, arm) * (0.5 * time_step)  # half a step before
    m.velocity = work.velocity[holder] - work.lag_velocity[holder] + wp.cross(spin, then)
    m.spin = spin
    m.momentum = momentum_of(m.spin, m.orientation, row)
    return m


@func
def motion_now(
    instance: int, number: int, row: ObjectRow, model: ModelRef, state: StateRef, work: ScratchRef, own: ObjectExtension
) -> ObjectMotion:
    """Where an object is, and how it moved in the middle of the step before."""
    m = started(row)
    if own.fixed[number] == 1:
        m.velocity = wp.vec3(0.0)
        m.spin = wp.vec3(0.0)
        return m
    memory = own.memory[instance, number]
    if memory[BEGUN] == wp.static(HELD) or is_held(instance, number, row, model, state, own):
        return carried(own.holder[number], row, model.time_step, work)
    if memory[BEGUN] != 0.0:
        m.place = vector_in(memory, PLACE)
        m.velocity = vector_in(memory, VELOCITY)
        m.orientation = wp.quat(
            memory[ORIENTATION], memory[ORIENTATION + 1], memory[ORIENTATION + 2], memory[ORIENTATION + 3]
        )
        m.momentum = vector_in(memory, MOMENTUM)
        m.spin = spin_of(m.momentum, m.orientation, row)
    return m


@func
def keep(memory: wp.array[float], motion: ObjectMotion, what: float):
    """Let a memory have a motion, of an object that is FREE or HELD."""
    memory[BEGUN] = what
    keep_vector(memory, PLACE, motion.place)
    for i in range(4):
        memory[ORIENTATION + i] = motion.orientation[i]
    keep_vector(memory, VELOCITY, motion.velocity)
    keep_vector(memory, MOMENTUM, motion.momentum)


@func
def load_holder(
    instance: int,
    holder: int,
    row: ObjectRow,
    motion: ObjectMotion,
    contacts: ContactSum,
    model: ModelRef,
    work: ScratchRef,
):
    """Let the body that holds an object be as heavy as both, and feel what the ground does to the object."""
    arm = motion.place - work.position[holder]
    angular = work.angular_velocity[holder]
    inertia = inertia_about_joint(wp.quat_to_matrix(motion.orientation), row.inertia, row.mass, arm)
    weight = wp.vec3(0.0, -row.mass * at(model.gravity, instance, 0), 0.0)
    shifted = contacts.b + cross_rows(arm, contacts.c)
    turning = contacts.a + shifted_angular(contacts.b, shifted, arm)
    force = weight + contacts.force
    work.block_a[holder] = work.block_a[holder] + inertia + turning
    work.block_b[holder] = work.block_b[holder] + wp.skew(arm * row.mass) + shifted
    work.block_c[holder] = work.block_c[holder] + symmetric(row.mass, 0.0, 0.0, row.mass, 0.0, row.mass) + contacts.c
    work.bias_moment[holder] = (
        work.bias_moment[holder] + gyroscopic_moment(angular, inertia) - wp.cross(arm, force) - contacts.moment
    )
    work.bias_force[holder] = work.bias_force[holder] + wp.cross(angular, wp.cross(angular, arm)) * row.mass - force


@wp.struct
class Accelerations:
    """Of an object, world."""

    turning: wp.vec3  # rad/s^2
    moving: wp.vec3  # m/s^2


@func
def accelerations(
    row: ObjectRow, orientation: wp.quat, force: wp.vec3, moment: wp.vec3, contacts: ContactSum
) -> Accelerations:
    """What forces, contacts implicit over the step among them, do to an object, but for its own turning.

    Args:
        force: N, at its middle, of all but the ground. moment: N m, about it.
    """
    m = row.mass
    c = symmetric_inverse(symmetric(m, 0.0, 0.0, m, 0.0, m) + contacts.c)
    bt = wp.transpose(contacts.b)
    bc = contacts.b * full(c)
    a = symmetric_rotated(wp.quat_to_matrix(orientation), row.inertia) + contacts.a
    all_force = force + contacts.force
    found = Accelerations()
    left = moment + contacts.moment - bc * all_force
    found.turning = symmetric_times(symmetric_inverse(a - symmetric_product(bc, bt)), left)
    found.moving = symmetric_times(c, all_force - bt * found.turning)
    return found


@func
def moved(motion: ObjectMotion, found: Accelerations, row: ObjectRow, kick: float, h: float) -> ObjectMotion:
    """The motion after a step, by leapfrog, but for its `spin`; turning alone does not change its angular momentum.

    Args:
        kick: time that accelerations act, s: a step, or half of it in the first one.
    """
    m = ObjectMotion()
    q = motion.orientation
    m.velocity = motion.velocity + found.moving * kick
    m.place = motion.place + m.velocity * h
    m.momentum = motion.momentum + momentum_of(found.turning * kick, q, row)
    half_way = turn(q, wp.quat_rotate_inv(q, spin_of(m.momentum, q, row)), 0.5 * h)
    m.orientation = turn(q, wp.quat_rotate_inv(q, spin_of(m.momentum, half_way, row)), h)
    return m
