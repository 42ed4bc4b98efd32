"""How near a decision comes to a gait that is imitated: joints, forces on the feet, and which feet carry."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.learning.reward_structs import COUNT, NUMBERS, Gains, GaitTable, RewardRules
from warpmuscle.kernels.learning.senses import steepest_piece
from warpmuscle.kernels.objective.term_functions import bin_of
from warpmuscle.kernels.structs import State, at

SPEED_WIDTH, POSE_WIDTH, IMITATION_WIDTH, FORCE_WIDTH, FORCE_LIMIT = range(COUNT, NUMBERS)
QUATERNION = 4  # coordinates of a ball joint
LOADED = 0.03  # body weights, from which on a foot carries, as in `scene.ground`


@func
def closeness(squared_angle: float, width: float) -> float:
    """exp(-(angle/width)^2)."""
    return wp.exp(-squared_angle / (width * width))


@func
def smoothed(first: bool, before: float, now: float, share: float) -> float:
    """A low-pass of first order, which begins with the first value."""
    if first:
        return now
    return before + share * (now - before)


@func
def speed_row(speed: float, gait: GaitTable) -> int:
    """The speed of the table that is nearest to a wanted one, m/s."""
    if gait.speeds < 2:
        return 0
    return wp.clamp(int(wp.round((speed - gait.first_speed) / gait.speed_step)), 0, gait.speeds - 1)


@func
def wanted_force(phase: float, row: int, gait: GaitTable) -> float:
    """People's vertical force at a part of the cycle, body weights."""
    return gait.force[row, bin_of(phase, gait.force.shape[1])]


@func
def people_load(foot: int, phase: float, row: int, gait: GaitTable) -> float:
    """People's vertical force on a foot at a part of the left foot's cycle, body weights."""
    lag = wp.where(foot == 0, 0.0, gait.right)
    return wanted_force(phase - lag - wp.floor(phase - lag), row, gait)


@func
def foot_load(instance: int, foot: int, reward: RewardRules, state: State) -> float:
    """Vertical force on a foot, in weights of the body as it is, not less than 0."""
    weight = at(reward.total_mass, instance, 0) * at(reward.gravity, instance, 0)
    return wp.max(state.foot_force[instance, foot][1] / weight, 0.0)


@func
def force_closeness(
    instance: int, phase: float, row: int, reward: RewardRules, gains: Gains, state: State,
) -> float:  # fmt: skip
    """Mean over the feet of how near the smoothed force is to people's, at most 1; the smoothed force goes on."""
    total = wp.float32(0.0)
    feet = gains.foot_force.shape[1]
    for foot in range(feet):
        load = foot_load(instance, foot, reward, state)
        before = gains.foot_force[instance, foot]
        now = smoothed(before < 0.0, before, load, reward.force_share)
        gains.foot_force[instance, foot] = now
        away = now - people_load(foot, phase, row, reward.gait)
        total += closeness(away * away, reward.now[FORCE_WIDTH])
    return total / float(wp.max(feet, 1))


@func
def contact_likeness(instance: int, phase: float, row: int, reward: RewardRules, state: State) -> float:
    """Share of the feet that are on the ground where people's are, or in the air where theirs are."""
    alike = wp.float32(0.0)
    feet = state.foot_force.shape[1]
    for foot in range(feet):
        carries = foot_load(instance, foot, reward, state) > LOADED
        if carries == (people_load(foot, phase, row, reward.gait) > LOADED):
            alike += 1.0
    return alike / float(wp.max(feet, 1))


@func
def imitation(
    instance: int, phase: float, speed: int, up: wp.vec3, width: float, gait: GaitTable, state: State
) -> float:
    """Weighted mean of how near joints, and the vertical in the trunk, are to those of the gait, at most 1.

    Of a ball joint 4 (1 - (p q)^2) stands for the squared angle between quaternions p and q, near which it is.
    """
    bins = gait.up.shape[0]
    bin = bin_of(phase, bins)
    row = speed * bins + bin
    away = up - gait.up[bin]
    total = gait.up_weight * closeness(wp.dot(away, away), width)
    for joint in range(gait.first.shape[0]):
        squared = wp.float32(0.0)
        product = wp.float32(0.0)
        for k in range(gait.first[joint], gait.end[joint]):
            error = state.coordinates[instance, k] - gait.coordinate[row, k]
            squared += error * error
            product += state.coordinates[instance, k] * gait.coordinate[row, k]
        if gait.end[joint] - gait.first[joint] == QUATERNION:
            squared = 4.0 * wp.max(1.0 - product * product, 0.0)
        total += gait.weight[joint] * closeness(squared, width)
    return total


@func
def other_steps(instance: int, reward: RewardRules, state: State) -> float:
    """How much the ground asks for other steps than a gait on even ground, 0 to 1."""
    return wp.clamp(2.0 * steepest_piece(instance, state, reward.around) / reward.uneven - 1.0, 0.0, 1.0)
