"""Device structures of bodies and joints, their contact points and the ground, and shapes that may collide."""

import warp as wp

from warpmuscle.kernels.terrain_structs import Terrain


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
class Feet:
    """The bodies that a character walks on, where it has any; the root's number else."""

    left: int
    right: int


@wp.struct
class CubicPiece:
    """A part of a function of a coordinate: c0 + c1 t + c2 t^2 + c3 t^3 at a distance t from its start."""

    start: float  # rad or m
    c: wp.vec4


@wp.struct
class Coupling:
    """Whose coordinate moves the joint of a body."""

    driver: int  # the body whose joint's coordinate it is: another one if it follows that
    first: int  # of the functions of a coupled joint
    row: int  # number of the coordinate among those that are followed, see `followed.py`; -1: none of them
    beside: int  # the body of the other joint on whose coordinate it depends, see `two_coordinates.py`; -1: none
    kind: int  # of its functions then


@wp.struct
class CouplingFunction:
    """How far a coupled joint turns about an axis, or moves along it."""

    axis: wp.vec3  # unit vector
    first_piece: int
    end_piece: int
    body: int  # that the joint carries; 0: none
    counts: int  # 0: it is 0 everywhere


@wp.struct
class BodyRun:
    """Bodies each of which is the only child of the one before it; the first one's parent has others, or is the root.

    Those of a level hang on bodies of levels before. The first ones in the list say besides where levels are in it.
    """

    first: int
    last: int
    count: int
    unknowns: int  # that act on the first one, and so all that act on the others
    before: int  # the same of those before it in its level
    start: int  # of the level of this place in the list
    end: int


@wp.struct
class Couplings:
    """How coupled joints turn and move their child: six functions of a coordinate each, three of them angles."""

    joint: wp.array[Coupling]  # (bodies,)
    follower_start: wp.array[int]  # (bodies + 1,) of those that follow the joint of each ...
    follower: wp.array[int]  # ... body by body
    followed: int  # coordinates that stay open to the root, and rows of constraints
    unknown_driver: wp.array[int]  # (unknowns,) the body of the joint whose coordinate each is; 0: a constraint's row
    # Entries are pairs of a body and one of these unknowns that acts on it, body by body; all act on the root:
    entry_start: wp.array[int]  # (bodies + 1,) where those of a body start
    entry_unknown: wp.array[int]  # (entries,) in ascending order in each body
    entry: wp.array[int]  # (bodies * unknowns,) which one it is; -1: none
    acted_start: wp.array[int]  # (unknowns + 1,) where the bodies start that an unknown acts on ...
    acted: wp.array[int]  # ... (entries but the root's,) in ascending order
    run: wp.array[BodyRun]  # (runs,) level by level, those on which most unknowns act first
    run_levels: int
    function: wp.array2d[CouplingFunction]  # (rows, functions)
    inertia_axes: wp.array2d[
        wp.mat33
    ]  # (rows, bodies) principal axes in the body; only kernels with turned ones read it
    piece: wp.array2d[CubicPiece]  # (rows, pieces)
    resistance: wp.array2d[wp.vec2]  # (rows, bodies) armature and damping of joints; only kernels with some read it


@wp.struct
class ConstraintPlan:
    """Between which bodies a constraint is."""

    kind: int  # WELD ... DISTANCE, see `constraints.py`
    body: int
    other: int
    first_row: int


@wp.struct
class ConstraintRow:
    """The numbers of a constraint; body axes, from the bodies' joints."""

    place: wp.vec3  # m, on the body
    other_place: wp.vec3  # m, on the other one
    axes: wp.mat33  # of a weld, on the body
    other_axes: wp.mat33  # of a weld, on the other one; of a line, it and two axes across
    distance: float  # m


@wp.struct
class Constraints:
    """What holds bodies that no joint joins. Only kernels that have constraints read it."""

    first: int  # of their rows, among the unknowns of `followed.py`
    plan: wp.array[ConstraintPlan]  # (constraints,)
    row: wp.array2d[ConstraintRow]  # (rows, constraints)
    body: wp.array[int]  # (rows of all constraints,) on which each pushes ...
    other: wp.array[int]  # ... and on which backwards
    held: wp.array[int]  # (rows of all constraints,) number of the point or turn that each holds with others


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
class Belts:
    """How the ground moves along itself, see `contact/belts.py`."""

    left: float  # m/s, backwards, to the left of the line between both
    right: float  # m/s
    sideways: float  # m/s, to the left, of both
    split: float  # m, x of the line between both
    start: float  # s, when the profile of their speeds begins


@wp.struct
class SoftConstraint:
    """How contacts give and bounce that are constraints, see `soft_constraint.py`."""

    restitution: float
    softness: float  # m/(N s)
    penalty: float


@wp.struct
class ContactMaterial:
    """What a sphere is made of in Hunt-Crossley contact, see `hunt_crossley.py`."""

    hertz: float  # N/m^(3/2)
    dissipation: float  # s/m
    static_friction: float
    dynamic_friction: float
    viscous_friction: float  # s/m
    transition_velocity: float  # m/s
    hertz_smoothing: float  # 1/m
    hunt_crossley_smoothing: float  # s/m
    constant: float  # added to squares, m^2 and m^2/s^2
    margin: float  # m, above the ground where it begins to push


@wp.struct
class Contacts:
    """Contact points of the bodies, and the ground: its plane, and what rises over it."""

    reach: wp.array2d[float]  # (rows, bodies) m, no contact while the joint is higher than this
    point: wp.array2d[ContactPoint]  # (rows, points)
    normal: wp.array2d[wp.vec3]  # (rows, 1) upward unit normal of the ground
    height: wp.array2d[float]  # (rows, 1) m
    ground: wp.array2d[Ground]  # (rows, 1)
    material: wp.array2d[ContactMaterial]  # (rows, points) of Hunt-Crossley contact
    soft: wp.array2d[SoftConstraint]  # (rows, 1) of contacts that are constraints
    terrain: Terrain  # over the plane
    belts: wp.array2d[Belts]  # (rows, 1); only kernels whose ground moves read this and the next one
    belt_profile: wp.array2d[wp.vec2]  # (rows, knots) time, s, and what their speeds are multiplied by


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
