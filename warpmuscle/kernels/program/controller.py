"""The controller by quadratic programmes, as a step has it: what was found at the last decision acts until the next.

Its numbers are those of tasks: accelerations x'' = kp (target - x) - kd x' that are wanted of joints, of points and the
orientation of bodies, and of the centre of mass, each with a weight. Targets are where all of these are at the start of
an instance, and what `move` and `target` add to that. They are added up in `tasks.py`, and
`gather.py` says what can be done for them.
"""

import warp as wp

from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@wp.struct
class ProgramParameters:
    """Of the whole."""

    rate: float  # Hz, of decisions
    effort: float  # cost of an activation squared
    torque_effort: float  # cost of a torque squared, over its bound
    contact_effort: float  # cost of a force along an edge squared, over body weight
    friction: float  # of the cones
    contact_weight: float  # of points on the ground, that are to rest
    contact_damping: float  # 1/s, of their velocity
    support: float  # body weights along an edge, with which a fixed object bears a shape at most
    com_weight: float
    com_kp: float  # 1/s^2
    com_kd: float  # 1/s
    com_x: float  # m, that are added to where the centre of mass is at the start
    com_y: float
    com_z: float
    step_time: float  # s, of a step; 0: both feet stay where they are
    speed: float  # m/s, forwards, of a body that steps
    acceleration: float  # m/s^2, by which the speed that is followed changes at most
    double_support: float  # share of a step in which both feet bear
    step_height: float  # m, by which a foot is lifted
    step_width: float  # m, between the middles of the soles
    step_weight: float  # of the sole that swings
    step_kp: float  # 1/s^2
    step_kd: float  # 1/s
    sway: float  # by which the centre of pressure goes further than the extrapolated centre of mass is off


@wp.struct
class JointTask:
    """Of a joint."""

    weight: float
    kp: float  # 1/s^2
    kd: float  # 1/s
    move: float  # rad or m, that is added to its first coordinate at the start; not of balls
    torque: float  # N m, bound of torques about each of its axes, if they drive it


@wp.struct
class BodyTask:
    """Of a point and of the orientation of a body."""

    weight: float  # of the point
    kp: float  # 1/s^2
    kd: float  # 1/s
    point_x: float  # m, from the joint, body axes
    point_y: float
    point_z: float
    move_x: float  # m, that is added to where the point is at the start, world
    move_y: float
    move_z: float
    turn_weight: float  # of the orientation, which is to be that at the start
    turn_kp: float  # 1/s^2
    turn_kd: float  # 1/s


REPORTED = 3  # floats at the front of the memory: see `quadratic_program.recorded`
BODY_FLOATS = 8  # of the memory, of each body: 1 once it is known, position and orientation at the start


@func
def program_excitation(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> float:
    """Excitation of a muscle that was found at the last decision."""
    return memory[REPORTED + muscle]


@func
def program_effort(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> wp.vec3:
    """Efforts of a joint that were found at the last decision."""
    first = model.skeleton.plan[body].speed_start
    effort = wp.vec3(0.0)
    for k in range(model.skeleton.plan[body].speed_end - first):
        effort[k] = memory[REPORTED + model.muscles.count + first + k]
    return effort


quadratic_program = CustomController(
    effort=program_effort,
    excitation=program_excitation,
    parameters=ProgramParameters,
    by_joint=JointTask,
    by_body=BodyTask,
    recorded=(("unmet", "m/s2"), ("iterations", "1"), ("load", "N")),
    state=REPORTED,
    defaults=(
        ("rate", 200.0), ("effort", 1.0), ("torque_effort", 1.0), ("contact_effort", 0.01), ("friction", 0.6),
        ("contact_weight", 100.0), ("contact_damping", 20.0), ("support", 1.0),
        ("com_weight", 0.0), ("com_kp", 100.0), ("com_kd", 20.0),
        ("com_x", 0.0), ("com_y", 0.0), ("com_z", 0.0),
        ("step_time", 0.0), ("speed", 0.0), ("acceleration", 0.5), ("double_support", 0.2), ("step_height", 0.05),
        ("step_width", 0.16), ("step_weight", 100.0), ("step_kp", 300.0), ("step_kd", 30.0), ("sway", 1.0),
        ("weight", 0.0), ("kp", 100.0), ("kd", 20.0), ("move", 0.0), ("torque", 0.0),
        ("point_x", 0.0), ("point_y", 0.0), ("point_z", 0.0), ("move_x", 0.0), ("move_y", 0.0), ("move_z", 0.0),
        ("turn_weight", 0.0), ("turn_kp", 100.0), ("turn_kd", 20.0),
    ),
    description="activations, torques and contact forces of least effort for wanted accelerations",
)  # fmt: skip
