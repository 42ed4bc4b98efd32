"""A term with parameters and a memory, which sees accelerations."""

import warp as wp

from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Smoothing:
    time: float  # s


@wp.func
def _smooth(instance: int, model: Model, state: State, work: Scratch, own: Smoothing, memory: wp.array[float]) -> float:
    """Squared vertical acceleration of the head, smoothed over a time, which a step adds up."""
    now = centre_acceleration(instance, model.head, model, work)[1]
    share = model.time_step / (own.time + model.time_step)
    memory[0] = memory[0] + share * (now - memory[0])
    return memory[0] * memory[0]


smooth = Declaration(
    function=_smooth,
    parameters=Smoothing,
    memory=1,
    stage="accelerations",
    unit="m^2/s^3",
    description="squared vertical acceleration of the head, smoothed",
    limits={"time": (0.0, 1.0)},
)
