"""A task of one's own: the hand learns to come to a point, and to be gentle on the way."""

import warp as wp

from warpmuscle.kernels.learning.decision import Decision, goal_point
from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State

FOREARM = wp.constant(2)  # the root is 0, and bodies follow their parents
SHOULDER = wp.constant(7)  # place of its angle; the first seven are the root's


@wp.struct
class Width:
    width: float  # m


@wp.func
def hand(work: Scratch) -> wp.vec3:
    """Where the hand is, world, m: 0.36 m along the forearm from the elbow."""
    return work.position[FOREARM] + work.rotation[FOREARM] * wp.vec3(0.0, -0.36, 0.0)


@wp.func
def to_goal(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> wp.vec3:
    """What the arm observes: the way from the hand to the first goal, m."""
    return goal_point(instance, 0, decision) - hand(work)


@wp.func
def _near(instance: int, model: Model, state: State, work: Scratch, decision: Decision, own: Width) -> float:
    away = wp.length(to_goal(instance, model, state, work, decision)) / own.width
    return wp.exp(-away * away)


@wp.func
def _jerk(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    """Squared change of the forearm's acceleration from step to step, which a memory of three floats keeps."""
    now = centre_acceleration(instance, FOREARM, model, work)
    change = wp.vec3(0.0)
    if state.step[instance] > 0:
        change = (now - wp.vec3(memory[0], memory[1], memory[2])) / model.time_step
    for k in range(3):
        memory[k] = now[k]
    return wp.length_sq(change)


@wp.func
def _speed_of_hand(instance: int, model: Model, state: State, work: Scratch) -> float:
    """What recordings have: m/s."""
    return wp.length(
        work.velocity[FOREARM] + wp.cross(work.angular_velocity[FOREARM], hand(work) - work.position[FOREARM])
    )


@wp.func
def _arrived(instance: int, model: Model, state: State, work: Scratch, decision: Decision, own: Width) -> bool:
    return wp.length(to_goal(instance, model, state, work, decision)) < own.width


@wp.func
def _further(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> float:
    """How hard the next episode is: harder after one that arrived, easier after one that did not."""
    return decision.difficulty[instance] + wp.where(decision.reached[instance], 0.1, -0.05)


@wp.func
def _somewhere(
    instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32
) -> wp.vec3:
    """A point that the hand can come to; the harder, the further it is from where the arm hangs."""
    lift = decision.difficulty[instance] * wp.randf(random, 0.2, 2.0)
    bend = 0.4 + decision.difficulty[instance] * wp.randf(random)
    elbow = wp.vec3(-0.2, 1.44 - 0.3 * wp.cos(lift), 0.3 * wp.sin(lift))
    return elbow + 0.36 * wp.vec3(0.0, -wp.cos(lift + bend), wp.sin(lift + bend))


@wp.func
def _lifted(instance: int, model: Model, state: State, work: Scratch, decision: Decision, random: wp.uint32):
    state.coordinates[instance, SHOULDER] = wp.randf(random, 0.0, 0.5)


near = Declaration(function=_near, parameters=Width, stage="decision", sign="earned", unit="1/s")
gentle = Declaration(function=_jerk, memory=3, stage="accelerations", unit="m^2/s^5", description="squared jerk")
arrived = Declaration(function=_arrived, parameters=Width, stage="decision", sign="earned", defaults={"width": 0.02})
further = Declaration(function=_further, stage="decision")
somewhere = Declaration(function=_somewhere, stage="decision")
lifted = Declaration(function=_lifted, stage="decision")
speed_of_hand = Declaration(function=_speed_of_hand, unit="m/s")
