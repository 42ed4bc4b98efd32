"""What rewards are made of on the device: rules, weights, and the gait that is imitated."""

import warp as wp

from warpmuscle.kernels.learning.senses import Surroundings
from warpmuscle.kernels.objective.objective_terms import REWARDS, SIZES

TERMS = tuple(REWARDS)  # in the order in which they are logged
COUNT = len(TERMS)
NUMBERS = COUNT + len(SIZES)  # that a training may change

term_values = wp.types.vector(length=COUNT, dtype=float)


@wp.struct
class GaitTable:
    """A gait over one cycle, which is imitated, at some wanted speeds."""

    coordinate: wp.array2d[float]  # (speeds * bins, coordinates), bins of the first speed first
    up: wp.array[wp.vec3]  # (bins,) the vertical in axes of the trunk
    first: wp.array[int]  # (joints,) coordinate of each
    end: wp.array[int]
    weight: wp.array[float]  # (joints,), which adds up to 1 with `up_weight`
    up_weight: float
    force: wp.array2d[float]  # (speeds, bins) people's vertical force on the left foot, body weights
    right: float  # part of the cycle after which the right foot touches down
    speeds: int
    first_speed: float  # m/s
    speed_step: float  # m/s, from one speed to the next


@wp.struct
class RewardRules:
    """What is rewarded."""

    weight: term_values  # signed, the greatest that a training comes to; 0: the term never counts
    now: wp.array[float]  # (NUMBERS,) signed weights as they are, of what counts for time times that; then the SIZES
    costs: wp.array[float]  # (1,) share of what is taken off
    pose: wp.array[int]  # numbers of the wanted coordinates
    gait: GaitTable
    force_share: float  # of the present force in the smoothed one
    speed_share: float  # of the present speed in the smoothed one
    total_mass: wp.array2d[float]  # (rows, 1) kg
    gravity: wp.array2d[float]  # (rows, 1) m/s^2
    longest: int  # decisions of an episode
    uneven: float  # m, see `Imitation.uneven`; 0: a gait counts on all ground
    around: Surroundings  # whose ground is asked
    effort: int  # what is mean-squared: EXCITATIONS, ACTIVATIONS or ACTIONS


@wp.struct
class ObjectiveWeights:
    """Weights of the sums that a batch makes for the terms of the scene's objective, times the time step."""

    torque: wp.float64
    muscle: wp.array[wp.float64]
    body: wp.array[wp.float64]
    instance: wp.array[wp.float64]
    basal: wp.float64  # weight of the energy at rest, per step
    energy: int  # which sum over muscles is metabolic energy; -1: none
    transport: wp.float64  # weight of the cost of transport
    mass: wp.float64  # kg
    basal_power: wp.float64  # W
    time_step: wp.float64  # s


@wp.struct
class Gains:
    """What instances have gained."""

    action: wp.array2d[float]
    previous: wp.array2d[float]  # (instances, actions) the action before
    excitation: wp.array2d[float]  # (instances, muscles), where actions give it
    foot_force: wp.array2d[float]  # (instances, feet) smoothed vertical force, body weights, or UNKNOWN
    speed: wp.array[float]  # (instances,) smoothed, along the wanted heading, m/s, or NO_SPEED
    objective: wp.array[wp.float64]  # (instances,) what the episode has added to the scene's objective
    sums: wp.array2d[float]  # (instances, LOGGED) of the episode
    finished: wp.array2d[float]  # (instances, LOGGED) of the last one that ended
    custom: wp.array2d[float]  # (instances, rewards) values of rewards of the scene's own in this decision
    custom_weight: wp.array[float]  # (rewards,) signed; of what counts for time times that
    custom_speed: wp.array[float]  # (rewards,) m/s, wanted, at which it counts in full
    custom_width: wp.array[float]  # (rewards,) m/s; 0: it counts at every speed
    custom_sums: wp.array2d[float]  # (instances, rewards) what they were worth in the episode
    custom_finished: wp.array2d[float]  # (instances, rewards) in the last one that ended
    custom_end: wp.array2d[float]  # (instances, ends) 1: it is met; no instances without ends of the scene's own
    end_fails: wp.array[int]  # (ends,) 1: who meets it has failed
    reward: wp.array[float]
    terminated: wp.array[bool]
    truncated: wp.array[bool]
    reached: wp.array[bool]  # (instances,) ended as an end that is earned; none without ends of the scene's own
