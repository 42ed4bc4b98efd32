"""What a kernel is given: the model, the state of all instances, the working set of one instance, and what to record.

Bodies are numbered breadth first from the root (0), so that the bodies of one tree level, and the children of one
body, are neighbours; joint i - 1 connects body i to its parent. Arrays of model numbers are (rows, ...) with rows = 1
where all instances share them, or one row an instance; `at` reads both.
"""

from typing import Any

import warp as wp

from warpmuscle.kernels.spatial import symmetric

ROOT_FREE, ROOT_PLANAR, ROOT_FIXED = 0, 1, 2
BALL, UNIVERSAL, HINGE, FIXED = 1, 2, 3, 4
SECOND_HINGE, ROOT_PRESCRIBED = 5, 6  # what motion leaves of a universal joint whose first axis it has, and of a root
FIRST_AXIS, SECOND_AXIS, BOTH_AXES = 1, 2, 3  # of a universal joint, prescribed
LEFT, RIGHT, REVERSE, SAME = 0, 1, 2, 3
RUNNING, COMPLETED, FELL, TURNED, TOUCHED, DIVERGED, CROSSED, COLLIDED = 0, 1, 2, 3, 4, 5, 6, 7
BY_TORQUE, BY_MUSCLES, MIXED = 0, 1, 2  # what drives a joint
KEEP, DROP, CLIP = 0, 1, 2  # pushing contributions to a muscle's desired force

polynomial = wp.types.vector(length=6, dtype=float)  # coefficients, the constant first


@wp.func_native(snippet="__builtin_assume(i >= 0); return i;")
def whole(i: int) -> int: ...  # a number that is never negative, so that the compiler need not count from the end


@wp.func
def at(a: wp.array2d[Any], instance: int, i: int):
    """Element i of an instance in an array that has one row for all instances or one row an instance."""
    return a[whole(wp.min(instance, a.shape[0] - 1)), whole(i)]


@wp.struct
class BodyPlan:
    """The place of a body in the tree, and of what belongs to it in other lists."""

    parent: int
    joint_type: int  # ROOT_* for body 0
    coordinate_start: int
    speed_start: int
    speed_end: int  # the one after the last
    first_child: int
    child_count: int
    has_limits: int
    foot_slot: int  # where the contact force of a foot or toe is kept, -1 for other bodies
    first_point: int  # of contact
    end_point: int


@wp.struct
class BodyRow:
    """The numbers of a body and its joint."""

    mass: float  # kg
    com: wp.vec3  # m, from the joint, body axes
    inertia: wp.vec3  # kg m^2, principal, about the centre of mass
    anchor: wp.vec3  # m, joint from the parent's joint, parent's axes
    axis_a: wp.vec3  # hinge; universal, on the child; ball: first limit axis, on the parent
    axis_b: wp.vec3  # universal, on the parent; ball: third limit axis, on the child


@wp.struct
class LimitRow:
    """The limits of a joint."""

    low: wp.vec3  # rad
    high: wp.vec3  # rad
    cosine: wp.vec3  # of the middle of the limits
    sine: wp.vec3  # of the same
    half_cosine: wp.vec3  # of half the distance between them; -2 beyond a full turn
    stiffness: float  # N m/rad
    damping: float  # N m s/rad


@wp.struct
class Skeleton:
    """Bodies and joints. Body frames have their origin at the joint to the parent (the root's: its centre of mass)."""

    plan: wp.array[BodyPlan]  # (bodies,)
    row: wp.array2d[BodyRow]  # (rows, bodies)
    limits: wp.array2d[LimitRow]  # (rows, bodies)
    foot_side: wp.array[int]  # (slots,) LEFT or RIGHT
    total_mass: wp.array2d[float]  # (rows, 1) kg


@wp.struct
class ContactPoint:
    """A point of a body that may touch the ground; body axes, from the body's joint."""

    place: wp.vec3  # m
    radius: float  # m, of the sphere about it
    friction: float


@wp.struct
class Ground:
    """What the ground is like, apart from where it is."""

    stiffness: float  # N/m
    damping: float  # N s/m
    tangential_damping: float  # N s/m


@wp.struct
class Contacts:
    """Contact points of the bodies, and the ground plane."""

    reach: wp.array2d[float]  # (rows, bodies) m, no contact while the joint is higher than this
    point: wp.array2d[ContactPoint]  # (rows, points)
    normal: wp.array2d[wp.vec3]  # (rows, 1) upward unit normal of the ground
    height: wp.array2d[float]  # (rows, 1) m
    ground: wp.array2d[Ground]  # (rows, 1)


@wp.struct
class Collisions:
    """Shapes of bodies that must not run into each other, as capsules; body axes, from the body's joint."""

    every: int  # steps between two tests
    body: wp.array[int]  # (shapes,)
    middle: wp.array2d[wp.vec3]  # (rows, shapes) m, of the capsule's segment
    half: wp.array2d[wp.vec3]  # (rows, shapes) m, from the middle of the segment to its end
    pair: wp.array2d[int]  # (pairs, 2) shapes
    nearest_sq: wp.array2d[wp.vec2]  # (rows, pairs) m^2, squared distances: of middles that exclude a collision, and
    # the least one of the segments without it


@wp.struct
class Gains:
    """Of the PD controller of a joint."""

    kp: float  # N m/rad
    kd: float  # N m s/rad
    torque_limit: float  # N m
    scale: wp.vec3  # along child axes


@wp.struct
class ControlState:
    """A state of the controller's machine."""

    next_state: int
    on_foot_down: int  # 1: foot down, 0: time up
    stance_rule: int  # LEFT, RIGHT, REVERSE or SAME, on entering
    first_trajectory: int
    end_trajectory: int  # the one after its last


@wp.struct
class Trajectory:
    """Where a joint is to go in a state."""

    left_body: int  # body in left stance; -1 if a later trajectory drives its joint
    right_body: int  # in right stance
    character_frame: int
    first_knot: int  # of the strength
    end_knot: int
    first_component: int
    end_component: int


@wp.struct
class ComponentPlan:
    """What stays the same of a component: one rotation of a trajectory."""

    reverse: int  # stance that reverses the base angle, or -1
    first_knot: int
    end_knot: int
    has_feedback: int


@wp.struct
class ComponentRow:
    """Its numbers."""

    axis: wp.vec3
    feedback_axis: wp.vec3
    feedback_gain: wp.vec2  # cd, cv
    feedback_limits: wp.vec4  # d low, d high, v low, v high


@wp.struct
class Knot:
    """Of a curve."""

    phase: float
    value: float


@wp.struct
class Simbicon:
    """The controller: gains by body (0: the root), states, trajectories, their components, and curves as knots."""

    enabled: int
    left_foot: int
    right_foot: int
    left_hip: int
    right_hip: int
    heading_control: int
    gains: wp.array2d[Gains]  # (rows, bodies)
    hip: wp.array2d[wp.vec4]  # (rows, 1) damping, largest velocity, predictive scale, desired heading
    states: wp.array[ControlState]  # (states,)
    state_time: wp.array2d[float]  # (rows, states) s
    balance_knots: wp.array2d[int]  # (states, 8) first and end of the curves of distance x, z and velocity x, z
    trajectories: wp.array[Trajectory]  # (trajectories,)
    components: wp.array[ComponentPlan]  # (components,)
    component_rows: wp.array2d[ComponentRow]  # (rows, components)
    knots: wp.array2d[Knot]  # (rows, knots)


@wp.struct
class PathSpan:
    """Where the path of a muscle stands in the lists of all paths."""

    first_segment: int
    end_segment: int  # the one after its last
    first_crossing: int  # in `Paths.of_muscle`
    end_crossing: int
    first_pulley: int
    end_pulley: int


@wp.struct
class Segment:
    """A straight part of a path, in the order of the path from a to b."""

    body_a: int
    body_b: int
    origin: int  # the body from whose joint it is measured
    far: int  # 0: its bodies are neighbours, and its ends are given from the origin
    varies: int  # 1: its weight depends on conditions
    first_term: int
    end_term: int


@wp.struct
class SegmentEnds:
    """Both ends of a segment, axes of their bodies."""

    a: wp.vec3  # m, from the joint of the segment's origin, or of its own body
    b: wp.vec3


@wp.struct
class Term:
    """What a segment contributes to a crossing."""

    crossing: int
    joint: int
    sign: int  # 1: b is beyond the joint, -1: a is, 0: only a condition hangs on the joint
    first: int  # 1: no segment before contributes to the crossing
    last: int  # 1: none after it does


@wp.struct
class Pulley:
    """A pulley that a path turns with."""

    crossing: int
    joint: int
    axis: int  # which of the joint's coordinates
    first: int  # 1: no pulley before belongs to the crossing
    last: int  # 1: none after it does


@wp.struct
class Crossing:
    """A crossing of a muscle."""

    number: int
    joint: int


@wp.struct
class Paths:
    """Paths of all muscles, one behind the other; a crossing is a pair of a joint and a muscle that acts on it.

    Crossings are sorted by joint, so that a joint gathers its own muscles. Joints are named by the body they carry.
    Segments that lie within one body and always count are part of a muscle's fixed length and not listed; so is the
    rest length of a muscle on pulleys. What a lane needs at once lies together, since each fetch from memory takes the
    time of hundreds of operations.
    """

    fixed_length: wp.array2d[float]  # (rows, muscles) m
    span: wp.array[PathSpan]  # (muscles,)
    segment: wp.array[Segment]  # (segments,)
    ends: wp.array2d[SegmentEnds]  # (rows, segments)
    term: wp.array[Term]  # (terms,)
    of_muscle: wp.array[Crossing]  # (crossings,) those of each muscle, nearest to the root first
    point_condition: wp.array[int]  # (points,) -1: the point always counts
    condition_joint: wp.array[int]  # (conditions,)
    condition_axis: wp.array[int]  # (conditions,) which of the joint's coordinates
    condition_interval: wp.array2d[wp.vec3]  # (rows, conditions) low, high, width of the blend, rad
    segment_points: wp.array2d[int]  # (segments, 2) a and b
    crossing_start: wp.array[int]  # (bodies + 1,) crossings of the joint of body i
    crossing_muscle: wp.array[int]  # (crossings,)
    pulley: wp.array[Pulley]  # (pulleys,)
    pulley_row: wp.array2d[wp.vec2]  # (rows, pulleys) moment arm, m, and rest angle, rad


@wp.struct
class MuscleRow:
    """The numbers of one muscle, which a lane fetches together."""

    f_max: float  # N
    l_opt: float  # m
    l_slack: float  # m
    width: float  # m, l_opt sin(pennation at l_opt)
    v_max: float  # l_opt/s
    damping: float  # force at v_max over f_max
    rise_time: float  # s, time constant of activation
    fall_time: float  # s, of deactivation
    rise_rest: float  # exp(-h/rise_time): what a step leaves of the way to go, up ...
    fall_rest: float  # ... and down; the rates of activation being constant
    neural_rest: float  # of neural dynamics: what a step leaves of the way to go, ...
    rise_mix: float  # ... and what part of it counts for the activation, up ...
    fall_mix: float  # ... and down; see `activation.neural_step`
    slow_fibres: float  # fraction of slow-twitch fibres
    delay_steps: int  # less than the capacity of the ring


@wp.struct
class OwnExcitation:
    """The excitation of a muscle that has its own, over time."""

    first_knot: int
    end_knot: int  # the one after the last; none if it is the first
    period: float  # s, 0: it does not repeat


@wp.struct
class Muscles:
    """What stays the same of the muscles."""

    count: int
    model: int  # LEE ... SARSHARI, see `curves.py`; the fused step has it compiled in
    negative: int  # KEEP, DROP or CLIP
    scaled_rates: int  # 1: the rates of activation depend on the activation
    row: wp.array2d[MuscleRow]  # (rows, muscles)
    own: wp.array2d[OwnExcitation]  # (rows, muscles)
    knot_time: wp.array2d[float]  # (rows, knots) s
    knot_value: wp.array2d[float]  # (rows, knots)


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


@wp.struct
class Motion:
    """How the kinematic coordinates move; see `motion.py`. Only kernels that have it compiled in read it."""

    start: wp.array[float]  # (pieces,) s, where the pieces of the curves start
    curve: wp.array3d[polynomial]  # (rows, pieces, curves) over the time since the start of the piece
    row: wp.array[int]  # (instances,) which row of the curves an instance follows; none: its own, or the only one
    angle: wp.array2d[int]  # (angles, 3) coordinate, speed and curve of angles and positions
    turn: wp.array2d[int]  # (turns, 4) first coordinate, speed and curve of a quaternion; 1: speeds along world axes
    joint: wp.array2d[int]  # (joints, 2) body, and which axes of a hinge or universal joint
    remaining: wp.array[int]  # (bodies,) the joint types that the dynamics sees


@wp.struct
class Model:
    """Everything that stays the same during a simulation."""

    body_count: int
    level_count: int
    foot_slots: int
    implicit_pd: int
    time_step: float  # s
    gravity: wp.array2d[float]  # (rows, 1) m/s^2
    failure: wp.array2d[wp.vec4]  # (rows, 1) lowest relative COM height, largest turn rad, largest speed, crossing m
    fail_on_body_contact: int
    head: int  # the body whose turning the objective may count
    objective: wp.array2d[wp.vec2]  # (rows, 1) target speed m/s, bound of the vertical foot force over body weight
    reference_bins: int  # of the phase, for each stance
    reference: wp.array2d[wp.quat]  # (2 bins, bodies) child in parent, of a tracked gait; left stance first
    tracked: wp.array[float]  # (bodies,) 1: the body's joint is compared with it
    level_start: wp.array[int]  # (levels + 1,)
    skeleton: Skeleton
    contacts: Contacts
    collisions: Collisions
    simbicon: Simbicon
    actuation: Actuation
    muscles: Muscles
    paths: Paths
    motion: Motion


@wp.struct
class MuscleState:
    """What changes of the muscles, of all instances."""

    activation: wp.array2d[float]  # (instances, muscles)
    excitation_ring: wp.array3d[float]  # (instances, capacity, muscles) see `delayed_slot`
    neural: wp.array2d[float]  # (instances, muscles) between excitation and activation, with neural dynamics
    damping: wp.array2d[float]  # (instances, muscles) N s/m, that a step takes as implicit
    fibre_length: wp.array2d[float]  # (instances, muscles) m; with compliant tendons or in legacy mode
    previous_fibre_length: wp.array2d[float]  # (instances, muscles) m, a step before
    force: wp.array2d[float]  # (instances, muscles) N
    moment_arm: wp.array2d[wp.vec3]  # (instances, crossings) m, world


@wp.struct
class State:
    """What changes, of all instances."""

    coordinates: wp.array2d[float]  # (instances, coordinates) joint angles rad, quaternions, root position m
    speeds: wp.array2d[float]  # (instances, speeds) rad/s (ball: child axes), m/s and rad/s of the root (world)
    accelerations: wp.array2d[
        float
    ]  # (instances, speeds) derivatives of the speeds in the step before; now if kinematic
    phase: wp.array[float]  # (instances,)
    stance: wp.array[int]  # (instances,) LEFT or RIGHT
    machine_state: wp.array[int]  # (instances,)
    foot_force: wp.array2d[wp.vec3]  # (instances, 2) N, left and right, of the step before
    step: wp.array[int]  # (instances,) steps made
    status: wp.array[int]  # (instances,) RUNNING ... DIVERGED
    start_height: wp.array[float]  # (instances,) m, COM height at step 0
    push: wp.array[wp.vec3]  # (instances,) N, on the root's centre of mass, world
    push_steps: wp.array2d[int]  # (instances, 2) first step of the push, and the step after its last
    torque_integral: wp.array2d[wp.float64]  # (instances, bodies) sum over steps of |feedback torque|, N m
    muscle_terms: wp.array3d[wp.float64]  # (instances, terms, muscles) sums over steps, see `objective_terms`
    body_terms: wp.array3d[wp.float64]  # (instances, terms, bodies)
    whole_terms: wp.array2d[wp.float64]  # (instances, terms)
    muscles: MuscleState


@wp.struct
class Work:
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


@wp.struct
class Record:
    """Frames of chosen instances; arrays are (recorded, frames, ...), written every `every` steps."""

    slot: wp.array[int]  # (instances,) which row an instance has, -1 for none
    every: int  # steps between frames; 0: nothing is recorded
    phase: wp.array2d[float]
    stance: wp.array2d[int]
    machine_state: wp.array2d[int]
    coordinates: wp.array3d[float]
    speeds: wp.array3d[float]
    com: wp.array3d[wp.vec3]  # position, velocity
    foot_force: wp.array3d[wp.vec3]  # left, right
    orientation: wp.array3d[wp.quat]  # bodies, world
    position: wp.array3d[wp.vec3]  # bodies, of the joint
    angular_velocity: wp.array3d[wp.vec3]  # bodies, world
    torque: wp.array3d[wp.vec3]  # bodies
    desired_torque: wp.array3d[wp.vec3]  # bodies; the controller's
    target: wp.array3d[wp.quat]  # bodies
    muscle: wp.array4d[float]  # quantities, muscles; path length ... force, see `muscle_stage`
