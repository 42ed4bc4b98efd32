"""Where the path of a muscle runs in a pose, on the host: its points, what it goes round, and its length."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import from_rotation_vector, normalized, rotate
from warpmuscle.scene import (
    Character,
    CylinderSurface,
    EllipsoidSurface,
    Muscle,
    SphereSurface,
    Surface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.validation.paths import has_rows, shares
from warpmuscle.scene.wrapping.cylinder import AMONG_OTHERS, EXACT, IN_PLANE, cylinder_touch
from warpmuscle.scene.wrapping.ellipsoid import ellipsoid_touch
from warpmuscle.scene.wrapping.mujoco import mujoco_touch
from warpmuscle.scene.wrapping.path import Placed, Stop, wrapped
from warpmuscle.scene.wrapping.rows import laid
from warpmuscle.scene.wrapping.sphere import sphere_touch
from warpmuscle.scene.wrapping.torus import torus_touch
from warpmuscle.scene.wrapping.touch import Touch

MUJOCO = 3  # beside those of `cylinder.py`: between the points of a wrap alone, as MuJoCo has it

Poses = Mapping[str, tuple[Floats, Floats]]  # position, m, and orientation of every body
Angles = Mapping[str, Floats]  # coordinates of every joint


def route_stops(character: Character, muscle: Muscle, poses: Poses, angles: Angles) -> list[Stop]:
    """What a path of points runs through, in order.

    Conditional points count where their coordinate is within its interval, without the blend about both ends.

    Args:
        character: checked, without free parameters.
        muscle: one of its own that has a path.
    """
    points = [_place(point, poses, angles) for point in muscle.path]
    active = [_counts(point, angles) for point in muscle.path]
    exact = character.wrapping in ("shortest", "mujoco")
    where = (
        MUJOCO
        if character.wrapping == "mujoco"
        else EXACT
        if exact
        else AMONG_OTHERS
        if len(muscle.wraps) > 1
        else IN_PLANE
    )
    surfaces = [_placed(character, muscle, wrap, poses, where) for wrap in muscle.wraps]
    rows = character.wrapping == "mujoco" and has_rows(muscle)
    stops = laid(points, surfaces) if rows else wrapped(points, active, surfaces, exact)
    return _shared(stops, muscle) if muscle.branches else stops


def _shared(stops: list[Stop], muscle: Muscle) -> list[Stop]:
    """The stops with what the way to each counts, which is that of the point which follows a surface."""
    own, share, found = shares(muscle), 1.0, []
    for stop in reversed(stops):
        share = float(own[stop.point]) if stop.point >= 0 else share
        found.append(replace(stop, share=share))
    return found[::-1]


def half_of(surface: Surface) -> tuple[int, int]:
    """Axis and sign of the half of a surface that a path must stay on; sign 0: both."""
    return ("xyz".index(surface.side[1]), int(f"{surface.side[0]}1")) if surface.side else (0, 0)


def touch(surface: Surface, method: str, where: int, a: Floats, b: Floats, smooth: bool = False) -> Touch:
    """How a segment from a to b, in the axes of a surface, goes round it; see `Wrap.method` and `cylinder.py`."""
    if isinstance(surface, CylinderSurface | SphereSurface) and where == MUJOCO:
        point = None if surface.side_point is None else plain_vector(surface.side_point)
        return mujoco_touch(a, b, plain_number(surface.radius), point, isinstance(surface, SphereSurface))
    as_opensim = not smooth and where in (IN_PLANE, AMONG_OTHERS)
    if isinstance(surface, CylinderSurface):
        sizes = plain_number(surface.radius), plain_number(surface.length)
        return cylinder_touch(a, b, *sizes, *half_of(surface), where, smooth, as_opensim)
    if isinstance(surface, SphereSurface):
        return sphere_touch(a, b, plain_number(surface.radius), *half_of(surface), smooth)
    if isinstance(surface, EllipsoidSurface):
        return ellipsoid_touch(a, b, plain_vector(surface.radii), *half_of(surface), method, smooth, as_opensim)
    radii = plain_number(surface.inner_radius), plain_number(surface.outer_radius)
    return torus_touch(a, b, *radii, *half_of(surface), where, as_opensim)


def _place(point: ViaPoint, poses: Poses, angles: Angles) -> Floats:
    """Place of a point, m, in a pose."""
    local = plain_vector(point.place())
    for motion in point.motion:
        q = np.atleast_1d(angles[motion.joint])[:1]
        if motion.within:
            q = np.clip(q, motion.within[0], motion.within[1])
        moved = rates(motion, q)[0]
        local = local + normalized(plain_vector(motion.axis)) * moved
    position, orientation = poses[point.body]
    return np.asarray(position + rotate(orientation, local))


def _counts(point: ViaPoint, angles: Angles) -> bool:
    """Whether a path runs through a point."""
    c = point.condition
    return c is None or plain_number(c.low) <= float(angles[c.joint][c.axis]) <= plain_number(c.high)


def _placed(character: Character, muscle: Muscle, wrap: Wrap, poses: Poses, where: int) -> Placed:
    """A surface in a pose."""
    surface = character.surfaces[wrap.surface]
    position, turn = poses[surface.body]
    axes = rotate(turn, rotate(from_rotation_vector(plain_vector(surface.orientation)), np.eye(3)))
    center = position + rotate(turn, plain_vector(surface.position))
    return Placed(
        partial(touch, surface, wrap.method, where, smooth=character.wrapping == "smooth"),
        axes.T,
        center,
        wrap.surface,
        (wrap.first or 1) - 1,
        (wrap.last or len(muscle.path)) - 1,
        _start(surface, center, axes.T),
    )


def _start(surface: Surface, center: Floats, rotation: Floats) -> Floats | None:
    """The place of a surface that is nearest to its side point, None without one; one in the middle is its own."""
    if not isinstance(surface, CylinderSurface | SphereSurface) or surface.side_point is None:
        return None
    point = plain_vector(surface.side_point)
    out = point * [1.0, 1.0, 0.0] if isinstance(surface, CylinderSurface) else point
    far = float(np.linalg.norm(out))
    outward = plain_number(surface.radius) / far - 1.0 if far > 0.0 else 0.0
    return np.asarray(center + rotation @ (point + out * outward))
