"""A custom controller: every joint has an angle and gains of its own, and the memory how far joints were off."""

import warp as wp

from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.control.joint_values import joint_coordinate, joint_speed, joint_speeds
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Gains:
    angle: float  # rad
    kp: float  # N m/rad
    kd: float  # N m s/rad


@wp.func
def update(instance: int, model: Model, state: State, work: Scratch, joints: wp.array[Gains], memory: wp.array[float]):
    """Add up the squared errors of all joints that turn about one axis."""
    for body in range(1, model.body_count):
        if joint_speeds(body, model) == 1:
            error = joints[body].angle - joint_coordinate(instance, body, 0, model, state)
            memory[0] = memory[0] + model.time_step * error * error


@wp.func
def effort(instance: int, body: int, model: Model, state: State, work: Scratch, own: Gains) -> wp.vec3:
    """Torque, N m, about the axis of the joint that carries the body."""
    error = own.angle - joint_coordinate(instance, body, 0, model, state)
    return wp.vec3(own.kp * error - own.kd * joint_speed(instance, body, 0, model, state), 0.0, 0.0)


steady = CustomController(
    effort=effort, update=update, by_joint=Gains, state=1, recorded=(("squared_error", "rad^2 s"),)
)
