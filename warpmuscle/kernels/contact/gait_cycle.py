"""The gait cycle of each foot: from when it touches down to when it does so again.

`warpmuscle.gait.foot_contact` finds the same in a recording.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import LEFT, RIGHT, FootCycle, ModelRef, ScratchRef, StateRef, at

SHORTEST_STRIDE = 0.1  # m, from which on a stride has a direction; see `warpmuscle.gait.measures`


@func
def cycle_after(cycle: FootCycle, loaded: bool, first: bool, time_step: float, held: float, lifted: float) -> FootCycle:
    """The cycle of a foot after a step.

    A foot that is loaded for `held` has touched down when that load began, one that is unloaded for `lifted` has left
    the ground. Where it is loaded from the first step on, it did not touch down then.

    Args:
        loaded: whether the foot was loaded in this step. first: whether this is the first step of the motion.
        time_step, held, lifted: s.
    """
    cycle.since += time_step
    cycle.loaded = wp.where(loaded, cycle.loaded + time_step, 0.0)
    if first and loaded:
        cycle.grounded = 1
        cycle.loaded = held
    if cycle.loaded >= held:
        if cycle.grounded == 0:
            if cycle.landings > 0:
                cycle.length = cycle.since - cycle.loaded
            cycle.landings += 1
            cycle.grounded = 1
            cycle.since = cycle.loaded
        cycle.away = 0.0
    else:
        cycle.away += time_step
        if cycle.away >= lifted and not loaded:
            cycle.grounded = 0
    return cycle


@func
def part_of_cycle(cycle: FootCycle, step_part: float) -> float:
    """Part of its gait cycle that a foot has behind it, 0 to 1: the time since it touched down over the last cycle's.

    A foot that has just been loaded counts as touching down, so that the part does not lag by the time after which that
    is sure. One that stays in the air longer than its last cycle took is at 1.

    Args:
        step_part: what counts until the foot has landed twice, and so has a whole cycle behind it.
    """
    if cycle.length <= 0.0:
        return wp.clamp(step_part, 0.0, 1.0)
    since = cycle.since
    if cycle.grounded == 0 and cycle.loaded > 0.0:
        since = cycle.loaded
    return wp.min(since / cycle.length, 1.0)


@func
def part_by_time(cycle: FootCycle, begin: float, period: float) -> float:
    """Part of a gait cycle of this period, s, that a foot has behind it, 0 to 1, from its last touch-down or the start.

    Args:
        begin: part of the cycle at the start.
    """
    part = wp.where(cycle.landings > 0, 0.0, begin) + cycle.since / period
    return part - wp.floor(part)


@func
def part_of_step(phase: float, stance: int, side: int) -> float:
    """Part of the gait cycle by the controller's phase: a stance leg is in the first half of it, a swing leg behind."""
    half = 0.5 * wp.min(phase, 1.0)
    return wp.where(stance == side, half, 0.5 + half)


@func
def step_part(instance: int, side: int, state: StateRef) -> float:
    """The same of an instance; where no controller has a phase, as at the start of a step in left stance."""
    if instance >= state.simbicon.phase.shape[0]:
        return part_of_step(0.0, LEFT, side)
    return part_of_step(state.simbicon.phase[instance], state.simbicon.stance[instance], side)


@func
def foot_part(instance: int, side: int, state: StateRef) -> float:
    """Part of its gait cycle that the left or right foot has behind it, 0 to 1; before its second landing by phase."""
    return part_of_cycle(state.foot_cycle[instance, side], step_part(instance, side, state))


@func
def width_from_line(before: wp.vec3, place: wp.vec3, other: wp.vec3, facing: wp.vec3, side: int) -> float:
    """How far a foot stands from the line between two places of the other one, to its own side, m.

    Args:
        before, place: of the foot that has just landed. other: of the one that stands. facing: unit vector, horizontal.
        side: of the foot that has landed, LEFT or RIGHT.
    """
    stride = wp.vec3(place[0] - before[0], 0.0, place[2] - before[2])
    length = wp.length(stride)
    along = facing
    if length > wp.static(SHORTEST_STRIDE):
        along = stride * (wp.sign(wp.dot(stride, facing)) / length)
    to_the_left = (other[0] - place[0]) * along[2] - (other[2] - place[2]) * along[0]
    return wp.where(side == LEFT, -to_the_left, to_the_left)


@func
def landed(cycle: FootCycle, place: wp.vec3, time_step: float, before: int) -> FootCycle:
    """The cycle with where the foot was when its load began, and where it touched down if it has in this step.

    Args:
        place: of its centre of mass, m. before: touch-downs before this step.
    """
    if cycle.loaded > 0.0 and cycle.loaded <= 1.5 * time_step:
        cycle.landing = place
    if cycle.landings > before:
        cycle.before = cycle.place
        cycle.place = cycle.landing
    return cycle


@func
def advance_cycles(instance: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Gait cycles of both feet after a step, with the foot forces of that step. One lane calls it."""
    rule = model.contact_rule
    bound = rule[0] * body_weight(instance, model)
    for side in range(LEFT, RIGHT + 1):
        loaded = state.foot_force[instance, side][1] > bound
        cycle = state.foot_cycle[instance, side]
        landings = cycle.landings
        cycle = cycle_after(cycle, loaded, step == 0, model.time_step, rule[1], rule[2])
        foot = wp.where(side == LEFT, model.feet.left, model.feet.right)
        center = work.rotation[foot] * at(model.skeleton.row, instance, foot).com
        cycle = landed(cycle, work.position[foot] + center, model.time_step, landings)
        other = state.foot_cycle[instance, LEFT + RIGHT - side]
        if cycle.landings > landings and cycle.landings > 1 and other.landings > 0:
            facing = wp.quat_rotate(heading(work.orientation[0]), wp.vec3(0.0, 0.0, 1.0))
            cycle.width = width_from_line(cycle.before, cycle.place, other.place, facing, side)
        state.foot_cycle[instance, side] = cycle
