"""Episodes of learning: how they begin, what is wanted in them, pushes. One thread an instance, nothing on the host."""

import warp as wp

from warpmuscle.kernels.algebra.random_numbers import AIM, COMMAND, PUSH, PUSHED, START, VARIANT, VELOCITY, random_of
from warpmuscle.kernels.algebra.spatial import heading_angle
from warpmuscle.kernels.body.kinematics import coordinate_quat, coordinate_vector
from warpmuscle.kernels.structs import ROOT_FIXED, ROOT_FREE, ROOT_PLANAR, State

wp.set_module_options({"enable_backward": False})

SPEED, TURNING_RATE, FIRST_POSE = 0, 1, 2  # of the commands
LEAST_PACE = 0.1  # of the clock's speed
QUARTERS = 4  # whereto a push can go, as seen along the wanted heading: ahead, to the left, back, to the right
NOT_YET = -1
AT_ONCE = -1.0  # in place of a phase, as any below 0 is


@wp.struct
class Episodes:
    """Where every instance is in its episode."""

    seed: wp.array[int]  # (1,) of all random numbers
    decision: wp.array[int]  # (instances,) decisions so far, in all episodes
    number: wp.array[int]  # (instances,) episodes begun
    length: wp.array[int]  # (instances,) decisions in this episode
    start_row: wp.array[int]  # (instances,) which start it has
    variant: wp.array[int]  # (instances,) which masses, strengths and slope
    command: wp.array2d[float]  # (instances, commands) m/s, rad/s, then wanted coordinates
    phase: wp.array[float]  # (instances,) of the imitated gait, 0 to 1 from a contact of the left foot to its next
    heading: wp.array[float]  # (instances,) rad, that is wanted now
    side: wp.array[float]  # (instances,) m, to the left of the wanted way
    place: wp.array[wp.vec3]  # (instances,) m, of the root at the last decision
    start_place: wp.array[wp.vec3]  # (instances,) m
    start_step: wp.array[int]  # (instances,) the step that the start stands at
    next_push: wp.array[int]  # (instances,) number of the decision in which it comes
    hardness: wp.array[float]  # (instances,) 0 to 1, share of what disturbs this episode, see `EpisodeRules.growth`
    push_hardness: wp.array2d[float]  # (instances, QUARTERS) the same of pushes alone, see `EpisodeRules.push_growth`
    pushed: wp.array[int]  # (instances,) quarter of the last push of this episode; NOT_YET: there was none
    mask: wp.array[bool]  # (instances,) whose episode ended, so that a new one begins


@wp.struct
class EpisodeRules:
    """What is drawn for episodes, the same for all of them."""

    root: int  # ROOT_FREE ...
    starts: int
    variants: int
    left_out: float  # share of the variants that graded episodes do without, the easiest within their difficulty
    command_decisions: int  # after which other commands are drawn; 0: never within an episode
    command_low: wp.array[float]
    command_high: wp.array[float]
    turning_share: float  # of commands that turn, 0 to 1
    cycle_rate: float  # 1/s, of the imitated gait at the clock's speed; 0: there is none
    clock_speed: float  # m/s
    cadence_power: float
    run_from: float  # m/s, wanted, from which the clock is that of a run; 0: it never is
    run_rate: float  # 1/s, of the run at its clock's speed
    run_speed: float  # m/s
    run_power: float
    start_phase: wp.array[float]  # (starts,)
    velocity_noise: float  # m/s
    push: float  # N s
    push_least: float  # share of the greatest impulse that every push has
    push_growth: float  # of the hardness of a quarter, with a push that is withstood; 0: pushes have none of their own
    push_shrinkage: float  # of it, with one that is not
    pushed_share: float  # of episodes, in which pushes come
    aimed_share: float  # of pushes, that come at a phase and go to a side; others come at any time and go anywhere
    push_phase: wp.vec2  # of the imitated gait, between which those come; AT_ONCE twice: at any
    push_angle: wp.vec2  # rad from the wanted heading to the left, between which those go
    push_mirrored: int  # 1: half of those are mirror images, half a cycle later and to the other side
    push_from_heading: int  # 1: angles of pushes are from the wanted heading; 0: from z
    push_decisions: int  # between two pushes, in the mean; 0: there are none
    push_steps: int
    time_step: float  # s, of the simulation
    decision_time: float  # s
    growth: float  # of the hardness, with an episode that lasts
    shrinkage: float  # of the hardness, with an episode that fails
    velocity_grows: int  # 1: velocity_noise does with the hardness; 0: all of it is there always
    push_grows: int  # 1: pushes do
    longest: int  # decisions of an episode


@wp.struct
class RestoredArray:
    """An array of the state, and the starts that its rows can have, in 4-byte words."""

    target: wp.uint64  # (instances, elements, size), or if side by side (elements, instances, size)
    source: wp.uint64  # (starts or variants, words)
    words: int  # of an instance
    size: int  # words of an element
    side_by_side: int  # 1: elements of neighbouring instances are, see `core.arrays.instance_zeros`


@wp.func
def root_place(root: int, instance: int, state: State) -> wp.vec3:
    """Position of the root, m."""
    read = state
    if root == ROOT_FREE:
        return coordinate_vector(read, instance, 0)
    if root == ROOT_PLANAR:
        return wp.vec3(0.0, state.coordinates[instance, 0], state.coordinates[instance, 1])
    return wp.vec3(0.0)


@wp.func
def root_orientation(root: int, instance: int, state: State) -> wp.quat:
    """Orientation of the root."""
    read = state
    if root == ROOT_FREE:
        return coordinate_quat(read, instance, 3)
    if root == ROOT_PLANAR:
        return wp.quat_from_axis_angle(wp.vec3(1.0, 0.0, 0.0), state.coordinates[instance, 2])
    return wp.quat(0.0, 0.0, 0.0, 1.0)


@wp.func
def draw_commands(instance: int, counter: int, episodes: Episodes, rules: EpisodeRules):
    """Draw what is wanted, evenly between its bounds."""
    generator = random_of(episodes.seed[0], instance, counter, COMMAND)
    for k in range(rules.command_low.shape[0]):
        episodes.command[instance, k] = wp.lerp(rules.command_low[k], rules.command_high[k], wp.randf(generator))
    if rules.turning_share < 1.0 and wp.randf(generator) >= rules.turning_share:
        episodes.command[instance, TURNING_RATE] = 0.0


@wp.func
def clock_rate(speed: float, rules: EpisodeRules) -> float:
    """Cycles a second of the imitated gait at a wanted speed, m/s; it never stands still."""
    if rules.run_from > 0.0 and speed >= rules.run_from:
        return rules.run_rate * wp.pow(speed / rules.run_speed, rules.run_power)
    if rules.cadence_power == 0.0:
        return rules.cycle_rate
    return rules.cycle_rate * wp.pow(wp.max(speed / rules.clock_speed, LEAST_PACE), rules.cadence_power)


@wp.func
def hardness_after(hardness: float, length: int, rules: EpisodeRules) -> float:
    """Hardness of an episode after one of this hardness that ended after so many decisions, 0 if there was none."""
    if length == 0:
        return hardness
    return wp.clamp(hardness + wp.where(length >= rules.longest, rules.growth, -rules.shrinkage), 0.0, 1.0)


@wp.func
def quarter_of(angle: float) -> int:
    """The quarter that a direction lies in, rad from straight ahead, 0 to 2 pi."""
    return int(angle * wp.static(2.0 / wp.PI) + 0.5) % QUARTERS


@wp.func
def count_push(instance: int, withstood: bool, episodes: Episodes, rules: EpisodeRules):
    """Let pushes like the last one of this episode be harder, or less hard, from now on."""
    quarter = episodes.pushed[instance]
    if rules.push_growth > 0.0 and quarter != NOT_YET:
        change = wp.where(withstood, rules.push_growth, -rules.push_shrinkage)
        episodes.push_hardness[instance, quarter] = wp.clamp(
            episodes.push_hardness[instance, quarter] + change, 0.0, 1.0
        )
    episodes.pushed[instance] = NOT_YET


@wp.func
def begin_push(instance: int, angle: float, share: float, episodes: Episodes, rules: EpisodeRules) -> wp.vec3:
    """Force of a push, N, of a share of the greatest impulse that there is now; its quarter is noted.

    The angle is one from z, or from the wanted heading, as the rules say.
    """
    hardness = share_of(rules.push_grows, episodes.hardness[instance])
    if rules.push_growth > 0.0:
        quarter = quarter_of(angle)
        hardness = episodes.push_hardness[instance, quarter]
        episodes.pushed[instance] = quarter
    towards = wp.where(rules.push_from_heading == 1, angle + episodes.heading[instance], angle)
    impulse = share * rules.push * hardness
    force = impulse / (float(rules.push_steps) * rules.time_step)
    return wp.vec3(force * wp.sin(towards), 0.0, force * wp.cos(towards))


@wp.func
def share_of(grows: int, hardness: float) -> float:
    """How much of a disturbance there is at a hardness; all of one that does not grow."""
    return wp.where(grows == 1, hardness, 1.0)


@wp.func
def is_pushed(instance: int, number: int, seed: int, share: float) -> bool:
    """Whether pushes come in this episode of an instance, as they do in a share of all."""
    generator = random_of(seed, instance, number, PUSHED)
    return wp.randf(generator) < share


@wp.func
def aim_of(instance: int, due: int, angle: float, episodes: Episodes, rules: EpisodeRules) -> wp.vec2:
    """Phase at which a push comes that is due since a decision, or AT_ONCE, and its angle, rad from 0 to 2 pi.

    The angle is the given one if the push is not aimed.
    """
    generator = random_of(episodes.seed[0], instance, due, AIM)
    if wp.randf(generator) >= rules.aimed_share:
        return wp.vec2(AT_ONCE, angle)
    phase = wp.lerp(rules.push_phase[0], rules.push_phase[1], wp.randf(generator))
    towards = wp.lerp(rules.push_angle[0], rules.push_angle[1], wp.randf(generator))
    if rules.push_mirrored == 1 and wp.randf(generator) < 0.5:
        towards = -towards
        phase = wp.where(phase < 0.0, AT_ONCE, phase + 0.5)
    turns = towards * wp.static(0.5 / wp.PI)
    return wp.vec2(
        wp.where(phase < 0.0, AT_ONCE, phase - wp.floor(phase)),
        (turns - wp.floor(turns)) * wp.static(2.0 * wp.PI),
    )


@wp.func
def has_come(target: float, phase: float, moved: float) -> bool:
    """Whether the clock has come to a phase in this decision, in which it moved by so much of a cycle."""
    since = phase - target
    return target < 0.0 or since - wp.floor(since) < moved


@wp.func
def push_wait(generator: wp.uint32, rules: EpisodeRules) -> int:
    """Decisions until the next push: half of those in the mean to three halves."""
    return wp.max(int((0.5 + wp.randf(generator)) * float(rules.push_decisions)), 1)


@wp.kernel
def begin_decision(
    # in
    rules: EpisodeRules,
    # in and out
    episodes: Episodes, state: State,
):  # fmt: skip
    """Count, draw commands and pushes that are due, and remember where the root is. Launch with dim = instances."""
    i = wp.tid()
    decision = episodes.decision[i] + 1
    length = episodes.length[i]
    episodes.decision[i] = decision
    episodes.length[i] = length + 1
    episodes.place[i] = root_place(rules.root, i, state)
    if rules.command_decisions > 0 and length > 0 and length % rules.command_decisions == 0:
        draw_commands(i, decision, episodes, rules)
    episodes.heading[i] = episodes.heading[i] + episodes.command[i, TURNING_RATE] * rules.decision_time
    moved = clock_rate(episodes.command[i, SPEED], rules) * rules.decision_time
    phase = episodes.phase[i] + moved
    phase = phase - wp.floor(phase)
    episodes.phase[i] = phase
    due = episodes.next_push[i]
    if rules.push_decisions > 0 and decision >= due:
        generator = random_of(episodes.seed[0], i, due, PUSH)
        angle = wp.randf(generator) * wp.static(2.0 * wp.PI)
        aim = aim_of(i, due, angle, episodes, rules)
        if has_come(aim[0], phase, moved):
            count_push(i, True, episodes, rules)  # it is still up after the last one
            share = wp.lerp(rules.push_least, 1.0, wp.randf(generator))
            if is_pushed(i, episodes.number[i], episodes.seed[0], rules.pushed_share):
                state.push[i] = begin_push(i, aim[1], share, episodes, rules)
                step = state.step[i]
                state.push_steps[i, 0] = step
                state.push_steps[i, 1] = step + rules.push_steps
            episodes.next_push[i] = decision + push_wait(generator, rules)


@wp.kernel
def draw_starts(
    # in
    rules: EpisodeRules,
    # in and out
    episodes: Episodes,
):  # fmt: skip
    """Draw start and variant of the episodes that begin. Launch with dim = instances."""
    i = wp.tid()
    if not episodes.mask[i]:
        return
    number = episodes.number[i] + 1
    episodes.number[i] = number
    length = episodes.length[i]
    episodes.hardness[i] = hardness_after(episodes.hardness[i], length, rules)
    if length > 0:
        count_push(i, length >= rules.longest, episodes, rules)
    episodes.pushed[i] = NOT_YET
    episodes.length[i] = 0
    seed = episodes.seed[0]
    generator = random_of(seed, i, number, START)
    episodes.start_row[i] = wp.min(int(wp.randf(generator) * float(rules.starts)), rules.starts - 1)
    generator = random_of(seed, i, number, VARIANT)
    episodes.variant[i] = wp.min(int(wp.randf(generator) * float(rules.variants)), rules.variants - 1)


@wp.kernel
def grade_variants(
    # in
    rules: EpisodeRules, difficulty: wp.array[float],
    # in and out
    episodes: Episodes,
):  # fmt: skip
    """Draw variants anew, as hard ones as episodes are difficult, 0 to 1. Launch with dim = instances."""
    i = wp.tid()
    if not episodes.mask[i]:
        return
    generator = random_of(episodes.seed[0], i, episodes.number[i], VARIANT)
    count = wp.clamp(int(difficulty[i] * float(rules.variants)), 1, rules.variants)
    kept = rules.variants - int(rules.left_out * float(rules.variants))
    first = wp.clamp(count - kept, 0, count - 1)
    drawn = first + int(wp.randf(generator) * float(count - first))
    episodes.variant[i] = wp.min(drawn, count - 1)


@wp.kernel
def restore_rows(
    # in
    mask: wp.array[bool], row: wp.array[int], arrays: wp.array[RestoredArray], rows: int, lanes: int,
):  # fmt: skip
    """Copy rows of the instances of a mask into arrays of the state. Launch with dim = (instances, lanes)."""
    i, lane = wp.tid()
    if not mask[i]:
        return
    for k in range(arrays.shape[0]):
        entry = arrays[k]
        instances = mask.shape[0]
        count = entry.words // entry.size
        in_rows = wp.array(ptr=entry.target, shape=(instances, count, entry.size), dtype=int)
        beside = wp.array(ptr=entry.target, shape=(count, instances, entry.size), dtype=int)
        source = wp.array(ptr=entry.source, shape=(rows, entry.words), dtype=int)
        for word in range(lane, entry.words, lanes):
            element = word // entry.size
            part = word % entry.size
            value = source[row[i], word]
            if entry.side_by_side == 1:
                beside[element, i, part] = value
            else:
                in_rows[i, element, part] = value


@wp.kernel
def begin_episodes(
    # in
    rules: EpisodeRules,
    # in and out
    episodes: Episodes, state: State,
):  # fmt: skip
    """Begin episodes whose state has been put to its start: noise, commands, pushes. Launch with dim = instances."""
    i = wp.tid()
    if not episodes.mask[i]:
        return
    seed = episodes.seed[0]
    number = episodes.number[i]
    generator = random_of(seed, i, number, VELOCITY)
    if rules.root != ROOT_FIXED and rules.velocity_noise > 0.0:
        moving = wp.where(rules.root == ROOT_FREE, 3, 2)
        deviation = rules.velocity_noise * share_of(rules.velocity_grows, episodes.hardness[i])
        for k in range(moving):
            state.speeds[i, k] = state.speeds[i, k] + deviation * wp.randn(generator)
    draw_commands(i, episodes.decision[i], episodes, rules)
    place = root_place(rules.root, i, state)
    episodes.place[i] = place
    episodes.start_place[i] = place
    episodes.start_step[i] = state.step[i]
    episodes.heading[i] = heading_angle(root_orientation(rules.root, i, state))
    episodes.side[i] = 0.0
    episodes.phase[i] = rules.start_phase[episodes.start_row[i]]
    state.push[i] = wp.vec3(0.0)
    state.push_steps[i, 0] = 0
    state.push_steps[i, 1] = 0
    if rules.push_decisions > 0:
        generator = random_of(seed, i, number, PUSH)
        episodes.next_push[i] = episodes.decision[i] + push_wait(generator, rules)
