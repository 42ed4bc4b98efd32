"""Device structures of muscles and of their paths."""

import warp as wp


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
    first_contribution: int
    end_contribution: int


@wp.struct
class SegmentEnds:
    """Both ends of a segment, axes of their bodies."""

    a: wp.vec3  # m, from the joint of the segment's origin, or of its own body
    b: wp.vec3


END_BEYOND, START_BEYOND = 1, 2  # a segment ends, starts beyond the joint; neither: only a condition hangs on the joint
FIRST_OF_CROSSING, LAST_OF_CROSSING = 4, 8  # no contribution before is to the crossing, none behind it is
IN_FIRST_SEGMENT = 64  # nor is one of a segment before
LAST_OF_SEGMENT = 16  # none of the segment behind it is to the crossing
BY_COORDINATE = 32  # the joint is as in `coordinate_joint.py`
GROUPS = 128  # times the number of a group and one more; less: the joint is by itself


@wp.struct
class Contribution:
    """What a segment contributes to a crossing by a joint; those to the same crossing come one behind the other."""

    crossing: int
    joint: int
    driver: int  # the joint that this one follows, or itself
    marks: int  # END_BEYOND ... GROUPS


@wp.struct
class GroupMember:
    """A joint of one coordinate, of a group of some that the same coordinate moves, as one in the place of the first.

    The first ones in the list say besides where the members of groups are in it.
    """

    joint: int
    sign: float  # 1, or -1 if a path that ends beyond the first starts beyond this one
    start: int  # of the members of the group of this place in the list
    end: int


@wp.struct
class Pulley:
    """A pulley that a path turns with."""

    crossing: int
    joint: int
    axis: int  # which of the joint's coordinates
    first: int  # 1: no pulley before belongs to the crossing
    last: int  # 1: none after it does


@wp.struct
class Straight:
    """The path of a muscle that is one segment between neighbouring bodies and crosses the joint between them."""

    body_a: int
    body_b: int
    crossing: int
    sign: int  # 1: b is beyond the joint, -1: a is


@wp.struct
class Crossing:
    """A crossing of a muscle."""

    number: int
    joint: int


@wp.struct
class TorquePart:
    """Some of the crossings of a joint, whose torques one lane adds up."""

    first: int
    end: int
    place: int  # of their sum; those of a joint come one behind the other


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
    contribution: wp.array[Contribution]  # (contributions,)
    member: wp.array[GroupMember]  # (members,) of the largest groups first; only kernels that have groups read them
    straight: wp.array[Straight]  # (muscles,) if all paths are such; the ends of each are those of its segment
    of_muscle: wp.array[Crossing]  # (crossings,) those of each muscle, nearest to the root first
    point_condition: wp.array[int]  # (points,) -1: the point always counts
    condition_joint: wp.array[int]  # (conditions,)
    condition_axis: wp.array[int]  # (conditions,) which of the joint's coordinates
    condition_slope: wp.array[int]  # (conditions,) 1: moment arms are slopes of the length; 0: without those of weights
    condition_interval: wp.array2d[wp.vec3]  # (rows, conditions) low, high, width of the blend, rad
    segment_points: wp.array2d[int]  # (segments, 2) a and b
    crossing_start: wp.array[int]  # (bodies + 1,) crossings of the joint of body i
    crossing_muscle: wp.array[int]  # (crossings,)
    torque_part: wp.array[TorquePart]  # the largest ones first; none unless very many muscles cross some joint
    torque_part_start: wp.array[int]  # (bodies + 1,) places of the parts of the joint of body i
    pulley: wp.array[Pulley]  # (pulleys,)
    pulley_row: wp.array2d[wp.vec2]  # (rows, pulleys) moment arm, m, and rest angle, rad


@wp.struct
class MuscleRow:
    """The numbers of one muscle, which a lane fetches together.

    An odd number of words: else lanes that fetch the same number of neighbouring muscles ask the same banks for it.
    """

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
class TimedExcitation:
    """The excitation of a muscle that has its own, over time."""

    first_knot: int
    end_knot: int  # the one after the last; none if it is the first
    period: float  # s, 0: it does not repeat


@wp.struct
class CurveRow:
    """The numbers of a muscle's curves and tendon, where muscles differ in them; see `shaped_curves.py`."""

    curves: int  # MILLARD, THELEN, DE_GROOTE, MUJOCO or SPLINE
    tendon: int  # RIGID or COMPLIANT
    table: int  # where that of Millard's curves, or of those through knots, starts
    minimum_activation: float
    shortest: float  # l_opt, of the fibre
    tendon_rate: float  # 1 over the tendon's strain at f_max
    active_width: float  # Thelen: of the bell; De Groote: 1 over the scale of its widths; MuJoCo: where it ends, l_opt
    passive_rate: float  # of the exponential over length; of MuJoCo: lmax of the passive force, l_opt
    passive_floor: float  # of MuJoCo: where the passive force begins, l_opt
    passive_scale: float  # of MuJoCo: twice the force half-way from there to that lmax
    velocity_shape: float  # of Thelen's hyperbolas; of curves through knots: above 0 for Schutte's
    lengthening_force: float
    straight_speed: float  # beyond which they are straight, over v_max at full activation


@wp.struct
class Muscles:
    """What stays the same of the muscles."""

    count: int
    model: int  # LEE ... SARSHARI, see `curve_sets.py`; the fused step has it compiled in
    negative: int  # KEEP, DROP or CLIP
    scaled_rates: int  # 1: the rates of activation depend on the activation
    row: wp.array2d[MuscleRow]  # (rows, muscles)
    mass: wp.array2d[float]  # (rows, muscles) kg; metabolic powers alone read it
    smoothing: wp.array2d[float]  # (rows, muscles) see `activation.smoothed_rate`; 0: none; below: BLENDED and others
    timed: wp.array2d[TimedExcitation]  # (rows, muscles)
    knot_time: wp.array2d[float]  # (rows, knots) s
    knot_value: wp.array2d[float]  # (rows, knots)
    shape: wp.array2d[CurveRow]  # (rows, muscles) read where muscles differ in their curves or tendons
    curve_table: wp.array[wp.vec2]  # tables of Millard's curves, one behind the other, see `millard_tables.py`


@wp.struct
class SharedMuscle:
    """What sharing torques out keeps of a muscle within a step; see `sharing.py`."""

    moving: float  # m, see `path.PathState`
    speed: float  # m/s
    scale: float  # N/sqrt(kg), active force over the square root of the mass, of the moment arms
    idle: float  # activation from which on there is active force


@wp.struct
class SharingState:
    """What sharing torques out keeps, of all instances; no instances where each muscle is asked by itself."""

    muscle: wp.array2d[SharedMuscle]  # (instances, muscles)
    share: wp.array2d[float]  # (instances, muscles) sqrt(kg), where the working set has no room for it
    price: wp.array2d[wp.vec3]  # (instances, bodies) kg/(N m), what joints paid for torque in the step before


@wp.struct
class PathsApart:
    """What passes between a step and the kernel that finds its paths; no instances where the step finds them itself."""

    rotation: wp.array2d[wp.mat33]  # (instances, bodies), as all but the last in the working set; see `Scratch`
    position: wp.array2d[wp.vec3]
    angular_velocity: wp.array2d[wp.vec3]
    lag_angular: wp.array2d[wp.vec3]
    joint_velocity: wp.array2d[wp.vec3]
    coordinate_turning: wp.array2d[wp.vec3]
    coordinate_moving: wp.array2d[wp.vec3]
    stretch: wp.array2d[wp.vec2]  # (instances, muscles) m, m/s, `moving` and `speed` of a `path.PathState`


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
    moment_arm: wp.array2d[wp.vec3]  # (instances, crossings) m, world; while torques are shared out, scaled
    part_torque: wp.array2d[wp.vec3]  # (instances, parts) N m, world, see `torque_parts.py`; else no instances
    group_turning: wp.array2d[wp.vec3]  # (instances, groups) as `Scratch.coordinate_turning` of a joint; else none
    group_moving: wp.array2d[wp.vec3]  # and as `Scratch.coordinate_moving`, of the place of the first joint
    sharing: SharingState
    apart: PathsApart
    # Of reflexes, and of other controllers that excite muscles; no instances where there are none:
    sensed: wp.array2d[wp.vec3]  # (instances, muscles) length over l_opt, its rate 1/s, force over f_max
    reflex: wp.array2d[float]  # (instances, muscles) excitation by reflexes
    stands: wp.array2d[int]  # (instances, 2) 1: the left, the right leg is loaded
    landed: wp.array[int]  # (instances,) LEFT or RIGHT, the leg that landed last
    lean_at_lift: wp.array2d[float]  # (instances, 2) rad, of the trunk as the leg left the ground
