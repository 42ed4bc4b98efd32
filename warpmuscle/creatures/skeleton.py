"""Bodies and joints of a creature."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.creatures.description import Creature, Place, Segment, joint_of, mirrored, sided
from warpmuscle.scene import Body, Box, Capsule, Joint, Shape

JOINT_AXIS = (1.0, 0.0, 0.0)  # the axis of every joint, which rides on what the other one turns
SIDE_AXIS = (0.0, 0.0, 1.0)  # of joints that turn to the side, too
Quaternion = tuple[float, float, float, float]
UP = np.array([0.0, 1.0, 0.0])


def middle(segment: Segment) -> Floats:
    """The centre of mass of a segment on the left, or in the middle, m, in the standing pose."""
    return np.asarray(0.5 * (np.array(segment.start) + np.array(segment.end)))


def volume(segment: Segment) -> float:
    """m^3."""
    length, r = math.dist(segment.start, segment.end), segment.radius
    if segment.box:
        return 4.0 * r * r * (length + 2.0 * r)
    return math.pi * r * r * (length + 4.0 / 3.0 * r)


def mass(creature: Creature, segment: Segment) -> float:
    """kg."""
    if segment.mass is not None:
        return segment.mass
    return (segment.density or creature.density) * volume(segment)


def moments(segment: Segment, kg: float) -> tuple[float, float, float]:
    """Principal moments about the centre, kg m^2: across, along and across the segment; a box's about x, y, z."""
    length, r = math.dist(segment.start, segment.end), segment.radius
    if segment.box:
        a, b, c = 2.0 * r, 2.0 * r, length + 2.0 * r
        return (kg * (b * b + c * c) / 12.0, kg * (a * a + c * c) / 12.0, kg * (a * a + b * b) / 12.0)
    rod, caps = length, 4.0 / 3.0 * r
    along_rod, along_caps = 0.5 * r * r, 0.4 * r * r
    across_rod = 0.25 * r * r + rod * rod / 12.0
    across_caps = 0.4 * r * r + 0.25 * rod * rod + 0.375 * rod * r
    share = rod / (rod + caps)
    across = kg * (share * across_rod + (1.0 - share) * across_caps)
    return (across, kg * (share * along_rod + (1.0 - share) * along_caps), across)


def turn_from_up(direction: Floats) -> Quaternion:
    """The rotation that turns y to a direction."""
    d = normalized(direction)
    axis, cosine = np.cross(UP, d), float(UP @ d)
    if cosine < -1.0 + 1e-9:
        return (1.0, 0.0, 0.0, 0.0)
    return quaternion(normalized([*axis, 1.0 + cosine]))


def body(creature: Creature, segment: Segment, mirror: bool) -> Body:
    """The body of a segment, or of its mirror image."""
    start, end = (np.array(mirrored(p) if mirror else p) for p in (segment.start, segment.end))
    kg = mass(creature, segment)
    half = 0.5 * (end - start)
    shape: Shape = Capsule(start=place(-half), end=place(half), radius=segment.radius)
    if segment.box:
        corner = np.abs(half) + segment.radius
        shape = Box(low=place(-corner), high=place(corner))
    turned = (0.0, 0.0, 0.0, 1.0) if segment.box else turn_from_up(end - start)
    return Body(
        mass=rounded(kg), inertia=place(np.array(moments(segment, kg))), shapes=[shape], friction=segment.friction,
        inertia_axes=turned,
    )  # fmt: skip


def joint(creature: Creature, segment: Segment, parent: str, child: str, mirror: bool) -> Joint:
    """The joint that carries a segment, or its mirror image."""
    carrier = creature.segments[segment.parent]
    at = np.array(segment.start if segment.at is None else segment.at)
    places = [at - middle(carrier), at - middle(segment)]
    if mirror:
        flip = np.array([-1.0, 1.0, 1.0])
        other = middle(carrier) * flip if carrier.paired else middle(carrier)
        places = [at * flip - other, (at - middle(segment)) * flip]
    ends = [place(one) for one in places]
    if segment.range is None:
        return Joint(type="fixed", parent=parent, child=child, position_in_parent=ends[0], position_in_child=ends[1])
    if segment.side is None:
        return Joint(
            type="hinge", parent=parent, child=child, position_in_parent=ends[0], position_in_child=ends[1],
            axes=[JOINT_AXIS], limits=[segment.range], limit_stiffness=1000.0, limit_damping=5.0,
            damping=segment.damping,
        )  # fmt: skip
    low, high = segment.side
    outwards = (-high, -low) if mirror else (low, high)
    return Joint(
        type="universal", parent=parent, child=child, position_in_parent=ends[0], position_in_child=ends[1],
        axes=[JOINT_AXIS, SIDE_AXIS], limits=[segment.range, outwards], limit_stiffness=1000.0, limit_damping=5.0,
    )  # fmt: skip


def skeleton(creature: Creature) -> tuple[str, dict[str, Body], dict[str, Joint]]:
    """The name of the root, and all bodies and joints."""
    bodies: dict[str, Body] = {}
    joints: dict[str, Joint] = {}
    root = next(name for name, segment in creature.segments.items() if not segment.parent)
    for name, segment in creature.segments.items():
        for side in ("l", "r") if segment.paired else ("",):
            own = sided(name, side) if side else name
            bodies[own] = body(creature, segment, side == "r")
            if segment.parent:
                above = creature.segments[segment.parent]
                parent = sided(segment.parent, side) if above.paired else segment.parent
                called = joint_of(name, segment)
                key = sided(called, side) if side else called
                joints[key] = joint(creature, segment, parent, own, side == "r")
    return root, bodies, joints


def quaternion(numbers: ArrayLike) -> Quaternion:
    """Four numbers of a quaternion, rounded."""
    x, y, z, w = map(rounded, np.asarray(numbers))
    return (x, y, z, w)


def rounded(number: float) -> float:
    """Nine digits: what a file can show, free of rounding noise."""
    return float(f"{float(number):.9g}")


def place(vector: ArrayLike) -> Place:
    """Three numbers of a place, rounded, and without -0."""
    x, y, z = (0.0 if abs(v) < 1e-12 else rounded(v) for v in np.asarray(vector))
    return (x, y, z)
