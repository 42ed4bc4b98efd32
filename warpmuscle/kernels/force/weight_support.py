"""A harness that carries part of the weight, as over a treadmill."""

import warp as wp

from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@wp.struct
class WeightSupport:
    """How much a harness carries."""

    share: float  # of the weight of the whole character


@func
def weight_support(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, support: WeightSupport
) -> Wrench:
    """A constant force upwards at the body's centre of mass."""
    w = Wrench()
    w.force = wp.vec3(0.0, support.share * body_weight(instance, model), 0.0)
    return w
