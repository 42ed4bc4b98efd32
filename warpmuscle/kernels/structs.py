"""What a kernel is given: the model, the state of all instances, the working set of one instance, and what to record.

Bodies are numbered breadth first from the root (0), so that the bodies of one tree level, and the children of one
body, are neighbours; joint i - 1 connects body i to its parent. Arrays of model numbers are (rows, ...) with rows = 1
where all instances share them, or one row an instance; `at` reads both. What bodies, controller and muscles are made of
stands in `body_structs.py`, `control_structs.py` and `muscle_structs.py`.
"""

from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.body_structs import Belts as Belts
from warpmuscle.kernels.body_structs import BodyPlan as BodyPlan
from warpmuscle.kernels.body_structs import BodyRow as BodyRow
from warpmuscle.kernels.body_structs import Collisions as Collisions
from warpmuscle.kernels.body_structs import ConstraintPlan as ConstraintPlan
from warpmuscle.kernels.body_structs import ConstraintRow as ConstraintRow
from warpmuscle.kernels.body_structs import Constraints as Constraints
from warpmuscle.kernels.body_structs import ContactMaterial as ContactMaterial
from warpmuscle.kernels.body_structs import ContactPoint as ContactPoint
from warpmuscle.kernels.body_structs import Contacts as Contacts
from warpmuscle.kernels.body_structs import Coupling as Coupling
from warpmuscle.kernels.body_structs import CouplingFunction as CouplingFunction
from warpmuscle.kernels.body_structs import Couplings as Couplings
from warpmuscle.kernels.body_structs import CubicPiece as CubicPiece
from warpmuscle.kernels.body_structs import Feet as Feet
from warpmuscle.kernels.body_structs import Ground as Ground
from warpmuscle.kernels.body_structs import LimitRow as LimitRow
from warpmuscle.kernels.body_structs import Skeleton as Skeleton
from warpmuscle.kernels.body_structs import SoftConstraint as SoftConstraint
from warpmuscle.kernels.control_structs import ComponentPlan as ComponentPlan
from warpmuscle.kernels.control_structs import ComponentRow as ComponentRow
from warpmuscle.kernels.control_structs import ControlState as ControlState
from warpmuscle.kernels.control_structs import Gains as Gains
from warpmuscle.kernels.control_structs import HipControl as HipControl
from warpmuscle.kernels.control_structs import Knot as Knot
from warpmuscle.kernels.control_structs import Simbicon as Simbicon
from warpmuscle.kernels.control_structs import SimbiconRecord as SimbiconRecord
from warpmuscle.kernels.control_structs import SimbiconState as SimbiconState
from warpmuscle.kernels.control_structs import Trajectory as Trajectory
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.gait_state_structs import GaitMemory as GaitMemory
from warpmuscle.kernels.gait_state_structs import GaitStates as GaitStates
from warpmuscle.kernels.moved import of_former_names
from warpmuscle.kernels.muscle_structs import Contribution as Contribution
from warpmuscle.kernels.muscle_structs import Crossing as Crossing
from warpmuscle.kernels.muscle_structs import CurveRow as CurveRow
from warpmuscle.kernels.muscle_structs import MuscleRow as MuscleRow
from warpmuscle.kernels.muscle_structs import Muscles as Muscles
from warpmuscle.kernels.muscle_structs import MuscleState as MuscleState
from warpmuscle.kernels.muscle_structs import Paths as Paths
from warpmuscle.kernels.muscle_structs import PathsApart as PathsApart
from warpmuscle.kernels.muscle_structs import PathSpan as PathSpan
from warpmuscle.kernels.muscle_structs import Pulley as Pulley
from warpmuscle.kernels.muscle_structs import Segment as Segment
from warpmuscle.kernels.muscle_structs import SegmentEnds as SegmentEnds
from warpmuscle.kernels.muscle_structs import SharedMuscle as SharedMuscle
from warpmuscle.kernels.muscle_structs import SharingState as SharingState
from warpmuscle.kernels.muscle_structs import Straight as Straight
from warpmuscle.kernels.muscle_structs import TimedExcitation as TimedExcitation
from warpmuscle.kernels.muscle_structs import TorquePart as TorquePart
from warpmuscle.kernels.reflex_structs import Reflexes as Reflexes
from warpmuscle.kernels.route_structs import Lever as Lever
from warpmuscle.kernels.route_structs import Monomial as Monomial
from warpmuscle.kernels.route_structs import PolynomialSpan as PolynomialSpan
from warpmuscle.kernels.route_structs import PolynomialTerm as PolynomialTerm
from warpmuscle.kernels.route_structs import RouteMotion as RouteMotion
from warpmuscle.kernels.route_structs import RoutePoint as RoutePoint
from warpmuscle.kernels.route_structs import Routes as Routes
from warpmuscle.kernels.route_structs import RouteSpan as RouteSpan
from warpmuscle.kernels.route_structs import RouteWrap as RouteWrap
from warpmuscle.kernels.route_structs import Variable as Variable
from warpmuscle.kernels.route_structs import WrapRow as WrapRow
from warpmuscle.kernels.status import Status
from warpmuscle.kernels.terrain_structs import Patch as Patch
from warpmuscle.kernels.terrain_structs import Terrain as Terrain
from warpmuscle.kernels.terrain_structs import Tile as Tile
from warpmuscle.kernels.terrain_structs import TileBounds as TileBounds
from warpmuscle.kernels.terrain_structs import TilePlace as TilePlace

ROOT_FREE, ROOT_PLANAR, ROOT_FIXED = 0, 1, 2
BALL, UNIVERSAL, HINGE, FIXED = 1, 2, 3, 4
SECOND_HINGE, ROOT_PRESCRIBED = 5, 6  # what motion leaves of a universal joint whose first axis it has, and of a root
FIRST_COORDINATE_JOINT = 8  # and greater: types whose motion is a function of one coordinate, see `joint_motion.py`
FOLLOWER, DRIVING_HINGE = 8, 9  # a joint that follows another one's coordinate; a hinge that is followed
FIRST_OF_TABLE = 10  # and greater: types that the host's table names
FIRST_AXIS, SECOND_AXIS = 1, 2  # of a universal joint, prescribed
# In place of the width over which an activation's time constant changes: by these laws
BLENDED, EXCITED, EXCITED_RISE = -1.0, -2.0, -3.0
LEFT, RIGHT, REVERSE, SAME = 0, 1, 2, 3
RUNNING, COMPLETED, FELL, TURNED, TOUCHED, DIVERGED, CROSSED, COLLIDED, FAILED, STOPPED = map(int, Status)
BY_TORQUE, BY_MUSCLES, MIXED = 0, 1, 2  # what drives a joint
KEEP, DROP, CLIP = 0, 1, 2  # pushing contributions to a muscle's desired force
LARGEST = 1.0e30  # what no torque, force, length or term of a simulation exceeds; compared so that NaN does, too

polynomial = wp.types.vector(length=6, dtype=float)  # coefficients, the constant first


@wp.func_native(snippet="__builtin_assume(i >= 0); return i;")
def nonnegative(i: int) -> int: ...  # a number that is never negative, so that the compiler need not count from the end


@wp.func_native(
    snippet="""
int same = i;
#if defined(__CUDA_ARCH__)
asm volatile("" : "+r"(same));
#endif
return same;
"""
)
def recomputed(i: int) -> int: ...  # the number itself; the compiler keeps nothing for later that it computes from it


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
asm volatile(".pragma \\"nounroll\\";");
#endif
"""
)
def not_unrolled(): ...  # stands first in a loop that the compiler shall not unroll for the GPU


@wp.func_native(snippet="return (*wp::address(a, i))[axis];")
def component(a: wp.array[wp.vec3], i: int, axis: int) -> float: ...  # of vector i, fetched alone


@wp.func_native(snippet="(*wp::address(a, i))[axis] = value;")
def set_component(a: wp.array[wp.vec3], i: int, axis: int, value: float): ...


@func
def at(a: wp.array2d[Any], instance: int, i: int):
    """Element i of an instance in an array that has one row for all instances or one row an instance."""
    return a[nonnegative(wp.min(instance, a.shape[0] - 1)), nonnegative(i)]


@wp.struct
class Actuation:
    """What drives the joints; projectors are made of weights of a joint's degrees of freedom, 0 or 1."""

    drive: wp.array[int]  # (bodies,) BY_TORQUE, BY_MUSCLES or MIXED
    by_torque: wp.array[wp.vec3]  # (bodies,) weights of the controller's torque
    by_muscles: wp.array[wp.vec3]  # (bodies,) of the muscles' torque
    passive: wp.array[wp.vec3]  # (bodies,) of the spring-damper
    rest: wp.array2d[wp.quat]  # (rows, bodies) child in parent, where the spring is relaxed
    stiffness: wp.array2d[float]  # (rows, bodies) N m/rad
    damping: wp.array2d[float]  # (rows, bodies) N m s/rad
    effort: wp.array2d[float]  # (rows, speeds of joints) N m, see `control.py`; only kernels that take it read it


@wp.struct
class PrescribedMotion:
    """How the kinematic coordinates move; see `motion.py`. Only kernels that have it compiled in read it."""

    start: wp.array[float]  # (pieces,) s, where the pieces of the curves start
    curve: wp.array3d[polynomial]  # (rows, pieces, curves) over the time since the start of the piece
    row: wp.array[int]  # (instances,) which row of the curves an instance follows; none: its own, or the only one
    angle: wp.array2d[int]  # (angles, 3) coordinate, speed and curve of angles and positions
    turn: wp.array2d[int]  # (turns, 4) first coordinate, speed and curve of a quaternion; 1: speeds along world axes
    joint: wp.array2d[int]  # (joints, 2) body, and which axes of a hinge or universal joint
    remaining: wp.array[int]  # (bodies,) the joint types that the dynamics sees


@wp.struct
class FailureLimits:
    """Beyond which an instance has failed."""

    com_height: float  # lowest of the COM, over that at the start
    heading: float  # rad, largest turn
    max_speed: float  # m/s or rad/s, of joints and root
    leg_crossing: float  # m
    no_progress: float  # m/s, slowest mean speed; only kernels that have it compiled in read it and the next
    no_progress_window: float  # s, that it is the mean of


@wp.struct
class Aim:
    """What terms of the objective compare with."""

    target_speed: float  # m/s
    ground_force_bound: float  # of the vertical force on a foot, over body weight


@wp.struct
class Model:
    """Everything that stays the same during a simulation."""

    body_count: int
    level_count: int
    foot_slots: int
    implicit_pd: int
    time_step: float  # s
    gravity: wp.array2d[float]  # (rows, 1) m/s^2
    failure: wp.array2d[FailureLimits]  # (rows, 1)
    fastest: float  # m/s, of the COM; one for all, since fetching it in every step would cost a percent
    fail_on_body_contact: int
    head: int  # the body whose turning the objective may count
    heading: wp.array2d[float]  # (rows, 1) rad, that the body is to keep
    turns_from_start: int  # 1: failing by turning is from the heading at the start, not from that one
    objective: wp.array2d[Aim]  # (rows, 1)
    negative_share: float  # of the work that lengthening fibres take, how much metabolic powers give back, 0..1
    reference_bins: int  # of the phase, for each stance
    reference: wp.array2d[wp.quat]  # (2 bins, bodies) child in parent, of a tracked gait; left stance first
    reference_by_contact: int  # 1: the tracked gait is given from one contact of the left foot to the next
    reference_period: float  # s, of its cycles; 0: not known
    reference_begin: float  # 0..1, the part of its cycle that is nearest to the initial pose
    tracked: wp.array[float]  # (bodies,) 1: the body's joint is compared with it
    contact_rule: wp.vec3  # load of a foot on the ground over body weight, time to touch down s, time to lift off s
    norm_bins: int  # of the gait cycle
    norm: wp.array2d[float]  # (norm bins, bodies) sagittal angle of human legs in half-widths
    norm_scale: wp.array[float]  # (bodies,) half-widths/rad, signed; 0: no norm of the body's joint
    norm_side: wp.array[int]  # (bodies,) LEFT or RIGHT, the leg that the body's joint belongs to
    norm_moment: wp.array2d[float]  # (norm bins, bodies) sagittal moment of human legs per mass, standard deviations
    moment_scale: wp.array[float]  # (bodies,) standard deviations per N m/kg, signed; 0: no norm of the body's joint
    norm_force: wp.array[float]  # (norm bins,) vertical force on a human foot, body weights
    norm_force_band: float  # body weights, half-width of that
    level_start: wp.array[int]  # (levels + 1,)
    skeleton: Skeleton
    contacts: Contacts
    collisions: Collisions
    touch_interval: int  # steps between two looks at which bodies may touch
    feet: Feet
    simbicon: Simbicon
    actuation: Actuation
    muscles: Muscles
    paths: Paths
    motion: PrescribedMotion
    reflexes: Reflexes
    gait: GaitStates
    couplings: Couplings
    routes: Routes
    constraints: Constraints
    part_values: wp.array2d[float]  # (rows, values) parameters of parts of the scene's own, see `parts.py`


@wp.struct
class FootCycle:
    """Where a foot is in its gait cycle; see `gait_cycle.py`. All zero at the start."""

    since: float  # s, since the foot last touched down, before that since the start
    length: float  # s, of its last whole cycle; 0: there was none
    loaded: float  # s, for how long it has been loaded without a break
    away: float  # s, for how long it has not been loaded long enough to count
    grounded: int  # 1: the foot is on the ground
    landings: int  # touch-downs so far
    landing: wp.vec3  # m, where its centre of mass was when it was loaded last
    place: wp.vec3  # m, the same when it last touched down
    before: wp.vec3  # m, and the time before
    width: float  # m, how far the other foot stood from the line between these, to its own side


@wp.struct
class State:
    """What changes, of all instances; how it lies in memory says `core.arrays.instance_zeros`."""

    coordinates: wp.array2d[float]  # (instances, coordinates) joint angles rad, quaternions, root position m
    speeds: wp.array2d[float]  # (instances, speeds) rad/s (ball: child axes), m/s and rad/s of the root (world)
    accelerations: wp.array2d[
        float
    ]  # (instances, speeds) derivatives of the speeds in the step before; now if kinematic
    foot_force: wp.array2d[wp.vec3]  # (instances, 2) N, left and right, of the step before
    foot_cycle: wp.array2d[FootCycle]  # (instances, 2) left and right; no instances where no term asks for it
    step: wp.array[int]  # (instances,) steps made
    status: wp.array[int]  # (instances,) RUNNING ... DIVERGED
    cause: wp.array[int]  # (instances,) part of the user's own that ended it, see `causes.py`; 0: none
    start_height: wp.array[float]  # (instances,) m, of the COM above the ground at step 0
    start_heading: wp.array[float]  # (instances,) rad, of the root at step 0
    passed: wp.array[wp.vec3]  # (instances,) m, of the COM as the window of `no_progress` began; else no instances
    push: wp.array[wp.vec3]  # (instances,) N, on the root's centre of mass, world
    push_steps: wp.array2d[int]  # (instances, 2) first step of the push, and the step after its last
    torque_integral: wp.array2d[wp.float64]  # (instances, bodies) sum over steps of |feedback torque|, N m
    muscle_terms: wp.array3d[wp.float64]  # (instances, terms, muscles) sums over steps, see `term_sums`
    body_terms: wp.array3d[wp.float64]  # (instances, terms, bodies)
    instance_terms: wp.array2d[wp.float64]  # (instances, terms)
    part_memory: wp.array3d[float]  # (instances, rows, floats) of parts of the scene's own; no instances without any
    muscles: MuscleState
    simbicon: SimbiconState
    gait: GaitMemory  # without instances where no states of gait control muscles


@wp.struct
class Scratch:
    """The working set of one instance: views on shared memory in the fused step, on rows of arrays elsewhere.

    Joint torques act positively on the parent and negatively on the child, as in the original program.
    """

    rotation: wp.array[wp.mat33]  # (bodies,) body axes in the world
    orientation: wp.array[wp.quat]  # (bodies,) the same as a quaternion
    position: wp.array[wp.vec3]  # (bodies,) m, of the joint
    angular_velocity: wp.array[wp.vec3]  # (bodies,) rad/s, world
    velocity: wp.array[wp.vec3]  # (bodies,) m/s, of the joint
    lag_angular: wp.array[wp.vec3]  # (bodies,) rad/s, what the angular velocity gained in the last half step
    lag_velocity: wp.array[wp.vec3]  # (bodies,) m/s, what the velocity of the joint gained in the last half step
    bias: wp.array[wp.vec3]  # (bodies,) rad/s^2, velocity-product part of the relative angular acceleration
    anchor: wp.array[wp.vec3]  # (bodies,) m, joint from the parent's joint, parent's axes
    turned: wp.array[wp.quat]  # (bodies,) orientation in the parent
    rate: wp.array[wp.vec3]  # (bodies,) rad/s, of the joint, along axes of the child
    gain: wp.array[wp.vec3]  # (bodies,) rad/s, what that gained in the last half step
    parent_rate: wp.array[wp.vec3]  # (bodies,) rad/s, along an axis of the parent
    parent_gain: wp.array[wp.vec3]  # (bodies,) rad/s
    center: wp.array[wp.vec3]  # (2,) COM and its velocity
    moment: wp.array[wp.vec3]  # (bodies,) kg m, mass times centre of mass, world
    momentum: wp.array[wp.vec3]  # (bodies,) kg m/s
    joint_velocity: wp.array[wp.vec3]  # (bodies,) rad/s, world, of the child relative to the parent
    shape_middle: wp.array[wp.vec3]  # (SHAPES_A_BODY bodies,) m, of the shapes that may collide
    shape_half: wp.array[wp.vec3]  # (SHAPES_A_BODY bodies,) m
    target: wp.array[wp.quat]  # (bodies,)
    strength: wp.array[float]  # (bodies,)
    frame: wp.array[int]  # (bodies,) 1: target in the character frame
    pull: wp.array[wp.vec3]  # (PULLS_A_BODY bodies,) of crossings: moment arms, m, then torques, N m, world
    lack: wp.array[wp.vec3]  # (bodies,) N m, torque that the muscles are to make actively, see `sharing.py`
    price: wp.array[wp.vec3]  # (bodies,) what joints pay for it, kg/(N m)
    softness: wp.array[float]  # (bodies,) (N m)^2/kg
    dearest: wp.array[float]  # (bodies,) greatest price; 0: muscles do not drive the joint
    share: wp.array[float]  # (muscles,) sqrt(kg)
    monomial: wp.array[float]  # (monomials,) see `polynomial_path.py`; only kernels that have polynomials have them
    torque: wp.array[wp.vec3]  # (bodies,) N m, world
    stiffness: wp.array[symmetric]  # (bodies,) N m s^2/rad, implicit joint inertia h (d + h k), world axes
    block_a: wp.array[symmetric]  # (bodies,) articulated inertia: angular block, kg m^2
    block_b: wp.array[wp.mat33]  # (bodies,) coupling block, kg m
    block_c: wp.array[symmetric]  # (bodies,) linear block, kg
    bias_moment: wp.array[wp.vec3]  # (bodies,) N m
    bias_force: wp.array[wp.vec3]  # (bodies,) N
    factor_a: wp.array[wp.mat33]  # (bodies,) joint factors that the forward pass needs
    factor_b: wp.array[wp.mat33]  # (bodies,)
    factor_c: wp.array[wp.vec3]  # (bodies,)
    angular_acceleration: wp.array[wp.vec3]  # (bodies,) rad/s^2
    acceleration: wp.array[wp.vec3]  # (bodies,) m/s^2, of the joint
    contact_b: wp.array[wp.mat33]  # (slots,) what the implicit contact added to the body's blocks B and C ...
    contact_c: wp.array[symmetric]  # (slots,)
    contact_force: wp.array[
        wp.vec3
    ]  # (slots,) ... and its force; after the forward pass the force of the whole step, N
    flags: wp.array[int]  # (2,) a body that is no foot touched the ground, before that: another body; the step diverged
    near: wp.array[int]  # (1,) whether some bodies may touch before the next look; kept from step to step
    # Of joints of one coordinate, see `coordinate_joint.py`; only kernels that have such joints have them:
    coordinate_turning: wp.array[wp.vec3]  # (bodies,) angular half of the motion subspace, world
    coordinate_moving: wp.array[wp.vec3]  # (bodies,) and its linear half
    coordinate_turning_drift: wp.array[wp.vec3]  # (bodies,) rad/s^2, angular acceleration at a constant speed
    coordinate_drift: wp.array[wp.vec3]  # (bodies,) m/s^2, acceleration of the joint at a constant speed
    turn_rates: wp.array[wp.mat33]  # (bodies,) of coupled joints, a row each: a function's value and its derivatives
    move_rates: wp.array[wp.mat33]  # (bodies,) the same of the functions that are no angles
    coordinate_state: wp.array[wp.vec3]  # (bodies,) it itself, its speed, and what that gained in the last half step
    # Of followed coordinates, see `followed.py`, body by body; only kernels that have such coordinates have them:
    followed_moment: wp.array[wp.vec3]  # U, angular half
    followed_force: wp.array[wp.vec3]  # and linear half
    followed_along: wp.array[wp.vec3]  # S . U of a free joint; what another one adds to D
    followed_response: wp.array[wp.vec3]  # d S . U
    followed_bias: wp.array[float]  # what it adds to v
    followed_matrix: wp.array[float]  # D, row by row
    followed_acceleration: wp.array[float]
    # Of rows of constraints, see `constraints.py`; only kernels that have constraints have them:
    push_force: wp.array[wp.vec3]  # on the body, backwards on the other
    push_moment: wp.array[wp.vec3]  # m or 1, of it about the joint of the body
    push_other_moment: wp.array[wp.vec3]  # and of the other one
    push_wanted: wp.array[float]  # m/s^2 or rad/s^2
    push_mobility: wp.array[float]  # 1/kg or 1/(kg m^2)


@wp.struct
class Record:
    """Frames of chosen instances; arrays are (recorded, frames, ...), written every `every` steps."""

    slot: wp.array[int]  # (instances,) which row an instance has, -1 for none
    every: int  # steps between frames; 0: nothing is recorded
    coordinates: wp.array3d[float]
    speeds: wp.array3d[float]
    com: wp.array3d[wp.vec3]  # position, velocity
    foot_force: wp.array3d[wp.vec3]  # left, right
    orientation: wp.array3d[wp.quat]  # bodies, world
    position: wp.array3d[wp.vec3]  # bodies, of the joint
    angular_velocity: wp.array3d[wp.vec3]  # bodies, world
    torque: wp.array3d[wp.vec3]  # bodies; over the step that begins with the frame
    desired_torque: wp.array3d[wp.vec3]  # bodies; the controller's
    target: wp.array3d[wp.quat]  # bodies
    muscle: wp.array4d[float]  # quantities, muscles; path length ... force, see `muscle_stage`
    custom: wp.array3d[float]  # quantities of the scene's own
    stiffness: wp.array2d[symmetric]  # (recorded, bodies) implicit joint inertia of the step, see `Scratch.stiffness`
    simbicon: SimbiconRecord  # without frames where another controller, or none, is recorded
    memory: wp.array3d[float]  # numbers of a controller's memory that it lets be recorded


# What functions are given. With copies of structures this large, one a call, the compiler takes twice as long.
ModelRef = wp.ref[Model]
StateRef = wp.ref[State]
ScratchRef = wp.ref[Scratch]
RecordRef = wp.ref[Record]

# Names that users' modules may have from before.
__getattr__ = of_former_names(
    __name__, {"Work": "Scratch", "WorkRef": "ScratchRef", "Term": "Contribution", "Motion": "PrescribedMotion"}
)
