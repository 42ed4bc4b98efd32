"""How the feet of a recorded walk meet the ground: how far they slide while they carry, and how deep they sink."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.gait.cycles import body_weight, spans
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.measures import feet_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.terrain.surface import surface

LOADED = 0.25  # body weights on a foot, from which on it is a stance foot that may not slide


class FootSliding(NamedTuple):
    """How the feet met the ground, m; 0 for feet that never did."""

    mean_slide: float  # of the stance foot, the greatest slide of each step
    greatest_slide: float  # of all steps
    mean_drag: float  # of a foot that touches the ground but carries little, the greatest of each step
    depth: float  # of the lowest point that a foot came to below the ground


class FootPoint(NamedTuple):
    """A corner of a box, or the centre of a sphere, that may touch the ground."""

    body: int  # in the recording
    radius: float  # m, of the sphere; 0 of a corner
    position: Floats  # (F, 3) m, world
    depth: Floats  # (F,) m, in the ground


def foot_sliding(recording: Recording, scene: Scene) -> FootSliding:
    """Measure the contact of both feet with the ground.

    A point of a foot, a corner of a box or the lowest point of a sphere, slides from where it comes down: its slide is
    how far it goes along the ground from there, while it stays in the ground without a break and the foot carries at
    least a quarter of the body's weight. What a sphere rolls is no slide. The slide of a step is the greatest of all
    points of the foot and its toes, from when the foot takes up weight to when it gives it off again. Its drag is the
    same while the foot carries less than that: toes that are drawn over the ground before they leave it, or scuff it.

    Args:
        scene: without free parameters. recording: some 100 frames a second or more; else a short contact is missed.

    Raises:
        Error: the character has no feet.
    """
    ground = surface(scene.ground)
    normal = ground.plane.normal
    slides: list[float] = []
    drags: list[float] = []
    depth = 0.0
    for side, foot in zip(SIDES, feet_of(scene), strict=True):
        loaded = recording[f"foot_force_{side}"] @ normal > LOADED * body_weight(scene)
        points = foot_points(recording, scene, foot)
        moves = [_moved(recording, p, ground.normal_at(p.position[:, 0], p.position[:, 2])) for p in points]
        depth = max([depth, *(float(point.depth.max(initial=0.0)) for point in points)])
        for found, counts in ((slides, loaded), (drags, ~loaded)):
            slides_of = [_slide((p.depth > 0.0) & counts, moved) for p, moved in zip(points, moves, strict=True)]
            slid = np.max(slides_of, axis=0, initial=0.0)
            found += [float(np.broadcast_to(slid, len(loaded))[span].max()) for span in spans(counts)]
    return FootSliding(_mean(slides), max(slides, default=0.0), _mean(drags), depth)


def foot_points(recording: Recording, scene: Scene, foot: str) -> list[FootPoint]:
    """All points of a foot and its toes that may touch the ground of a numeric scene, over a motion."""
    ground = surface(scene.ground)
    found = []
    for name in foot_bodies(scene.character, foot):
        body = recording.body_names.index(name)
        orientation = recording.body_orientation[:, body].astype(float)
        for shape in scene.character.bodies[name].shapes:
            for place, radius in contact_points(shape):
                position = recording.body_position[:, body] + rotate(orientation, np.array(place, dtype=float))
                found.append(FootPoint(body, float(radius), position, float(radius) - ground.above(position)))
    return found


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else 0.0


def _moved(recording: Recording, point: FootPoint, normal: Floats) -> Floats:
    """How far (F, 3) what touches the ground moved along it since the frame before, m; what a sphere rolls is none.

    Args:
        normal: (F, 3) of the ground below the point.
    """
    moved = np.diff(point.position, axis=0, prepend=point.position[:1])
    if point.radius > 0.0:
        orientation = recording.body_orientation[:, point.body].astype(float)
        turn = multiply(orientation[1:], conjugate(orientation[:-1]))
        angle = 2.0 * turn[:, :3] * np.sign(turn[:, 3:])  # small between two frames
        moved[1:] += np.cross(angle, -point.radius * normal[1:])
    return np.asarray(moved - np.sum(moved * normal, axis=1, keepdims=True) * normal)


def _slide(touching: NDArray[np.bool_], moved: Floats) -> Floats:
    """Distance (F,) of a point from where it came to touch, m; 0 while it does not."""
    slide = np.zeros(len(touching))
    for span in spans(touching):
        path = np.cumsum(moved[span][1:], axis=0)
        slide[span][1:] = np.linalg.norm(path, axis=1)
    return slide
