"""What decisions of a policy are worth, and when an episode ends. One thread an instance."""

import inspect
import re

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading_angle
from warpmuscle.kernels.learning.episodes import FIRST_POSE, SPEED, EpisodeRules, Episodes, root_orientation, root_place
from warpmuscle.kernels.learning.likeness import (
    FORCE_LIMIT,
    IMITATION_WIDTH,
    POSE_WIDTH,
    SPEED_WIDTH,
    contact_likeness,
    foot_load,
    force_closeness,
    imitation,
    other_steps,
    smoothed,
    speed_row,
)
from warpmuscle.kernels.learning.reward_structs import (
    COUNT,
    TERMS,
    Gains,
    ObjectiveWeights,
    RewardRules,
    term_values,
)
from warpmuscle.kernels.learning.senses import up_in_trunk
from warpmuscle.kernels.structs import RUNNING, State

wp.set_module_options({"enable_backward": False})

SPEED_TERM, PROGRESS, ALIVE, UPRIGHT, POSE = map(TERMS.index, ("speed", "progress", "alive", "upright", "pose"))
IMITATION, FORCE, CONTACT, EFFORT, ACTION, ACTION_RATE, OVERLOAD = map(
    TERMS.index, ("imitation", "force", "contact", "effort", "action", "action_rate", "overload")
)
HEADING, SIDE, OBJECTIVE, FAILURE = map(TERMS.index, ("heading", "side", "objective", "failure"))
# What is logged of an episode behind its terms.
FORWARD, DECISIONS, COMPLETED, ENDED = range(COUNT, COUNT + 4)
LOGGED = COUNT + 4
LEAST_DISTANCE = 1.0  # m, that the cost of transport counts for
STANDING = 0.05  # m/s, below which a wanted speed is none
REACHES, FAILS = wp.constant(1), wp.constant(2)
UNKNOWN = -1.0  # smoothed force of an episode that has just begun
NO_SPEED = -1.0e9  # m/s, smoothed speed of one
EXCITATIONS, ACTIVATIONS, ACTIONS = 0, 1, 2


@wp.func
def mean_square(values: wp.array2d[float], instance: int) -> float:
    """Mean of the squares of a row."""
    total = wp.float32(0.0)
    for k in range(values.shape[1]):
        total += values[instance, k] * values[instance, k]
    return total / float(wp.max(values.shape[1], 1))


@wp.func
def mean_square_change(values: wp.array2d[float], before: wp.array2d[float], instance: int) -> float:
    """Mean of the squared changes of a row."""
    total = wp.float32(0.0)
    for k in range(values.shape[1]):
        change = values[instance, k] - before[instance, k]
        total += change * change
    return total / float(wp.max(values.shape[1], 1))


@wp.func
def objective_so_far(
    instance: int, weights: ObjectiveWeights, rules: EpisodeRules, episodes: Episodes, state: State
) -> wp.float64:
    """The scene's weighted objective since the start of the episode, see `model.objective.term_values`."""
    total = wp.float64(0.0)
    if weights.torque != wp.float64(0.0):
        for body in range(state.torque_integral.shape[1]):
            total += weights.torque * state.torque_integral[instance, body]
    energy = wp.float64(0.0)
    for term in range(weights.muscle.shape[0]):
        if weights.muscle[term] != wp.float64(0.0) or term == weights.energy:
            summed = wp.float64(0.0)
            for m in range(state.muscle_terms.shape[2]):
                summed += state.muscle_terms[instance, term, m]
            total += weights.muscle[term] * summed
            if term == weights.energy:
                energy = summed * weights.time_step
    for term in range(weights.body.shape[0]):
        for body in range(state.body_terms.shape[2]):
            total += weights.body[term] * state.body_terms[instance, term, body]
    for term in range(weights.instance.shape[0]):
        total += weights.instance[term] * state.instance_terms[instance, term]
    steps = wp.float64(state.step[instance] - episodes.start_step[instance])
    total += weights.basal * steps
    if weights.transport != wp.float64(0.0):
        gone = root_place(rules.root, instance, state) - episodes.start_place[instance]
        distance = wp.max(wp.length(wp.vec3(gone[0], 0.0, gone[2])), LEAST_DISTANCE)
        energy += weights.basal_power * steps * weights.time_step
        total += weights.transport * energy / (weights.mass * wp.float64(distance))
    return total


@wp.func
def pose_error(instance: int, reward: RewardRules, episodes: Episodes, state: State) -> float:
    """Mean squared difference of the wanted coordinates."""
    total = wp.float32(0.0)
    for k in range(reward.pose.shape[0]):
        error = state.coordinates[instance, reward.pose[k]] - episodes.command[instance, FIRST_POSE + k]
        total += error * error
    return total / float(wp.max(reward.pose.shape[0], 1))


@wp.func
def overload(instance: int, reward: RewardRules, state: State) -> float:
    """Weights of the body above the limit, summed over the feet."""
    total = wp.float32(0.0)
    for foot in range(state.foot_force.shape[1]):
        total += wp.max(foot_load(instance, foot, reward, state) - reward.now[FORCE_LIMIT], 0.0)
    return total


@wp.func
def smoothed_speed(instance: int, forward: float, reward: RewardRules, gains: Gains) -> float:
    """The speed along the wanted heading after a low-pass that begins with the first one; it goes on."""
    before = gains.speed[instance]
    now = smoothed(not (before > NO_SPEED), before, forward, reward.speed_share)
    gains.speed[instance] = now
    return now


@wp.func
def progress(forward: float, wanted: float) -> float:
    """Share of the wanted speed, 0 to 1, which tells who stands from who walks too slowly."""
    if wp.abs(wanted) < STANDING:
        return 1.0
    return wp.clamp(forward / wanted, 0.0, 1.0)


@wp.func
def task_terms(
    instance: int, forward: float, reward: RewardRules, rules: EpisodeRules, episodes: Episodes, gains: Gains,
    state: State,
) -> term_values:  # fmt: skip
    """Values of the terms that count for time."""
    q = root_orientation(rules.root, instance, state)
    values = term_values()
    speed = smoothed_speed(instance, forward, reward, gains)
    miss = (speed - episodes.command[instance, SPEED]) / reward.now[SPEED_WIDTH]
    values[SPEED_TERM] = wp.exp(-miss * miss)
    values[PROGRESS] = progress(forward, episodes.command[instance, SPEED])
    values[ALIVE] = 1.0
    values[UPRIGHT] = up_in_trunk(q)[1]
    if reward.weight[POSE] != 0.0:
        error = pose_error(instance, reward, episodes, state)
        values[POSE] = wp.exp(-error / (reward.now[POSE_WIDTH] * reward.now[POSE_WIDTH]))
    if reward.weight[IMITATION] != 0.0:
        row = speed_row(episodes.command[instance, SPEED], reward.gait)
        phase, width = episodes.phase[instance], reward.now[IMITATION_WIDTH]
        values[IMITATION] = imitation(instance, phase, row, up_in_trunk(q), width, reward.gait, state)
    if reward.weight[FORCE] != 0.0:
        row = speed_row(episodes.command[instance, SPEED], reward.gait)
        values[FORCE] = force_closeness(instance, episodes.phase[instance], row, reward, gains, state)
    if reward.weight[CONTACT] != 0.0:
        row = speed_row(episodes.command[instance, SPEED], reward.gait)
        values[CONTACT] = contact_likeness(instance, episodes.phase[instance], row, reward, state)
    if reward.uneven > 0.0:
        share = other_steps(instance, reward, state)
        values[IMITATION] = wp.lerp(values[IMITATION], 1.0, share)
        values[FORCE] = wp.lerp(values[FORCE], 1.0, share)
        values[CONTACT] = wp.lerp(values[CONTACT], 1.0, share)
    if reward.weight[OVERLOAD] != 0.0:
        values[OVERLOAD] = overload(instance, reward, state)
    if reward.weight[EFFORT] != 0.0:
        if reward.effort == EXCITATIONS:
            values[EFFORT] = mean_square(gains.excitation, instance)
        elif reward.effort == ACTIVATIONS:
            values[EFFORT] = mean_square(state.muscles.activation, instance)
        else:
            values[EFFORT] = mean_square(gains.action, instance)
    if reward.weight[ACTION] != 0.0:
        values[ACTION] = wp.min(mean_square(gains.action, instance), 4.0)
    if reward.weight[ACTION_RATE] != 0.0:
        values[ACTION_RATE] = mean_square_change(gains.action, gains.previous, instance)
    values[HEADING] = 1.0 - wp.cos(episodes.heading[instance] - heading_angle(q))
    values[SIDE] = wp.min(wp.abs(episodes.side[instance]), 1.0)
    return values


def _check_rewards() -> None:
    """TypeError if a reward is declared that nothing gives a value, which would count as 0."""
    given = {globals()[name] for name in re.findall(r"values\[(\w+)\] =", inspect.getsource(task_terms.func))}
    given |= {OBJECTIVE, FAILURE}  # which `judge` adds
    if missing := [name for index, name in enumerate(TERMS) if index not in given]:
        raise TypeError(
            f"the reward {missing[0]} of objective/objective_terms.py in kernels has no value in task_terms "
            "in learning/rewards.py"
        )


_check_rewards()


@wp.func
def custom_ending(instance: int, gains: Gains) -> int:
    """How ends of the scene's own end an episode: 0 as none is met, REACHES, or FAILS."""
    found = wp.int32(0)
    for k in range(gains.custom_end.shape[1]):
        if gains.custom_end[instance, k] > 0.0:
            found = wp.max(found, wp.where(gains.end_fails[k] == 1, FAILS, REACHES))
    return found


@wp.func
def counted(weight: float, reward: RewardRules) -> float:
    """A signed weight as it counts now: of costs the share that is taken off."""
    return wp.where(weight < 0.0, weight * reward.costs[0], weight)


@wp.func
def at_speed(wanted: float, speed: float, width: float) -> float:
    """How much counts at a wanted speed of what counts in full at another, m/s; all of it without a width."""
    if width <= 0.0:
        return 1.0
    away = (wanted - speed) / width
    return wp.exp(-away * away)


@wp.kernel
def judge(
    # in
    reward: RewardRules, weights: ObjectiveWeights, rules: EpisodeRules,
    # in and out
    episodes: Episodes, state: State,
    # out
    gains: Gains,
):  # fmt: skip
    """Reward of the decision, whether the episode ends, and what is logged of it. Launch with dim = instances."""
    i = wp.tid()
    failed = state.status[i] != RUNNING
    moved = root_place(rules.root, i, state) - episodes.place[i]
    wanted = episodes.heading[i]
    forward = (moved[0] * wp.sin(wanted) + moved[2] * wp.cos(wanted)) / rules.decision_time
    aside = moved[0] * wp.cos(wanted) - moved[2] * wp.sin(wanted)
    if not (wp.abs(forward) + wp.abs(aside) < 1.0e6):
        failed = True
        forward = 0.0
        aside = 0.0
    episodes.side[i] = episodes.side[i] + aside
    ending = custom_ending(i, gains)
    if ending == FAILS:
        failed = True
    reached = ending == REACHES and not failed
    terms = term_values()
    if failed:
        terms[FAILURE] = 1.0
    else:
        terms = task_terms(i, forward, reward, rules, episodes, gains, state)
        if reward.weight[OBJECTIVE] != 0.0:
            so_far = objective_so_far(i, weights, rules, episodes, state)
            terms[OBJECTIVE] = float(so_far - gains.objective[i])
            gains.objective[i] = so_far
    total = wp.float32(0.0)
    for k in range(COUNT):
        worth = counted(reward.now[k], reward) * terms[k]
        if not (wp.abs(worth) < 1.0e6):
            worth = 0.0
        total += worth
        gains.sums[i, k] = gains.sums[i, k] + worth
    for k in range(gains.custom_weight.shape[0]):
        worth = counted(gains.custom_weight[k], reward) * gains.custom[i, k]
        worth = worth * at_speed(episodes.command[i, SPEED], gains.custom_speed[k], gains.custom_width[k])
        if failed or not (wp.abs(worth) < 1.0e6):
            worth = 0.0
        total += worth
        gains.custom_sums[i, k] = gains.custom_sums[i, k] + worth
    gains.sums[i, FORWARD] = gains.sums[i, FORWARD] + forward
    gains.reward[i] = total
    late = episodes.length[i] >= reward.longest
    gains.terminated[i] = failed or reached
    gains.truncated[i] = late and not (failed or reached)
    if gains.reached.shape[0] > 0:
        gains.reached[i] = reached
    episodes.mask[i] = failed or late or reached
    if failed or late or reached:
        for k in range(gains.custom_weight.shape[0]):
            gains.custom_finished[i, k] = gains.custom_sums[i, k]
        gains.sums[i, DECISIONS] = float(episodes.length[i])
        gains.sums[i, COMPLETED] = wp.where(failed, 0.0, 1.0)
        gains.sums[i, ENDED] = 1.0
        for k in range(LOGGED):
            gains.finished[i, k] = gains.sums[i, k]


@wp.kernel
def forget(
    # in
    mask: wp.array[bool],
    # out
    gains: Gains,
):  # fmt: skip
    """Begin to count again for episodes that begin. Launch with dim = instances."""
    i = wp.tid()
    if not mask[i]:
        return
    gains.objective[i] = wp.float64(0.0)
    gains.speed[i] = NO_SPEED
    for k in range(gains.custom_weight.shape[0]):
        gains.custom_sums[i, k] = 0.0
    for k in range(LOGGED):
        gains.sums[i, k] = 0.0
    for k in range(gains.action.shape[1]):
        gains.action[i, k] = 0.0
    for foot in range(gains.foot_force.shape[1]):
        gains.foot_force[i, foot] = UNKNOWN
