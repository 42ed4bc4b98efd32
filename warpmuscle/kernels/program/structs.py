"""What the solver of quadratic programmes is given, for many of one size, and the memory it works in."""

import warp as wp


@wp.struct
class Columns:
    """Which entries of B are not zero: the same ones in all programmes, a control after the other."""

    first: wp.array[int]  # (controls + 1,) in `row`
    row: wp.array[int]  # (entries,) coordinates, which increase within a control
    owner: wp.array[int]  # (entries,) controls
    line: wp.array[int]  # (groups + 1,) first rows of tables of `LANES` columns, each of which is a coordinate's
    line_target: wp.array[int]  # (groups LANES,) coordinates; -1: none
    line_entry: wp.array[int]  # (rows LANES,) entries of that coordinate; -1: none
    pair: wp.array[int]  # (groups + 1,) the same of products of two entries of a control, which a place in H is made of
    pair_target: wp.array[int]
    pair_entry: wp.array[wp.vec2i]


@wp.struct
class Programs:
    """Numbers of all programmes, see `box_program.py`; n coordinates, m controls."""

    mass: wp.array2d[float]  # (programs, n n) M, symmetric
    bias: wp.array2d[float]  # (programs, n) h
    weight: wp.array2d[float]  # (programs, n n) W, symmetric
    wanted: wp.array2d[float]  # (programs, n) accelerations
    entry: wp.array2d[float]  # (programs, entries) of B
    gain: wp.array2d[float]  # (programs or 1, m) 1 over the cost of a squared control
    low: wp.array2d[float]  # (programs or 1, m) bounds
    high: wp.array2d[float]


@wp.struct
class ProgramWork:
    """Working memory of programmes; of symmetric matrices and factors the lower half, row by row."""

    factor: wp.array2d[wp.float64]  # (programs, n (n + 1)/2) L of W; 1 over its diagonal
    square: wp.array2d[wp.float64]  # (programs, n n) L^-1 M
    reserve: wp.array2d[wp.float64]  # (programs, n (n + 1)/2) R
    hessian: wp.array2d[wp.float64]  # (programs, n (n + 1)/2)
    vector: wp.array3d[wp.float64]  # (programs, 4, n) needed, h, sizes, d
    by_control: wp.array3d[wp.float64]  # (programs, 2, m) B^T x and B^T d
    memory: wp.array2d[wp.float64]  # (programs, doubles)


@wp.struct
class Frames:
    """Bodies of all instances, world axes; (instances, bodies) unless said otherwise."""

    position: wp.array2d[wp.vec3]  # m, of joints
    orientation: wp.array2d[wp.quat]
    velocity: wp.array2d[wp.vec3]  # m/s, of joints
    angular_velocity: wp.array2d[wp.vec3]  # rad/s
    drift: wp.array2d[wp.vec3]  # m/s^2, of joints, where speeds do not change
    turning_drift: wp.array2d[wp.vec3]  # rad/s^2
    com: wp.array2d[wp.vec3]  # m, from the joint
    mass: wp.array2d[float]  # kg
    angular: wp.array2d[wp.vec3]  # (instances, speeds) what a unit of a speed gives the body relative to its parent
    linear: wp.array2d[wp.vec3]  # (instances, speeds)
    center: wp.array2d[wp.vec3]  # (instances, 2) m and m/s, of the whole


@wp.struct
class TaskSums:
    """What tasks of an instance add up to."""

    weight: wp.array[float]  # (n n) W
    pull: wp.array[float]  # (n) W times wanted accelerations
    row: wp.array[float]  # (n) room for how speeds move something


@wp.struct
class Layout:
    """Where things stand in the memory of the controller, and which controls belong to what."""

    every: int  # steps between decisions
    coordinates: int  # first of the coordinates at the start
    bodies: int  # first of the bodies at the start, `controller.BODY_FLOATS` each
    center: int  # first of the centre of mass at the start
    steps: int  # first of what steps remember
    margin: float  # m, above the ground where a point counts as touching it
    lever: wp.array[int]  # (entries of muscles,) number in moment arms
    torque: wp.array2d[int]  # (torques, 2) speed, and the body whose joint has it
    point: wp.array2d[int]  # (points, 2) number among all points of contact, and its body
    support: wp.array2d[int]  # (supports, 3) number among the shapes that touch objects, its object, and its body
