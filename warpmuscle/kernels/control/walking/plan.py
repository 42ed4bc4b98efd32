"""What the walking controller wants next: which leg stands, and where the foot of the other one is to come down."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading_angle, within_pi
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.control.joint_values import joint_coordinate
from warpmuscle.kernels.control.walking.body import ground_height, leg_of, measure, outwards
from warpmuscle.kernels.control.walking.footholds import best_shift
from warpmuscle.kernels.control.walking.inverted_pendulum import (
    LEAST_HASTE,
    falling_rate,
    falls_to,
    haste,
    resting_distance,
    steady_margin,
    steady_retreat,
    towards,
)
from warpmuscle.kernels.control.walking.parameters import (
    BEGUN,
    FOOTHOLD,
    HALF_WIDTH,
    HASTE,
    HEADING,
    HEEL,
    KNEE,
    LEFT_STANCE,
    LEG,
    LIFTED,
    LOAD,
    PHASE,
    RIGHT_STANCE,
    SINCE,
    SOLE,
    SPEED,
    STANCE,
    STANDS,
    TOE,
    TUNED,
    WAY,
    Walking,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

LANDED = wp.constant(0.05)  # body weights on a foot that has come down
LANDS = wp.constant(0.88)  # phase at which a foot is expected to come down
FROM_PHASE = wp.constant(0.5)  # from which it may
LONGEST = wp.constant(1.4)  # phase at which the other leg swings whatever comes
REACH = wp.constant(0.55)  # L, farthest foothold from below the centre of mass
CHANGES = wp.constant(0.04)  # s, in which a foothold comes to where it is planned anew
SMOOTHING = wp.constant(0.015)  # s, of loads
TO_MIDDLE = wp.constant(1.0)  # by how much further than the extrapolated centre of mass the centre of pressure goes
SHIFTED, STARTS = wp.constant(0.9), wp.constant(0.65)  # of the way to the left foot: where it is to go, and is enough
PAST = wp.constant(0.9)  # of the way to the right foot: from where on the body falls over that
SHIFT_TIME = wp.constant(2.0)  # s, after which it has to be
MOST_TUNED = wp.constant(1.0)  # m/s
STILL = wp.constant(0.02)  # m/s, wanted speed below which the body stands


@func
def step_duration(parameters: Walking, speed: float, leg: float, gravity: float) -> float:
    """Time of a step, s."""
    relative = wp.abs(speed) / wp.sqrt(gravity * leg)
    return parameters.step_time * wp.sqrt(leg / gravity) / (1.0 + parameters.quickening * relative)


@func
def facing(memory: wp.array[float]) -> wp.quat:
    """The frame of the heading that is followed: z forwards, x to the left."""
    return hinge_rotation(wp.vec3(0.0, 1.0, 0.0), memory[HEADING])


@func
def swing_side(memory: wp.array[float]) -> int:
    """The leg that swings; while the body stands, the right one."""
    return wp.where(memory[STANCE] == RIGHT_STANCE, 0, 1)


@func
def middle_ahead(parameters: Walking, memory: wp.array[float]) -> float:
    """How far ahead of the ankle the middle of that part of a sole is that is used, m."""
    return 0.5 * parameters.sole_use * (memory[HEEL] + memory[TOE])


@func
def middle_of_foot(foot: int, parameters: Walking, memory: wp.array[float], work: ScratchRef) -> wp.vec3:
    """That middle, world, m."""
    return work.position[foot] + work.rotation[foot] * wp.vec3(0.0, -memory[SOLE], middle_ahead(parameters, memory))


@wp.struct
class Aim:
    """Where an ankle is to come down on level ground."""

    place: wp.vec3  # m, world
    moves: float  # m/s, by which it would be further ahead if it came down later
    remaining: float  # s, till it comes down


@func
def aim(instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> Aim:
    """Where the ankle is to come down by the pendulum; its height is that of level ground."""
    side = swing_side(memory)
    frame = facing(memory)
    gravity = at(model.gravity, instance, 0)
    pivot = middle_of_foot(leg_of(1 - side, model).foot, parameters, memory, work)
    place = wp.quat_rotate_inv(frame, work.center[0] - pivot)
    velocity = wp.quat_rotate_inv(frame, work.center[1])
    height = wp.max(place[1], 0.5 * memory[LEG])
    rate = falling_rate(height, gravity)
    duration = step_duration(parameters, memory[SPEED], memory[LEG], gravity)
    remaining = wp.max(LANDS - memory[PHASE], 0.0) * duration
    across = falls_to(place[0], velocity[0], rate, remaining)
    along = falls_to(place[2], velocity[2], rate, remaining)
    most = REACH * memory[LEG]
    out = outwards(side)
    x = resting_distance(across[1], height, gravity)
    x += out * steady_margin(parameters.step_width * memory[LEG], rate, duration)
    z = resting_distance(along[1], height, gravity)
    z -= parameters.retreat * steady_retreat(memory[SPEED] + memory[TUNED], rate, duration)
    x = across[0] + wp.clamp(x, -most, most)
    z = along[0] + wp.clamp(z, -most, most)
    x = out * wp.max(out * x, parameters.least_width * memory[LEG])  # not across the other foot
    ahead = middle_ahead(parameters, memory)
    found = Aim()
    found.place = pivot + wp.quat_rotate(frame, wp.vec3(x, memory[SOLE], z - ahead))
    found.moves = along[1] + rate * along[0]
    found.remaining = remaining
    return found


@func
def place_foot(instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]):
    """The foothold of the foot that swings, into the memory."""
    found = aim(instance, parameters, model, work, memory)
    wanted = found.place
    memory[HASTE] = 1.0
    if parameters.sight > 0.0:
        forwards = wp.quat_rotate(facing(memory), wp.vec3(0.0, 0.0, 1.0))
        stands = work.position[leg_of(1 - swing_side(memory), model).foot]
        level = ground_height(instance, stands[0], stands[2], model)
        shift = best_shift(instance, wanted, forwards, level, parameters.climb, model, memory)
        memory[HASTE] = haste(shift[1], found.moves, found.remaining)
        wanted += forwards * shift[0]
        wanted[1] = ground_height(instance, wanted[0], wanted[2], model) + memory[SOLE]
    straight = memory[PHASE] == 0.0 or parameters.sight <= 0.0
    share = wp.where(straight, 1.0, model.time_step / (CHANGES + model.time_step))
    for axis in range(3):
        memory[FOOTHOLD + axis] = memory[FOOTHOLD + axis] + share * (wanted[axis] - memory[FOOTHOLD + axis])


@func
def swing(instance: int, side: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]):
    """From now on this leg swings."""
    memory[STANCE] = wp.where(side == 0, RIGHT_STANCE, LEFT_STANCE)
    memory[PHASE] = 0.0
    memory[KNEE] = joint_coordinate(instance, leg_of(1 - side, model).shank, 0, model, state)
    place = work.position[leg_of(side, model).foot]
    for axis in range(3):
        memory[LIFTED + axis] = place[axis]


@func
def follow_commands(parameters: Walking, time_step: float, memory: wp.array[float]):
    """Come nearer to what is commanded."""
    memory[SPEED] = towards(memory[SPEED], parameters.speed, parameters.acceleration * time_step)
    lacks = within_pi(parameters.heading - memory[HEADING])
    memory[HEADING] = towards(memory[HEADING], memory[HEADING] + lacks, parameters.turn_rate * time_step)


@func
def begin(instance: int, model: ModelRef, work: ScratchRef, memory: wp.array[float]):
    """Find out what is to be known of the body, once."""
    measure(instance, model, memory)
    memory[HEADING] = heading_angle(work.orientation[0])
    memory[STANCE] = STANDS
    memory[BEGUN] = 1.0


@func
def feel_loads(instance: int, model: ModelRef, state: StateRef, memory: wp.array[float]):
    """Loads of both feet, smoothed, since a share of torques that follows every bounce feeds it."""
    share = model.time_step / (SMOOTHING + model.time_step)
    for side in range(2):
        now = wp.max(state.foot_force[instance, side][1], 0.0)
        if memory[BEGUN] == 0.0:
            memory[LOAD + side] = 0.5 * body_weight(instance, model)
        else:
            memory[LOAD + side] = memory[LOAD + side] + share * (now - memory[LOAD + side])


@func
def tune_speed(parameters: Walking, time_step: float, work: ScratchRef, memory: wp.array[float]):
    """Add up the way of a step, and at its end plan more speed if it was slower than it was to be."""
    velocity = wp.quat_rotate_inv(facing(memory), work.center[1])
    memory[WAY] = memory[WAY] + time_step * velocity[2]
    memory[SINCE] = memory[SINCE] + time_step
    if memory[PHASE] == 0.0:
        lacks = memory[SPEED] - memory[WAY] / memory[SINCE]
        memory[TUNED] = wp.clamp(memory[TUNED] + parameters.tuning * lacks, -MOST_TUNED, MOST_TUNED)
        memory[WAY] = 0.0
        memory[SINCE] = 0.0


@func
def extrapolated(
    instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]
) -> wp.vec2:
    """How far the extrapolated centre of mass is from the middle between both feet, m: left, forwards (Hof 2008)."""
    left = middle_of_foot(model.feet.left, parameters, memory, work)
    right = middle_of_foot(model.feet.right, parameters, memory, work)
    place = wp.quat_rotate_inv(facing(memory), work.center[0] - 0.5 * (left + right))
    velocity = wp.quat_rotate_inv(facing(memory), work.center[1])
    rate = falling_rate(wp.max(place[1], 0.5 * memory[LEG]), at(model.gravity, instance, 0))
    return wp.vec2(place[0] + velocity[0] / rate, place[2] + velocity[2] / rate)


@func
def may_stop(instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> bool:
    """Whether a body that shall not go on may stand: its feet, side by side, bear its extrapolated centre of mass."""
    apart = wp.quat_rotate_inv(facing(memory), work.position[model.feet.left] - work.position[model.feet.right])
    ahead = extrapolated(instance, parameters, model, work, memory)[1]
    borne = wp.abs(ahead) < 0.5 * parameters.sole_use * (memory[TOE] - memory[HEEL])
    slow = wp.abs(memory[SPEED]) < STILL and parameters.speed < STILL
    return slow and borne and wp.abs(apart[2]) < 0.12 * memory[LEG]


@func
def feet_apart(model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> float:
    """Distance of the feet across the heading, m."""
    between = wp.quat_rotate_inv(facing(memory), work.position[model.feet.left] - work.position[model.feet.right])
    return wp.max(float(between[0]), 0.05 * memory[LEG])


@func
def standing_share(
    instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]
) -> float:
    """Share of the weight that the left foot of a body that stands is to bear, 0 to 1.

    The centre of pressure is to be beyond the extrapolated centre of mass as seen from where that is to go: the
    middle, or over the left foot, before the right one is lifted.
    """
    now = extrapolated(instance, parameters, model, work, memory)[0]
    apart = feet_apart(model, work, memory)
    wanted = wp.where(memory[PHASE] > 0.0, SHIFTED * 0.5 * apart, 0.0)
    return wp.clamp(0.5 + (now + TO_MIDDLE * (now - wanted)) / apart, 0.0, 1.0)


@func
def may_start(instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> bool:
    """Whether the weight of a body that stands and is to walk has come over its left foot, or that takes too long."""
    over = extrapolated(instance, parameters, model, work, memory)[0] > STARTS * 0.5 * feet_apart(model, work, memory)
    return over or memory[PHASE] > SHIFT_TIME


@func
def falls_to_the_right(
    instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]
) -> bool:
    """Whether the extrapolated centre of mass of a body that stands is past its right foot: it cannot come back."""
    return extrapolated(instance, parameters, model, work, memory)[0] < -PAST * 0.5 * feet_apart(model, work, memory)


@func
def catching_leg(instance: int, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> int:
    """The leg with which a body that stands has to step out, since no sole bears where it falls to; -1: neither."""
    falls = extrapolated(instance, parameters, model, work, memory)
    beyond = wp.abs(falls[1]) > 0.5 * (memory[TOE] - memory[HEEL])
    aside = wp.abs(falls[0]) > 0.5 * feet_apart(model, work, memory) + memory[HALF_WIDTH]
    if beyond or aside:
        return wp.where(falls[0] > 0.0, 1, 0)
    return -1


@func
def starts(
    instance: int, parameters: Walking, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> bool:
    """Whether a body that has stood until now steps from now on.

    It does if it is to walk, its right leg first unless it falls to that side, and if it would fall otherwise.
    """
    memory[SPEED] = 0.0
    memory[TUNED] = 0.0
    memory[WAY] = 0.0
    memory[SINCE] = 0.0
    catches = catching_leg(instance, parameters, model, work, memory)
    if catches >= 0:
        swing(instance, catches, model, state, work, memory)
        return True
    if wp.abs(parameters.speed) <= STILL:
        memory[PHASE] = 0.0
        return False
    memory[PHASE] = memory[PHASE] + model.time_step
    if may_start(instance, parameters, model, work, memory):
        swing(instance, 1, model, state, work, memory)
        return True
    if falls_to_the_right(instance, parameters, model, work, memory):
        swing(instance, 0, model, state, work, memory)
        return True
    return False


@func
def renew_plan(
    instance: int, parameters: Walking, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
):
    """Bring phase, stance and foothold to this moment."""
    feel_loads(instance, model, state, memory)
    if memory[BEGUN] == 0.0:
        begin(instance, model, work, memory)
    follow_commands(parameters, model.time_step, memory)
    if memory[STANCE] == STANDS:  # noqa: SIM102 - Warp evaluates both sides of `and`
        if not starts(instance, parameters, model, state, work, memory):
            return
    gravity = at(model.gravity, instance, 0)
    duration = step_duration(parameters, memory[SPEED], memory[LEG], gravity)
    memory[PHASE] = memory[PHASE] + wp.max(memory[HASTE], LEAST_HASTE) * model.time_step / duration
    side = swing_side(memory)
    force = state.foot_force[instance, side]
    bears = force[1] > LANDED * body_weight(instance, model) and force[1] > wp.length(wp.vec2(force[0], force[2]))
    landed = memory[PHASE] > FROM_PHASE and bears  # a foot that stubs does not
    if landed or memory[PHASE] > LONGEST:
        swing(instance, 1 - side, model, state, work, memory)
    tune_speed(parameters, model.time_step, work, memory)
    if memory[PHASE] == 0.0 and may_stop(instance, parameters, model, work, memory):
        memory[STANCE] = STANDS
        return
    place_foot(instance, parameters, model, work, memory)
