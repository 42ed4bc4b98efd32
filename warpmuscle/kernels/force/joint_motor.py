"""A motor between two bodies that holds one of them upright in the world, as a trunk on a pelvis."""

import warp as wp

from warpmuscle.kernels.control.gait_sensors import rotation_vector, turn_angles
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@wp.struct
class JointMotor:
    """What a motor does about three axes: the lean is backwards, the list to the right, the turn to the left.

    Those of lean, list and turn are of the second body in the world, the others of it on the first body.
    """

    stiffness: float  # N m/rad, to where both bodies are turned alike
    damping: float  # N m s/rad
    most: float  # N m, that it gives
    lean_gain: float  # N m/rad
    lean_target: float  # rad
    lean_damping: float  # N m s/rad
    list_gain: float
    list_target: float
    list_damping: float
    turn_gain: float
    turn_target: float
    turn_damping: float


@func
def joint_motor_torque(turned: wp.vec3, spin: wp.vec3, bent: wp.vec3, rate: wp.vec3, motor: JointMotor) -> wp.vec3:
    """Torque on the second body in the axes of the first one, N m: Hyfydy's joint_motor, driven by SCONE's reflexes.

    That is p (target - turned) - d spin - k bent - c rate, no longer than `most`. Our x is to the left: leaning
    backwards is a turn about -x, the list about z, and the turn about y.

    Args:
        turned: angles of the second body in the world, about y, x and z in this order, rad. spin: its angular
            velocity, in its axes.
        bent: rotation vector of the second body on the first one. rate: angular velocity of the one on the other.
    """
    gains = wp.vec3(motor.lean_gain, motor.turn_gain, motor.list_gain)
    damping = wp.vec3(motor.lean_damping, motor.turn_damping, motor.list_damping)
    target = wp.vec3(-motor.lean_target, motor.turn_target, motor.list_target)
    torque = wp.cw_mul(gains, target - turned) - wp.cw_mul(damping, spin)
    torque -= motor.stiffness * bent + motor.damping * rate
    size = wp.length(torque)
    if size > motor.most:
        torque = torque * (motor.most / size)
    return torque


@func
def joint_motor(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    motor: JointMotor,
) -> Wrench:  # fmt: skip
    """What the motor does to one of its bodies, of which `second` says whether it is the second one."""
    one = wp.where(second == 1, other, body)
    two = wp.where(second == 1, body, other)
    q = work.orientation[two]
    spin = work.angular_velocity[two]
    from_first = wp.transpose(work.rotation[one])
    bent = rotation_vector(wp.quat_inverse(work.orientation[one]) * q)
    rate = from_first * (spin - work.angular_velocity[one])
    torque = joint_motor_torque(turn_angles(q), wp.transpose(work.rotation[two]) * spin, bent, rate, motor)
    w = Wrench()
    w.moment = work.rotation[one] * torque * wp.where(second == 1, 1.0, -1.0)
    return w
