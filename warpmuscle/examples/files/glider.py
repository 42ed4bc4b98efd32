"""A custom force on a body."""

import warp as wp

from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Lift:
    force: float  # N, upwards


@wp.func
def pull(instance: int, body: int, model: Model, state: State, work: Scratch, lift: Lift) -> Wrench:
    """A steady pull upwards at the body's centre of mass."""
    w = Wrench()
    w.force = wp.vec3(0.0, lift.force, 0.0)
    return w


glider = ForceKind(wrench=pull, parameters=Lift)
