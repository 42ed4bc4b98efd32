"""A custom controller: it holds a joint at an angle, and learns what gravity asks for."""

import warp as wp

from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.structs import Model, Scratch, State

ANGLE = wp.constant(7)  # place of the joint's coordinate; the first seven are the root's


@wp.struct
class Gains:
    target: float  # rad
    kp: float  # N m/rad
    kd: float  # N m s/rad
    ki: float  # N m/(rad s)


@wp.func
def update(instance: int, model: Model, state: State, work: Scratch, gains: Gains, memory: wp.array[float]):
    """Add up the error, once a step and before the efforts of the joints."""
    memory[0] = memory[0] + model.time_step * (gains.target - state.coordinates[instance, ANGLE])


@wp.func
def effort(
    instance: int, body: int, model: Model, state: State, work: Scratch, gains: Gains, memory: wp.array[float]
) -> wp.vec3:
    """Torque, N m, about each axis of the joint that carries the body."""
    error = gains.target - state.coordinates[instance, ANGLE]
    return wp.vec3(gains.kp * error - gains.kd * state.speeds[instance, 0] + gains.ki * memory[0], 0.0, 0.0)


hold = CustomController(effort=effort, update=update, parameters=Gains, state=1)  # one number of memory
