"""Device structures of objects: rigid bodies beside the character, see `objects/`."""

import warp as wp


@wp.struct
class ObjectRow:
    """The numbers of an object: a box whose edges a sphere rounds, of which balls and capsules are special cases."""

    mass: float  # kg
    inertia: wp.vec3  # kg m^2, principal, along its axes, about its middle
    half: wp.vec3  # m, half edges of the box; 0 along all axes for a ball, along two for a capsule
    radius: float  # m, of the sphere
    rounding: float  # m, by which bodies feel edges of a box rounded
    reach: float  # m, from its middle to its farthest point
    stiffness: float  # N/m, of a contact
    damping_ratio: float  # of a contact, by which restitution is what it is
    friction: float  # with bodies
    ground_friction: float
    tangential_damping: float  # N s/m, up to the friction limit
    place: wp.vec3  # m, where it starts, world; of one that is held, its middle in the frame of the body's joint
    orientation: wp.quat  # the same
    velocity: wp.vec3  # m/s, with which it starts
    spin: wp.vec3  # rad/s
    until: float  # s, when it is let go
    axis: wp.vec3  # unit vector, in its axes, of one that turns about an axis alone
    pivot: wp.vec3  # m, a point of that axis, in its axes from its middle
    bearing: float  # N m s/rad, damping of the axle


@wp.struct
class ObjectCapsule:
    """A shape of a body that may touch an object, as a capsule in the axes of the body, from its joint."""

    middle: wp.vec3  # m
    half: wp.vec3  # m, from there to the end of its segment
    radius: float  # m
    reach: float  # m, from the middle to its farthest point


@wp.struct
class ObjectExtension:
    """All objects of a scene."""

    row: wp.array2d[ObjectRow]  # (rows, objects)
    memory: wp.array3d[float]  # (instances, objects, MEMORY)
    fixed: wp.array[int]  # (objects,) 1: it does not move
    hinged: wp.array[int]  # (objects,) 1: it turns about an axis alone
    pairs: wp.array[wp.vec2i]  # of objects that push each other, by number
    holder: wp.array[int]  # (objects,) the body that holds it, -1: none
    first_pair: wp.array[int]  # (objects + 1,) of those with its number
    body: wp.array[int]  # (pairs,)
    capsule: wp.array2d[ObjectCapsule]  # (rows, pairs)


@wp.struct
class ObjectMotion:
    """Where an object is, and how it moves: in the middle of the step before."""

    place: wp.vec3  # m, of its middle
    orientation: wp.quat
    velocity: wp.vec3  # m/s
    spin: wp.vec3  # rad/s, world
    momentum: wp.vec3  # kg m^2/s, angular, about its middle


BEGUN, PLACE, ORIENTATION, VELOCITY, MOMENTUM = 0, 1, 4, 8, 11  # in the memory of an object; the last is angular
FREE, HELD = 1.0, 2.0  # what an object was in the step before, where it has begun
RECORDED = 13  # numbers of a frame, those before
PUSH, MOMENT = 14, 17  # of other objects in this step, N and N m about its middle
MEMORY = 20
