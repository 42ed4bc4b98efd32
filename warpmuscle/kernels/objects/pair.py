"""What two objects do to each other where they touch: at corners of one on the other, and where a bar crosses it.

Corners are points of a ball or a capsule, too, with spheres about them; bars are capsules and edges of boxes. The force
acts on both, equal and opposite at one point, as of a body and an object, see `objects.touch`.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.contact.contact import friction_damping
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import MOMENT, PUSH, ObjectExtension, ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.bounce import bounce, eased
from warpmuscle.kernels.objects.hinge import object_mobility
from warpmuscle.kernels.objects.motion import is_held, motion_now
from warpmuscle.kernels.objects.shape import (
    LEVEL,
    TINY,
    between_on,
    beyond,
    corner,
    edge_middle,
    end_of_nearest,
    is_another,
    least_overlap,
    within,
)
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

SAME = 1.0e-6  # m, between two places that are one
END = 0.9999  # of a half bar, from which on it is its end


@wp.struct
class Side:
    """One of two objects."""

    row: ObjectRow
    motion: ObjectMotion
    moves: bool
    hinged: bool
    face: wp.vec3  # that is towards the other one, see `least_overlap`


@func
def side_of(
    instance: int, number: int, model: ModelRef, state: StateRef, work: ScratchRef, own: ObjectExtension
) -> Side:
    """An object as it is now."""
    s = Side()
    s.row = at(own.row, instance, number)
    s.motion = motion_now(instance, number, s.row, model, state, work, own)
    s.moves = own.fixed[number] == 0
    s.hinged = own.hinged[number] == 1
    return s


@func
def seen_from(point: wp.vec3, motion: ObjectMotion) -> wp.vec3:
    """A point of the world in the axes of an object from its middle, m."""
    return wp.quat_rotate_inv(motion.orientation, point - motion.place)


@func
def face_towards(a: Side, b: Side) -> wp.vec3:
    """The face of the first object, in its axes, out of which the second one has least far to go."""
    reach = wp.vec3(0.0)
    for axis in range(3):
        way = wp.vec3(0.0)
        way[axis] = 1.0
        along = wp.quat_rotate_inv(b.motion.orientation, wp.quat_rotate(a.motion.orientation, way))
        half = b.row.half
        reach[axis] = wp.abs(along[0]) * half[0] + wp.abs(along[1]) * half[1] + wp.abs(along[2]) * half[2]
    return least_overlap(seen_from(b.motion.place, a.motion), reach, a.row.half)


@func
def is_corner(point: wp.vec3, half: wp.vec3) -> bool:
    """Whether a point on a box is one of its corners."""
    rest = half - wp.vec3(wp.abs(point[0]), wp.abs(point[1]), wp.abs(point[2]))
    return wp.max(rest[0], wp.max(rest[1], rest[2])) <= SAME


@func
def keep_push(memory: wp.array[float], force: wp.vec3, arm: wp.vec3):
    """Add a force on an object, N, at so far from its middle, m, to those of this step."""
    moment = wp.cross(arm, force)
    for i in range(3):
        memory[PUSH + i] = memory[PUSH + i] + force[i]
        memory[MOMENT + i] = memory[MOMENT + i] + moment[i]


@func
def press(
    instance: int, first: int, second: int, a: Side, b: Side, own_point: wp.vec3, share: float, corners: int,
    model: ModelRef, own: ObjectExtension,
):  # fmt: skip
    """Let a point of one object, with the sphere about it, push another one.

    Args:
        own_point: m, in the axes of the first. share: of the stiffness and the friction that it has.
        corners: 1: both corners touch here if each is the nearest place of its object to the other one; 0: they do not,
            since the other object has seen it; 2: the point is none.
    """
    point = a.motion.place + wp.quat_rotate(a.motion.orientation, own_point)
    near = between_on(seen_from(point, b.motion), b.row.half, b.face)
    depth = a.row.radius + b.row.radius - near.distance
    if depth <= wp.where(corners == 2, SAME, 0.0):  # where an edge goes through the face, it does not push
        return
    if corners != 2 and is_corner(near.on_box, b.row.half):
        if corners == 0:
            return
        there = b.motion.place + wp.quat_rotate(b.motion.orientation, near.on_box)
        mine = seen_from(there, a.motion)
        on_first = between_on(mine, a.row.half, a.face)
        if wp.length(on_first.on_box - own_point) > 2.0 * SAME:
            return
    normal = wp.quat_rotate(b.motion.orientation, near.normal)  # from the second to the first
    place = point - normal * (a.row.radius - 0.5 * depth)
    arm_a = place - a.motion.place
    arm_b = place - b.motion.place
    velocity = a.motion.velocity + wp.cross(a.motion.spin, arm_a)
    velocity -= b.motion.velocity + wp.cross(b.motion.spin, arm_b)
    speed = wp.dot(normal, velocity)
    h = model.time_step
    both = wp.float32(0.0)
    if a.moves:
        both += object_mobility(normal, arm_a, a.row, a.motion, a.hinged)
    if b.moves:
        both += object_mobility(normal, arm_b, b.row, b.motion, b.hinged)
    stiffness = share * wp.min(a.row.stiffness, b.row.stiffness)
    pushed = bounce(depth, speed, stiffness, wp.max(a.row.damping_ratio, b.row.damping_ratio), both, h)
    if pushed.along <= 0.0:
        return
    pressing = eased(pushed.along, pushed.gives, both)
    force = normal * pressing
    slip = velocity - normal * speed
    slipping = wp.length(slip)
    if slipping > 0.0:
        way = slip / slipping
        damping = share * wp.min(a.row.tangential_damping, b.row.tangential_damping)
        across = friction_damping(pressing, slipping, damping, wp.min(a.row.friction, b.row.friction))
        both = wp.float32(0.0)
        if a.moves:
            both += object_mobility(way, arm_a, a.row, a.motion, a.hinged)
        if b.moves:
            both += object_mobility(way, arm_b, b.row, b.motion, b.hinged)
        force -= way * eased(across * slipping, h * across, both)
    keep_push(own.memory[instance, first], force, arm_a)
    keep_push(own.memory[instance, second], -force, arm_b)


@func
def is_bar(half: wp.vec3) -> bool:
    """Whether half edges are those of a capsule."""
    return half[0] <= 0.0 and half[2] <= 0.0 and half[1] > 0.0


@func
def press_bar(
    instance: int, first: int, second: int, a: Side, b: Side, model: ModelRef, own: ObjectExtension
):  # fmt: skip
    """Let a capsule push where it lies across an object: at both ends of what is over it, half as stiff each.

    A ball, or a corner, on which its side lies pushes by itself, see `press`.
    """
    if not is_bar(a.row.half):
        return
    half = a.row.half
    middle = seen_from(a.motion.place, b.motion)
    bar = wp.quat_rotate(a.motion.orientation, wp.vec3(0.0, half[1], 0.0))
    along = wp.quat_rotate_inv(b.motion.orientation, bar)
    for side in range(2):
        t = end_of_nearest(middle, along, b.row.half, wp.where(side == 0, -LEVEL, LEVEL))
        if wp.abs(t) < END:
            press(instance, first, second, a, b, wp.vec3(0.0, half[1] * t, 0.0), 0.5, 0, model, own)


@func
def press_edges(
    instance: int, first: int, second: int, a: Side, b: Side, model: ModelRef, own: ObjectExtension
):  # fmt: skip
    """Let edges of a box push another box: where one with an end inside comes out, or the middle of what crosses it.

    Ends inside are corners, which push by themselves. Each is half as stiff as a corner, since edges of both boxes push
    where two faces lie on each other in part, or two bars across each other.
    """
    half = a.row.half
    if half[0] <= 0.0 or half[2] <= 0.0 or b.row.half[0] <= 0.0 or b.row.half[2] <= 0.0:
        return
    for number in range(12):
        middle = edge_middle(number, half)
        along = wp.vec3(0.0)
        along[number // 4] = half[number // 4]
        there = seen_from(a.motion.place + wp.quat_rotate(a.motion.orientation, middle), b.motion)
        way = wp.quat_rotate_inv(b.motion.orientation, wp.quat_rotate(a.motion.orientation, along))
        inside = within(there, way, b.row.half)
        if inside[0] < inside[1]:
            first_in = wp.length(beyond(there - way, b.row.half)) <= TINY
            last_in = wp.length(beyond(there + way, b.row.half)) <= TINY
            t = 0.5 * (inside[0] + inside[1])
            if first_in:
                t = inside[1]
            elif last_in:
                t = inside[0]
            if not (first_in and last_in):
                press(instance, first, second, a, b, middle + along * t, 0.5, 2, model, own)


@cache
def push_each_other_of(pairs: int) -> Any:
    """The Warp function that puts into memories what objects do to each other in this step, before any moves."""

    @wp.func
    def push_each_other(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, own: wp.ref[ObjectExtension]
    ):
        for pair in range(pairs):
            for side in range(2):
                for i in range(6):
                    own.memory[instance, own.pairs[pair][side], PUSH + i] = 0.0
        for pair in range(pairs):
            first = own.pairs[pair][0]
            second = own.pairs[pair][1]
            a = side_of(instance, first, model, state, work, own)
            b = side_of(instance, second, model, state, work, own)
            reach = a.row.reach + b.row.reach
            held = is_held(instance, first, a.row, model, state, own)
            held = held or is_held(instance, second, b.row, model, state, own)
            if not held and wp.length_sq(a.motion.place - b.motion.place) < reach * reach:
                a.face = face_towards(a, b)
                b.face = face_towards(b, a)
                for number in range(8):
                    if is_another(number, a.row.half):
                        press(instance, first, second, a, b, corner(number, a.row.half), 1.0, 1, model, own)
                    if is_another(number, b.row.half):
                        press(instance, second, first, b, a, corner(number, b.row.half), 1.0, 0, model, own)
                press_bar(instance, first, second, a, b, model, own)
                if not is_bar(a.row.half):  # or else where two cross, both would push at the one place
                    press_bar(instance, second, first, b, a, model, own)
                press_edges(instance, first, second, a, b, model, own)
                press_edges(instance, second, first, b, a, model, own)

    return push_each_other
