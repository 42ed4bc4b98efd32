"""Steps of the controller: which foot stands, where the other one is to come down, and the pressure that goes with it.

The centre of mass is a linear pendulum over the centre of pressure p: x'' = w^2 (x - p), w^2 = g/h. So its extrapolated
place xi = x + x'/w runs away from p by xi' = w (xi - p). A foot comes down so far beside and behind xi that the next
step is like this one (Hof 2008); what xi is off within a step, the centre of pressure takes back as far as the sole
reaches. Steps go along the z axis of the world, on level ground.
"""

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.body.speed_axes import unit
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.control.walking.body import outwards
from warpmuscle.kernels.control.walking.inverted_pendulum import falling_rate, steady_margin, steady_retreat, towards
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.program.controller import BODY_FLOATS, ProgramParameters
from warpmuscle.kernels.program.structs import Frames, Layout, TaskSums
from warpmuscle.kernels.program.tasks import add_task, body_point_acceleration, contact_point, point_row
from warpmuscle.kernels.structs import ModelRef, StateRef, at

# The memory of steps of an instance, behind all else of the controller.
PHASE, SWING, SPEED = wp.constant(0), wp.constant(1), wp.constant(2)
LIFTED, FOOTHOLD = wp.constant(3), wp.constant(6)  # m, world: three numbers each
HEIGHT = wp.constant(9)  # m, of the centre of mass above the soles at the start
PRESSURE = wp.constant(10)  # m, world: where pressure was to be as a foot was about to be lifted; three numbers
STEP_FLOATS = 13
NONE_SWINGS, LEFT_SWINGS, RIGHT_SWINGS = wp.constant(0.0), wp.constant(1.0), wp.constant(2.0)

LANDED = wp.constant(0.05)  # body weights on a foot that has come down
LANDS_FROM = wp.constant(0.75)  # share of a swing from which it may
LONGEST = wp.constant(1.3)  # phase at which the other foot swings whatever comes
SHIFTED, STARTS = wp.constant(0.9), wp.constant(0.6)  # of the way to the left foot: where xi is to go, and is enough
ALONG, ACROSS = wp.constant(0.07), wp.constant(0.025)  # m, from the middle of a sole that pressure may go
REACH = wp.constant(0.6)  # m, farthest foothold from the foot that stands
LEAST_WIDTH = wp.constant(0.08)  # m, by which a foot comes down beside the other one
DEEPER = wp.constant(0.015)  # m, below the sole that stands, where a foot that swings ends
TURN = wp.constant(0.02)  # m^2, of the weight of a sole's place: that of its orientation
MOST_DOUBLE = wp.constant(0.8)  # share of a step in which both feet bear at most
LEAST_HEIGHT = wp.constant(0.1)  # m, of a pendulum


@wp.struct
class StepPlan:
    """What tasks need of the plan at this moment; world axes."""

    active: int  # 0: both feet stay where they are
    swing: int  # body of the foot that swings; -1: none does
    leaves: int  # body of the foot that is about to be lifted; -1: none
    stands: int  # body of the foot that stands; -1: both do
    share: float  # of its load that the foot that leaves may still bear
    pressure: wp.vec3  # m, where the centre of pressure is to be
    rate: float  # 1/s, of the pendulum
    height: float  # m, of the centre of mass
    place: wp.vec3  # m, of the sole that swings
    velocity: wp.vec3  # m/s
    acceleration: wp.vec3  # m/s^2


@func
def sole_middle(instance: int, foot: int, layout: Layout, model: ModelRef, frames: Frames) -> wp.vec3:
    """The middle of a foot's points of contact, m, world."""
    total = wp.vec3(0.0)
    points = wp.float32(0.0)
    for k in range(layout.point.shape[0]):
        if layout.point[k, 1] == foot:
            total += contact_point(instance, foot, layout.point[k, 0], model, frames)
            points += 1.0
    return frames.position[instance, foot] + total / wp.max(points, 1.0)


@func
def smooth_way(share: float) -> wp.vec3:
    """Way from 0 to 1 of least jerk, and its first two derivatives: 10 s^3 - 15 s^4 + 6 s^5."""
    s = wp.clamp(share, 0.0, 1.0)
    back = 1.0 - s
    way = s * s * s * (10.0 + s * (6.0 * s - 15.0))
    return wp.vec3(way, 30.0 * s * s * back * back, 60.0 * s * back * (1.0 - 2.0 * s))


@func
def hill(share: float) -> wp.vec3:
    """A hill of height 1 between 0 and 1, and its first two derivatives: 16 s^2 (1 - s)^2."""
    s = wp.clamp(share, 0.0, 1.0)
    q = s * (1.0 - s)
    slope = 1.0 - 2.0 * s
    return wp.vec3(16.0 * q * q, 32.0 * q * slope, 32.0 * (slope * slope - 2.0 * q))


@func
def double_share(p: ProgramParameters) -> float:
    """Share of a step in which both feet bear."""
    return wp.clamp(p.double_support, 0.0, MOST_DOUBLE)


@func
def keep(place: int, value: wp.vec3, steps: wp.array[float]):
    """Put three numbers into the memory."""
    for axis in range(3):
        steps[place + axis] = value[axis]


@func
def kept(place: int, steps: wp.array[float]) -> wp.vec3:
    """Three numbers of the memory."""
    return wp.vec3(steps[place], steps[place + 1], steps[place + 2])


@func
def extrapolated_center(instance: int, rate: float, frames: Frames) -> wp.vec3:
    """xi, m, world."""
    return frames.center[instance, 0] + frames.center[instance, 1] / rate


@func
def shift_weight(
    instance: int, p: ProgramParameters, left: wp.vec3, right: wp.vec3, rate: float, frames: Frames,
    steps: wp.array[float],
) -> wp.vec3:  # fmt: skip
    """Where pressure is to be while both feet stand and the weight comes over the left one."""
    middle = 0.5 * (left + right)
    xi = extrapolated_center(instance, rate, frames)
    half = 0.5 * (left[0] - right[0])
    away = wp.vec3(xi[0] - middle[0] - SHIFTED * half, 0.0, xi[2] - middle[2])
    if xi[0] - middle[0] > STARTS * half:
        steps[SWING] = RIGHT_SWINGS
        steps[PHASE] = 0.0
        keep(LIFTED, right, steps)
    pressure = xi + away * p.sway
    pressure[0] = wp.clamp(pressure[0], right[0], left[0])
    pressure[2] = wp.clamp(pressure[2], middle[2] - ALONG, middle[2] + ALONG)
    return pressure


@func
def foothold(
    p: ProgramParameters, stands: wp.vec3, out: float, rate: float, xi: wp.vec3, phase: float, speed: float
) -> wp.vec3:
    """Where the middle of the sole that swings is to come down, m, world.

    Args:
        stands: m, the middle of the sole that stands. out: sign along x of what is to the outer side of the other one.
    """
    remaining = (wp.max(1.0 - phase, 0.0) + 0.5 * double_share(p)) * p.step_time
    grown = wp.exp(rate * remaining)
    across = (xi[0] - stands[0]) * grown + out * steady_margin(p.step_width, rate, p.step_time)
    along = (xi[2] - stands[2]) * grown - steady_retreat(speed, rate, p.step_time)
    across = out * wp.clamp(out * across, LEAST_WIDTH, REACH)
    return stands + wp.vec3(across, -DEEPER, wp.clamp(along, -REACH, REACH))


@func
def pressure_of_step(
    p: ProgramParameters, stands: wp.vec3, out: float, rate: float, xi: wp.vec3, phase: float, speed: float
) -> wp.vec3:
    """Where pressure under the sole that stands takes back what xi is off from a steady step, m, world."""
    grown = wp.exp(rate * (phase - 0.5 * double_share(p)) * p.step_time)
    across = out * steady_margin(p.step_width, rate, p.step_time) * grown
    along = steady_retreat(speed, rate, p.step_time) * grown
    off = (xi - stands - wp.vec3(across, 0.0, along)) * (1.0 + p.sway)
    return stands + wp.vec3(wp.clamp(off[0], -ACROSS, ACROSS), 0.0, wp.clamp(off[2], -ALONG, ALONG))


@func
def swing_path(p: ProgramParameters, plan: wp.ref[StepPlan], steps: wp.array[float]):
    """Where the sole that swings is to be at this moment."""
    swings = 1.0 - double_share(p)
    time = swings * p.step_time
    share = (steps[PHASE] - double_share(p)) / swings
    lifted = kept(LIFTED, steps)
    way = kept(FOOTHOLD, steps) - lifted
    s = smooth_way(share)
    up = hill(share) * p.step_height
    plan.place = lifted + way * s[0] + wp.vec3(0.0, up[0], 0.0)
    plan.velocity = (way * s[1] + wp.vec3(0.0, up[1], 0.0)) / time
    plan.acceleration = (way * s[2] + wp.vec3(0.0, up[2], 0.0)) / (time * time)


@func
def has_landed(instance: int, side: int, p: ProgramParameters, model: ModelRef, state: StateRef, phase: float) -> bool:
    """Whether the foot that swings bears, or has had its time."""
    share = (phase - double_share(p)) / (1.0 - double_share(p))
    bears = state.foot_force[instance, side][1] > LANDED * body_weight(instance, model)
    return (share > LANDS_FROM and bears) or phase > LONGEST


@func
def plan_step(
    instance: int, p: ProgramParameters, layout: Layout, model: ModelRef, state: StateRef, frames: Frames,
    steps: wp.array[float],
) -> StepPlan:  # fmt: skip
    """Bring phase, stance and foothold to this moment."""
    plan = StepPlan()
    plan.swing = -1
    plan.leaves = -1
    plan.stands = -1
    if p.step_time <= 0.0:
        return plan
    plan.active = 1
    left = sole_middle(instance, model.feet.left, layout, model, frames)
    right = sole_middle(instance, model.feet.right, layout, model, frames)
    if steps[HEIGHT] == 0.0:
        steps[HEIGHT] = frames.center[instance, 0][1] - 0.5 * (left[1] + right[1])
    height = wp.max(steps[HEIGHT] + p.com_y, LEAST_HEIGHT)
    plan.rate = falling_rate(height, at(model.gravity, instance, 0))
    if steps[SWING] == NONE_SWINGS:
        plan.height = 0.5 * (left[1] + right[1]) + height
        plan.pressure = shift_weight(instance, p, left, right, plan.rate, frames, steps)
        keep(PRESSURE, plan.pressure, steps)
        return plan
    time = float(layout.every) * model.time_step
    steps[SPEED] = towards(steps[SPEED], p.speed, p.acceleration * time)
    steps[PHASE] = steps[PHASE] + time / p.step_time
    side = wp.where(steps[SWING] == LEFT_SWINGS, 0, 1)
    if has_landed(instance, side, p, model, state, steps[PHASE]):
        side = 1 - side
        steps[SWING] = wp.where(side == 0, LEFT_SWINGS, RIGHT_SWINGS)
        steps[PHASE] = 0.0
        keep(LIFTED, wp.where(side == 0, left, right), steps)
    stands = wp.where(side == 0, right, left)
    swings = wp.where(side == 0, left, right)
    foot = wp.where(side == 0, model.feet.left, model.feet.right)
    plan.stands = wp.where(side == 0, model.feet.right, model.feet.left)
    plan.height = stands[1] + height
    xi = extrapolated_center(instance, plan.rate, frames)
    phase = steps[PHASE]
    keep(FOOTHOLD, foothold(p, stands, outwards(side), plan.rate, xi, phase, steps[SPEED]), steps)
    plan.pressure = pressure_of_step(p, stands, outwards(side), plan.rate, xi, phase, steps[SPEED])
    if phase < double_share(p):
        plan.leaves = foot
        plan.share = 1.0 - phase / double_share(p)
        plan.pressure = plan.pressure + (kept(PRESSURE, steps) - plan.pressure) * plan.share
        keep(LIFTED, swings, steps)
    else:
        plan.swing = foot
        swing_path(p, plan, steps)
        keep(PRESSURE, plan.pressure, steps)
    return plan


@func
def pendulum_wanted(instance: int, p: ProgramParameters, plan: StepPlan, frames: Frames) -> wp.vec3:
    """Wanted acceleration of the centre of mass: the pendulum's, and its height kept."""
    center = frames.center[instance, 0]
    wanted = (center - plan.pressure) * plan.rate * plan.rate
    wanted[1] = p.com_kp * (plan.height - center[1]) - p.com_kd * frames.center[instance, 1][1]
    return wanted


@func
def swing_task(
    instance: int, p: ProgramParameters, plan: StepPlan, layout: Layout, model: ModelRef, frames: Frames,
    memory: wp.array[float], sums: TaskSums,
):  # fmt: skip
    """The middle of the sole that swings follows its path, and the foot keeps the orientation of the start."""
    foot = plan.swing
    if foot < 0:
        return
    start = layout.bodies + foot * BODY_FLOATS + 4
    before = wp.quat(memory[start], memory[start + 1], memory[start + 2], memory[start + 3])
    orientation = frames.orientation[instance, foot]
    spin = frames.angular_velocity[instance, foot]
    place = sole_middle(instance, foot, layout, model, frames)
    arm = place - frames.position[instance, foot]
    velocity = frames.velocity[instance, foot] + wp.cross(spin, arm)
    wanted = plan.acceleration + (plan.place - place) * p.step_kp + (plan.velocity - velocity) * p.step_kd
    wanted -= body_point_acceleration(instance, foot, arm, frames)
    turn = wp.quat_rotate(orientation, pd_error(orientation, before)) * p.step_kp - spin * p.step_kd
    turn -= frames.turning_drift[instance, foot]
    for axis in range(3):
        point_row(instance, foot, place, unit(axis), 0.0, model.skeleton.plan, frames, sums.row)
        add_task(p.step_weight, wanted[axis], sums)
        point_row(instance, foot, place, unit(axis), 1.0, model.skeleton.plan, frames, sums.row)
        add_task(p.step_weight * TURN, turn[axis], sums)
