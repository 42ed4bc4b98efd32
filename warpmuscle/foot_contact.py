"""How the feet of a recorded walk meet the ground: how far they slide while they carry, and how deep they sink."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.bodies import contact_points
from warpmuscle.pose import conjugate, multiply, normalized, rotate
from warpmuscle.recording import Floats, Recording
from warpmuscle.scene import Scene
from warpmuscle.strides import SIDES, body_weight, feet_of

LOADED = 0.25  # body weights on a foot, from which on it is a stance foot that may not slide


class FootContact(NamedTuple):
    """How the feet met the ground, m; 0 for feet that never did."""

    mean_slide: float  # of the stance foot, the greatest slide of each step
    greatest_slide: float  # of all steps
    mean_drag: float  # of a foot that touches the ground but carries little, the greatest of each step
    depth: float  # of the lowest point that a foot came to below the ground


def foot_contact(recording: Recording, scene: Scene) -> FootContact:
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
    normal = normalized(np.array(scene.ground.normal, dtype=float))
    height = float(np.asarray(scene.ground.height).flat[0])
    slides: list[float] = []
    drags: list[float] = []
    depth = 0.0
    for side, foot in zip(SIDES, feet_of(scene), strict=True):
        loaded = recording[f"foot_force_{side}"] @ normal > LOADED * body_weight(scene)
        points = [_point(recording, *point, normal, height) for point in _points(scene, foot)]
        depth = max([depth, *(float(deep.max(initial=0.0)) for deep, _ in points)])
        for found, counts in ((slides, loaded), (drags, ~loaded)):
            slid = np.max([_slide((deep > 0.0) & counts, moved) for deep, moved in points], axis=0, initial=0.0)
            found += [float(np.broadcast_to(slid, len(loaded))[span].max()) for span in _spans(counts)]
    return FootContact(_mean(slides), max(slides, default=0.0), _mean(drags), depth)


def _points(scene: Scene, foot: str) -> list[tuple[str, Floats, float]]:
    """Body, place in its frame, m, and radius, m, of all points of a foot and its toes that may touch the ground."""
    bodies = [foot, *(joint.child for joint in scene.character.joints.values() if joint.parent == foot)]
    return [
        (body, np.array(place, dtype=float), float(radius))
        for body in bodies
        for shape in scene.character.bodies[body].shapes
        for place, radius in contact_points(shape)
    ]


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else 0.0


def _point(
    recording: Recording, body: str, place: Floats, radius: float, normal: Floats, height: float
) -> tuple[Floats, Floats]:
    """Depth (F,) of a point in the ground, m, and how far (F, 3) what touches it moved along it since the frame before.

    Args:
        place: centre of a sphere of this radius, in the body's frame.
    """
    index = recording.body_names.index(body)
    orientation = recording.body_orientation[:, index].astype(float)
    center = recording.body_position[:, index] + rotate(orientation, place)
    depth = height + radius - center @ normal
    moved = np.diff(center, axis=0, prepend=center[:1])
    if radius > 0.0:
        turn = multiply(orientation[1:], conjugate(orientation[:-1]))
        angle = 2.0 * turn[:, :3] * np.sign(turn[:, 3:])  # small between two frames
        moved[1:] += np.cross(angle, -radius * normal)
    return depth, moved - (moved @ normal)[:, None] * normal


def _slide(touching: NDArray[np.bool_], moved: Floats) -> Floats:
    """Distance (F,) of a point from where it came to touch, m; 0 while it does not."""
    slide = np.zeros(len(touching))
    for span in _spans(touching):
        path = np.cumsum(moved[span][1:], axis=0)
        slide[span][1:] = np.linalg.norm(path, axis=1)
    return slide


def _spans(true: NDArray[np.bool_]) -> list[Any]:
    """Slices in which an array (F,) is true without a break."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], true.astype(np.int8), [0]])))
    return [slice(int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]
