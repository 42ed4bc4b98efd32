"""What parts of a task may know of a policy's decision besides the body: what is wanted, and what was done."""

import warp as wp

from warpmuscle.kernels.functions import func


@wp.struct
class Decision:
    """What an instance is told, what it does, and where it is in its episode."""

    goal: wp.array2d[float]  # (instances, numbers) of goals, one behind the other; points in world axes, m
    command: wp.array2d[float]  # (instances, commands) m/s, rad/s, then wanted coordinates
    action: wp.array2d[float]  # (instances, actions) of this decision
    previous_action: wp.array2d[float]  # (instances, actions) of the one before
    length: wp.array[int]  # (instances,) decisions in this episode
    difficulty: wp.array[float]  # (instances,) 0 to 1, of the curriculum; 0 where there is none
    failed: wp.array[bool]  # (instances,) whether the episode that ended last ended by failing
    reached: wp.array[bool]  # (instances,) whether it ended as an end that is earned
    time: float  # s, that a decision lasts


@func
def goal_point(instance: int, first: int, decision: Decision) -> wp.vec3:
    """A goal that is a point, world, m, whose first number is this one."""
    return wp.vec3(
        decision.goal[instance, first], decision.goal[instance, first + 1], decision.goal[instance, first + 2]
    )
