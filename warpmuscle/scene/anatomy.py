"""A character as lines and outlines to draw, a small picture of them, and its legs as chains of joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Box, Capsule, Character, Joint, Scene, Shape
from warpmuscle.scene.initial_pose import initial_pose, plain_vector, world_poses
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import massless
from warpmuscle.scene.parameters import at_start

Side = Literal["left", "right", "middle"]
BONE_RADIUS = 0.017  # m
HEIGHT, EDGE = 150, 6  # px, of the picture
BONE, MUSCLE = "#8a949e", "#2f69cf"
STRAIGHT = float(np.cos(np.radians(30.0)))  # between thigh and shank; models of people have at most 12 degrees
LEG = ("hip", "knee", "ankle")
_MIDDLE = 0.02  # m, bodies this close to the plane of symmetry belong to no side


@dataclass(frozen=True)
class Piece:
    """Something to draw, fixed to a body: a polyline, or the outline of spheres and all between them."""

    body: str
    side: Side
    points: Floats  # (n, 3) m, in the body's frame
    outline: bool = False
    radii: Floats | float = 0.0  # (n,) m, of the spheres


def bone_lines(character: Character, name: str) -> list[Floats]:
    """Bones (2, 3), m, of a body: from its joint to its children's, or into the shapes of a body that has none.

    A body without mass and shapes is a place between joints, or the world, and has no bones.
    """
    body = character.bodies[name]
    if not body.shapes and massless(body):
        return []
    joints = character.joints.values()
    start = next((first_row(joint.position_in_child) for joint in joints if joint.child == name), np.zeros(3))
    ends = [joint_place(joint) for joint in joints if joint.parent == name]
    return bones(start, ends or [far_end(shape, start) for shape in body.shapes])


def pieces(character: Character, feet: Sequence[str]) -> list[Piece]:
    """Pieces of a numeric character: bones between joints, outlines of the feet and of limb ends."""
    sides = sides_of(character)
    found: list[Piece] = []
    for name, body in character.bodies.items():
        if any(foot in _ancestors(character, name) for foot in feet):
            ends = [tuple(joint_place(joint)) for joint in character.joints.values() if joint.parent == name]
            starts = [joint.position_in_child for joint in character.joints.values() if joint.child == name]
            reach = [first_row(place) for place in (*(starts or [(0.0, 0.0, 0.0)]), *ends)]  # so that leg and toes meet
            found += [_outline(name, sides[name], shape, reach) for shape in body.shapes]
            continue
        found += [Piece(name, sides[name], line) for line in bone_lines(character, name)]
        if all(joint.parent != name for joint in character.joints.values()):
            found += [_outline(name, sides[name], shape, []) for shape in body.shapes if not isinstance(shape, Capsule)]
    return found


def bones(start: Floats, ends: Sequence[Floats]) -> list[Floats]:
    """Lines from a joint to others; a body with several has them branch off in their middle."""
    if len(ends) < 2:
        return [np.stack([start, end]) for end in ends]
    hub = np.mean(ends, axis=0)
    return [np.stack([end, hub]) for end in (start, *ends)]


def leg(character: Character, foot: str) -> list[str]:
    """Joints from the root down to the foot."""
    names: list[str] = []
    parents = {joint.child: (name, joint.parent) for name, joint in character.joints.items()}
    while foot in parents:
        name, foot = parents[foot]
        names.insert(0, name)
    return names


def leg_joints(scene: Scene, side: int) -> list[str]:
    """Hip, knee and ankle of the left leg (0) or the right: pairs or joints that are called so, or the last three.

    Hinges with nothing but massless bodies between them count as one joint, that about the mediolateral axis. Joints
    that hold still do not count, nor below the ankle hinges that turn about other axes, such as a subtalar joint.
    There are fewer if fewer lead to the foot; none if there are no feet.
    """
    pairs = scene.pairs
    if all(name in pairs for name in ("Hip", "Knee", "Ankle")):
        return [pairs[name][side] for name in ("Hip", "Knee", "Ankle")]
    if scene.feet is None:
        return []
    bending = _bending(scene.character, leg(scene.character, scene.feet[side]))
    letter = "lr"[side]
    named = [name for word in LEG for name in bending if name.lower() in (letter + word, f"{word}_{letter}")]
    if len(named) == len(LEG):
        return named
    while len(bending) > 3 and _turns_otherwise(scene.character.joints[bending[-1]]):
        del bending[-1]
    return bending[-3:]


def _turns_otherwise(joint: Joint) -> bool:
    """Whether a joint is a hinge whose axis is nearer to another direction than to the mediolateral one."""
    return joint.type == "hinge" and _along_x(joint) < np.sqrt(0.5)


def _bending(character: Character, joints: Sequence[str]) -> list[str]:
    """Of joints one below the other, of each row through massless bodies that which turns most about x."""
    rows_of: list[list[str]] = []
    light = False  # whether there are only massless bodies below the last joint that moves, welded to each other or not
    for name in joints:
        joint = character.joints[name]
        below = massless(character.bodies[joint.child])
        if not joint_type(joint).speeds:
            light = light and below
            continue
        if rows_of and light:
            rows_of[-1].append(name)
        else:
            rows_of.append([name])
        light = below
    return [max(row, key=lambda name: _along_x(character.joints[name])) for row in rows_of]


def _along_x(joint: Joint) -> float:
    """How much of the first axis that a joint turns about points to a side; 0 of one without axes."""
    axes = [*joint.axes, *(rotation.axis for rotation in joint.rotations)]
    return abs(first_number(axes[0][0])) if axes else 0.0


def joint_place(joint: Joint) -> Floats:
    """Where a joint of a numeric scene is in its parent in the reference pose, m: (3,)."""
    kind = joint_type(joint)
    place = first_row(joint.position_in_parent)
    if kind.by_coordinate:
        still = np.zeros((1, 1))
        place = place + kind.motion(joint, still, still).place[0]
    return place


def straight_legs(scene: Scene) -> bool:
    """Whether the legs of a numeric scene are straight where all angles are 0, as those are that norms are of.

    Legs of crouched animals begin to bend from another pose, so that their angles say nothing beside people's. One that
    is not straight is enough; a leg without a hip, a knee and an ankle is none.
    """
    start = msgspec.structs.replace(scene.initial_state, joints={})
    poses, _ = initial_pose(msgspec.structs.replace(scene, initial_state=start))
    for side in (0, 1):
        joints = [scene.character.joints[name] for name in leg_joints(scene, side)]
        if len(joints) < 3:
            continue
        places = [first_row(joint.position_in_child) for joint in joints]
        bodies = [poses[joint.child] for joint in joints]
        hip, knee, ankle = (at + rotate(turn, place) for (at, turn), place in zip(bodies, places, strict=True))
        thigh, shank = knee - hip, ankle - knee
        if thigh @ shank < STRAIGHT * float(np.linalg.norm(thigh) * np.linalg.norm(shank)):
            return False
    return True


def foot_bodies(character: Character, foot: str) -> list[str]:
    """A foot and the bodies that hang on it, such as its toes."""
    return [foot, *(joint.child for joint in character.joints.values() if joint.parent == foot)]


def convex_hull(points: Floats) -> Floats:
    """Corners (m, 2) of the convex hull of points (n, 2), counter-clockwise and closed (Andrew's monotone chain)."""
    ordered = sorted(map(tuple, points.tolist()))
    halves = []
    for way in (ordered, ordered[::-1]):
        half: list[tuple[float, ...]] = []
        for point in way:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0.0:
                half.pop()
            half.append(point)
        halves += half[:-1]
    return np.array([*halves, ordered[0]])


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    """Twice the signed area of the triangle a, b, c."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _ancestors(character: Character, body: str) -> list[str]:
    """The body and all bodies between it and the root."""
    return [body, *(character.joints[name].parent for name in leg(character, body))]


def sides_of(character: Character) -> dict[str, Side]:
    """Which side of the plane x = 0 each body is on in the reference pose; x points to the left."""
    sides: dict[str, Side] = {}
    for body in character.bodies:
        joints = [character.joints[name] for name in leg(character, body)]
        x = sum(first_row(joint.position_in_parent)[0] - first_row(joint.position_in_child)[0] for joint in joints)
        sides[body] = "left" if x > _MIDDLE else "right" if x < -_MIDDLE else "middle"
    return sides


def _outline(body: str, side: Side, shape: Shape, reach: Sequence[Floats]) -> Piece:
    """Outline of a shape, stretched to hold the points of `reach`, which do not touch the ground and have no radius."""
    radius = 0.0
    if isinstance(shape, Box):
        corners = np.array([first_row(shape.low), first_row(shape.high)])
        points = np.stack(np.meshgrid(*corners.T, indexing="ij"), axis=-1).reshape(-1, 3)
    else:
        radius = first_number(shape.radius)
        ends = (shape.start, shape.end) if isinstance(shape, Capsule) else (shape.center,)
        points = np.array([first_row(end) for end in ends])
    radii = np.repeat([radius, 0.0], [len(points), len(reach)])
    return Piece(body, side, np.array([*points, *reach], dtype=float), outline=True, radii=radii)


def far_end(shape: Shape, start: Floats) -> Floats:
    """Where a bone that begins at `start` ends: the far end of a capsule, the middle of another shape."""
    if isinstance(shape, Capsule):
        return max(first_row(shape.start), first_row(shape.end), key=lambda end: float(np.linalg.norm(end - start)))
    if isinstance(shape, Box):
        return first_row(shape.low) / 2.0 + first_row(shape.high) / 2.0
    return first_row(shape.center)


def picture(scene: Scene) -> str:
    """SVG of bones and muscles at the start, from the left side; empty where there is neither."""
    numeric = at_start(scene)
    poses, character = world_poses(numeric), numeric.character
    lines: list[tuple[str, float, Floats]] = []
    for name in character.bodies:
        place, turn = poses[name]
        lines += [(BONE, 3.0, place + rotate(turn, line)) for line in bone_lines(character, name)]
    for muscle in character.muscles.values():
        places = [(poses[point.body], plain_vector(point.place())) for point in muscle.path]
        path = np.array([place + rotate(turn, own) for (place, turn), own in places]).reshape(-1, 3)
        lines.append((MUSCLE, 1.2, path))
    lines = [(color, width, points[:, [2, 1]]) for color, width, points in lines if len(points) > 1]
    if not lines:
        return ""
    everything = np.concatenate([points for _, _, points in lines])
    low, size = everything.min(axis=0), np.maximum(np.ptp(everything, axis=0), 1e-3)
    scale = (HEIGHT - 2 * EDGE) / float(size.max())
    wide, tall = (2 * EDGE + scale * size).round().astype(int)
    drawn = "".join(
        f'<polyline points="{_points(EDGE + scale * (points - low), tall)}" stroke="{color}" stroke-width="{width}"/>'
        for color, width, points in lines
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{tall}" fill="none" stroke-linecap="round" '
        f'role="img" aria-label="the body at the start">{drawn}</svg>'
    )


def _points(places: Floats, tall: int) -> str:
    return " ".join(f"{x:.1f},{tall - y:.1f}" for x, y in places)
