"""What a policy senses: numbers of the state as a body could know them, delayed and noisy as nerves have them."""

import inspect
import re
import sys

import warp as wp

from warpmuscle.kernels.algebra.random_numbers import DELAY, NOISE, NOISINESS, random_of
from warpmuscle.kernels.algebra.spatial import heading, heading_angle
from warpmuscle.kernels.body.kinematics import joint_orientation, speed_vector
from warpmuscle.kernels.contact.terrain import tile_rise
from warpmuscle.kernels.learning.episodes import Episodes, root_orientation, root_place, share_of
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    ROOT_FREE,
    ROOT_PLANAR,
    UNIVERSAL,
    Skeleton,
    State,
    StateRef,
    Terrain,
    at,
)

wp.set_module_options({"enable_backward": False})

GREATEST = 100.0  # of an observation, which is 0 where it is not a number

# Kinds of features.
(
    HEIGHT, UP, VELOCITY, ANGULAR_VELOCITY, COORDINATE, JOINT_SPEED, FOOT_FORCE, ACTIVATION, FIBRE_LENGTH,
    FIBRE_VELOCITY, FIBRE_FORCE, COMMAND, COURSE, ACTION, PHASE, STANCE, PUSH_FORCE, VARIED, HEAD_UP,
    HEAD_ANGULAR_VELOCITY, CLOCK, CUSTOM, GOAL, GOAL_POINT, GROUND, FOOTING, LATER, NOISIER,
) = range(28)  # fmt: skip
GROUND_COLUMNS, GROUND_BEHIND, GROUND_AHEAD = 3, 3, 6  # places of the ground, from right to left and forwards
GROUND_STEP = 0.2  # m, between them
FOOTING_SIDES, FOOTING_BEHIND, FOOTING_AHEAD = 2, 3, 8  # strips of ground on the ways of right and left foot
FOOTING_LENGTH, FOOTING_ASIDE = 0.1, 0.1  # m, of a strip along the way, and from the root's way
FOOTING_SAMPLES = 4  # heights that a strip's mean is of
UNEVEN_STEP, UNEVEN_FIRST, UNEVEN_COUNT = 0.1, -3, 9  # pieces of the way, m, whose rise says whether it is even


@wp.struct
class Feature:
    """One number that is observed."""

    kind: int
    index: int  # which one of its kind
    scale: float
    delay: int  # whole decisions
    late: int  # whole decisions up to which it comes later still in an episode
    noise: float  # standard deviation
    noisier: float  # up to which standard deviation there is noise besides in an episode
    late_grows: int  # 1: `late` does with the hardness of episodes; 0: all of it is there always
    noisier_grows: int  # 1: `noisier` does


@wp.struct
class Surroundings:
    """What features need besides the state."""

    root: int
    head: int  # the body that carries the organ of balance
    skeleton: Skeleton
    normal: wp.array2d[wp.vec3]  # (1 or instances, 1) of the ground
    ground: wp.array2d[float]  # (1 or instances, 1) m, from the origin along the normal
    terrain: Terrain  # over it; nothing where the ground is flat
    body_weight: float  # N
    action: wp.array2d[float]  # (instances, actions) of the last decision
    least_action: float  # beyond which actions do what this one does
    greatest_action: float
    varied: wp.array2d[float]  # (variants, numbers) how an instance differs from others
    custom: wp.array2d[float]  # (instances, numbers) of observations of the scene's own, as they are now
    goal: wp.array2d[float]  # (instances, numbers) see `decision.Decision`


@wp.func
def up_in_trunk(q: wp.quat) -> wp.vec3:
    """The vertical in axes of the trunk."""
    return wp.quat_rotate_inv(q, wp.vec3(0.0, 1.0, 0.0))


@wp.func
def root_velocity(root: int, instance: int, state: State) -> wp.vec3:
    """Velocity of the root, m/s, world."""
    read = state
    if root == ROOT_FREE:
        return speed_vector(read, instance, 0)
    if root == ROOT_PLANAR:
        return wp.vec3(0.0, state.speeds[instance, 0], state.speeds[instance, 1])
    return wp.vec3(0.0)


@wp.func
def root_angular_velocity(root: int, instance: int, state: State) -> wp.vec3:
    """Angular velocity of the root, rad/s, world."""
    read = state
    if root == ROOT_FREE:
        return speed_vector(read, instance, 3)
    if root == ROOT_PLANAR:
        return wp.vec3(state.speeds[instance, 2], 0.0, 0.0)
    return wp.vec3(0.0)


@wp.func
def joint_rate(skeleton: Skeleton, instance: int, body: int, state: StateRef) -> wp.vec3:
    """Angular velocity of a body relative to its parent, rad/s, its own axes; of joints that only turn."""
    plan = skeleton.plan[body]
    row = at(skeleton.row, instance, body)
    first = plan.speed_start
    if plan.joint_type == BALL:
        return speed_vector(state, instance, first)
    if plan.joint_type == FIXED:
        return wp.vec3(0.0)
    rate = row.axis_a * state.speeds[instance, first]
    if plan.joint_type == UNIVERSAL:  # the second axis is one of the parent
        q = joint_orientation(skeleton, state, instance, body)
        rate += wp.quat_rotate_inv(q, row.axis_b) * state.speeds[instance, first + 1]
    return rate


@wp.func
def of_head(kind: int, instance: int, state: State, around: Surroundings) -> wp.vec3:
    """The vertical, or the angular velocity of the head, rad/s, in axes of the head."""
    moving = state
    value = wp.vec3(0.0)
    body = around.head
    turned = wp.quat(0.0, 0.0, 0.0, 1.0)  # the head in the body that the loop has come to
    while body > 0:
        if kind == HEAD_ANGULAR_VELOCITY:
            value += wp.quat_rotate_inv(turned, joint_rate(around.skeleton, instance, body, moving))
        turned = joint_orientation(around.skeleton, moving, instance, body) * turned
        body = around.skeleton.plan[body].parent
    q = root_orientation(around.root, instance, state) * turned
    if kind == HEAD_UP:
        return up_in_trunk(q)
    return value + wp.quat_rotate_inv(q, root_angular_velocity(around.root, instance, state))


@wp.func
def course(index: int, instance: int, q: wp.quat, episodes: Episodes) -> float:
    """Where the wanted way is: sine and cosine of the turn towards it, and how far it is to the right, m, at most 1."""
    if index == 2:
        return wp.clamp(episodes.side[instance], -1.0, 1.0)
    turn = episodes.heading[instance] - heading_angle(q)
    return wp.where(index == 0, wp.sin(turn), wp.cos(turn))


@wp.func
def seen_goal(first: int, axis: int, instance: int, state: State, around: Surroundings) -> float:
    """A goal that is a point, whose first number is this one, from the root and as that faces, m."""
    point = wp.vec3(around.goal[instance, first], around.goal[instance, first + 1], around.goal[instance, first + 2])
    facing = heading(root_orientation(around.root, instance, state))
    return wp.quat_rotate_inv(facing, point - root_place(around.root, instance, state))[axis]


@wp.func
def ground_at(x: float, z: float, instance: int, around: Surroundings) -> float:
    """Height y of the ground at a place of the world, m."""
    n = at(around.normal, instance, 0)
    level = (at(around.ground, instance, 0) - n[0] * x - n[2] * z) / n[1]
    if around.terrain.tile.shape[0] > 0:
        level += tile_rise(x, z, at(around.terrain.place, instance, 0), around.terrain)[0]
    return level


@wp.func
def ground_about(k: int, instance: int, state: State, around: Surroundings) -> float:
    """How much higher the ground is at one of the places about the root, as that faces, than below it, m."""
    place = root_place(around.root, instance, state)
    across = wp.static(GROUND_STEP) * (float(k % wp.static(GROUND_COLUMNS)) - wp.static(0.5 * (GROUND_COLUMNS - 1)))
    along = wp.static(GROUND_STEP) * float(k // wp.static(GROUND_COLUMNS) + wp.static(1 - GROUND_BEHIND))
    way = wp.quat_rotate(heading(root_orientation(around.root, instance, state)), wp.vec3(across, 0.0, along))
    here = ground_at(place[0], place[2], instance, around)
    return ground_at(place[0] + way[0], place[2] + way[2], instance, around) - here


@wp.func
def along_way(across: float, along: float, instance: int, state: State, around: Surroundings) -> float:
    """Height y of the ground at a place to the left of the root and ahead of it, m, as that faces."""
    place = root_place(around.root, instance, state)
    way = wp.quat_rotate(heading(root_orientation(around.root, instance, state)), wp.vec3(across, 0.0, along))
    return ground_at(place[0] + way[0], place[2] + way[2], instance, around)


@wp.func
def footing(k: int, instance: int, state: State, around: Surroundings) -> float:
    """How much higher a strip of ground on the way of a foot is in the mean than the ground below the root, m."""
    side = float(k % wp.static(FOOTING_SIDES)) - 0.5
    first = wp.static(FOOTING_LENGTH) * (float(k // wp.static(FOOTING_SIDES) - wp.static(FOOTING_BEHIND)) - 0.5)
    total = wp.float32(0.0)
    for sample in range(wp.static(FOOTING_SAMPLES)):
        along = first + wp.static(FOOTING_LENGTH / FOOTING_SAMPLES) * (float(sample) + 0.5)
        total += along_way(wp.static(2.0 * FOOTING_ASIDE) * side, along, instance, state, around)
    return total / wp.static(float(FOOTING_SAMPLES)) - along_way(0.0, 0.0, instance, state, around)


@wp.func
def steepest_piece(instance: int, state: State, around: Surroundings) -> float:
    """Greatest rise or fall, m, within 10 cm of the way, from 0.3 m behind the root to 0.6 m ahead."""
    found = wp.float32(0.0)
    before = along_way(0.0, wp.static(UNEVEN_STEP * UNEVEN_FIRST), instance, state, around)
    for piece in range(wp.static(UNEVEN_COUNT)):
        along = wp.static(UNEVEN_STEP) * float(piece + wp.static(UNEVEN_FIRST + 1))
        here = along_way(0.0, along, instance, state, around)
        found = wp.max(found, wp.abs(here - before))
        before = here
    return found


@wp.func
def of_root(kind: int, k: int, instance: int, state: State, episodes: Episodes, around: Surroundings) -> float:
    """What is felt of the root: its height, turn and speeds, forces at the feet as it faces, and its course."""
    q = root_orientation(around.root, instance, state)
    if kind == HEIGHT:
        place = root_place(around.root, instance, state)
        height = wp.dot(at(around.normal, instance, 0), place) - at(around.ground, instance, 0)
        if around.terrain.tile.shape[0] > 0:
            rise = tile_rise(place[0], place[2], at(around.terrain.place, instance, 0), around.terrain)
            height -= at(around.normal, instance, 0)[1] * rise[0]
        return height
    if kind == UP:
        return up_in_trunk(q)[k]
    if kind == VELOCITY:
        return wp.quat_rotate_inv(heading(q), root_velocity(around.root, instance, state))[k]
    if kind == ANGULAR_VELOCITY:
        return wp.quat_rotate_inv(q, root_angular_velocity(around.root, instance, state))[k]
    if kind == FOOT_FORCE:
        force = wp.quat_rotate_inv(heading(q), state.foot_force[instance, k / 3])
        return force[k % 3] / around.body_weight
    if kind == COURSE:
        return course(k, instance, q, episodes)
    return 0.0


@wp.func
def later_by(feature: Feature, instance: int, episodes: Episodes) -> int:
    """How many decisions later than usual a feature comes: one number in an episode for all that are late alike."""
    if feature.late == 0:
        return 0
    generator = random_of(episodes.seed[0], instance, episodes.number[instance], DELAY)
    latest = share_of(feature.late_grows, episodes.hardness[instance]) * float(feature.late)
    return wp.min(int(wp.randf(generator) * (latest + 1.0)), feature.late)


@wp.func
def noisier_by(feature: Feature, instance: int, episodes: Episodes) -> float:
    """Deviation of noise that comes to that of a feature: one number in an episode for all that are noisier alike."""
    if feature.noisier == 0.0:
        return 0.0
    generator = random_of(episodes.seed[0], instance, episodes.number[instance], NOISINESS)
    share = share_of(feature.noisier_grows, episodes.hardness[instance])
    return wp.randf(generator) * feature.noisier * share


@wp.func
def feature_value(feature: Feature, instance: int, state: State, episodes: Episodes, around: Surroundings) -> float:
    """A feature now."""
    kind = feature.kind
    k = feature.index
    value = wp.float32(0.0)
    if kind == COORDINATE:
        value = state.coordinates[instance, k]
    elif kind == JOINT_SPEED:
        value = state.speeds[instance, k]
    elif kind == ACTIVATION:
        value = state.muscles.activation[instance, k]
    elif kind == FIBRE_LENGTH:
        value = state.muscles.sensed[instance, k][0] - 1.0
    elif kind == FIBRE_VELOCITY:
        value = state.muscles.sensed[instance, k][1]
    elif kind == FIBRE_FORCE:
        value = state.muscles.sensed[instance, k][2]
    elif kind == ACTION:
        value = wp.clamp(around.action[instance, k], around.least_action, around.greatest_action)
    elif kind == COMMAND:
        value = episodes.command[instance, k]
    elif kind == PHASE:
        value = state.simbicon.phase[instance]
    elif kind == STANCE:
        value = float(state.simbicon.stance[instance])
    elif kind == PUSH_FORCE:
        step = state.step[instance]
        if step >= state.push_steps[instance, 0] and step < state.push_steps[instance, 1]:
            value = state.push[instance][k] / around.body_weight
    elif kind == VARIED:
        value = around.varied[episodes.variant[instance], k]
    elif kind == CLOCK:
        angle = wp.static(2.0 * wp.PI) * episodes.phase[instance]
        value = wp.where(k == 0, wp.sin(angle), wp.cos(angle))
    elif kind == CUSTOM:
        value = around.custom[instance, k]
    elif kind == GOAL:
        value = around.goal[instance, k]
    elif kind == GOAL_POINT:
        value = seen_goal(k // 3, k % 3, instance, state, around)
    elif kind == GROUND:
        value = ground_about(k, instance, state, around)
    elif kind == FOOTING:
        value = footing(k, instance, state, around)
    elif kind == LATER:
        value = float(later_by(feature, instance, episodes))
    elif kind == NOISIER:
        value = noisier_by(feature, instance, episodes)
    elif kind >= HEAD_UP:
        value = of_head(kind, instance, state, around)[k]
    else:
        value = of_root(kind, k, instance, state, episodes, around)
    value = value * feature.scale
    if not (wp.abs(value) < wp.static(1.0e30)):
        return 0.0
    return wp.clamp(value, -GREATEST, GREATEST)


def check_kinds(source: str) -> None:
    """TypeError if nothing gives a value to a kind of feature, by the text of this file."""
    if found := re.search(r"# Kinds of features\.\n\((.*?)\) = range", source, re.DOTALL):
        given = set(re.findall(r"\bkind == (\w+)", source))
        if missing := [name for name in re.findall(r"\w+", found[1]) if name not in given]:
            raise TypeError(f"the feature {missing[0]} of learning/senses.py in kernels has no value in feature_value")


check_kinds(inspect.getsource(sys.modules[__name__]))


@wp.kernel
def sample(
    # in
    features: wp.array[Feature], chosen: wp.array[int], state: State, episodes: Episodes, around: Surroundings,
    # out
    ring: wp.array3d[float],
):  # fmt: skip
    """Put chosen features into the ring, (instances, decisions, features). Launch with dim = (instances, chosen)."""
    i, c = wp.tid()
    number = chosen[c]
    slot = episodes.decision[i] % ring.shape[1]
    ring[i, slot, number] = feature_value(features[number], i, state, episodes, around)


@wp.kernel
def sample_first(
    # in
    features: wp.array[Feature], state: State, episodes: Episodes, around: Surroundings,
    # out
    ring: wp.array3d[float],
):  # fmt: skip
    """Fill the ring of episodes that begin: it was ever so. Launch with dim = (instances, features)."""
    i, number = wp.tid()
    if not episodes.mask[i]:
        return
    value = feature_value(features[number], i, state, episodes, around)
    for slot in range(ring.shape[1]):
        ring[i, slot, number] = value


@wp.kernel
def observe(
    # in
    features: wp.array[Feature], ring: wp.array3d[float], episodes: Episodes,
    # out
    observation: wp.array2d[float],
):  # fmt: skip
    """What the policy is told: features as they were, with noise. Launch with dim = (instances, features)."""
    i, number = wp.tid()
    feature = features[number]
    decision = episodes.decision[i]
    slots = ring.shape[1]
    delay = feature.delay + later_by(feature, i, episodes)
    value = ring[i, (decision + slots - delay) % slots, number]
    noise = feature.noise
    if feature.noisier > 0.0:
        more = noisier_by(feature, i, episodes)
        noise = wp.sqrt(noise * noise + more * more)
    if noise > 0.0:
        generator = random_of(episodes.seed[0], i, decision, NOISE + 16 * (1 + number))
        value += noise * wp.randn(generator)
    observation[i, number] = value


@wp.kernel
def observe_now(
    # in
    features: wp.array[Feature], state: State, episodes: Episodes, around: Surroundings,
    # out
    observation: wp.array2d[float],
):  # fmt: skip
    """Features as they are, which only a critic may know. Launch with dim = (instances, features)."""
    i, number = wp.tid()
    observation[i, number] = feature_value(features[number], i, state, episodes, around)
