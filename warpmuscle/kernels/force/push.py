"""A force on a body that comes for a while, once or again and again: what pushes, or pulls, in a laboratory."""

import warp as wp

from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.force.loads import time_since
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@wp.struct
class Push:
    """When it comes, and what it is then."""

    start: float  # s, of the first
    duration: float  # s, of each
    interval: float  # s, from the start of one to that of the next; 0: there is one alone
    end: float  # s, from which on none starts; 0: they go on
    force_x: float  # N, world
    force_y: float
    force_z: float
    moment_x: float  # N m, world
    moment_y: float
    moment_z: float
    place_x: float  # m, where the force acts, from the body's centre of mass in its axes
    place_y: float
    place_z: float


@func
def pushes(since: float, row: Push) -> bool:
    """Whether there is a push so long after the first one started, s."""
    if since < 0.0:
        return False
    begun = wp.float32(0.0)
    if row.interval > 0.0:
        begun = row.interval * wp.floor(since / row.interval)
        if row.end > 0.0 and row.start + begun >= row.end:
            begun = row.interval * (wp.ceil((row.end - row.start) / row.interval) - 1.0)
    return since - begun < row.duration and (row.end <= 0.0 or row.start < row.end)


@func
def push(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, row: Push) -> Wrench:
    """The force and the moment while there is a push, the same over each step."""
    w = Wrench()
    if pushes(time_since(instance, row.start, model, state), row):
        w.force = wp.vec3(row.force_x, row.force_y, row.force_z)
        arm = work.rotation[body] * wp.vec3(row.place_x, row.place_y, row.place_z)
        w.moment = wp.vec3(row.moment_x, row.moment_y, row.moment_z) + wp.cross(arm, w.force)
    return w
