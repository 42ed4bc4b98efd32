"""Where along the foot the ground pushes, from heel to toe."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.gait.cycles import body_weight, spans
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.foot_sliding import foot_points
from warpmuscle.gait.measures import feet_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import foot_bodies, joint_place
from warpmuscle.scene.geometry import contact_points

LOADED = 0.05  # body weights on a foot, from which on it has a centre of pressure
SHORTEST_STANCE = 5  # frames


def centre_of_pressure(recording: Recording, scene: Scene) -> dict[str, Floats]:
    """Centre of pressure (F,) along each foot by side, % of its length from the heel; NaN while it carries nothing.

    Each point that is in the ground counts as its depth, as its spring pushes, and stands where it is along the foot
    with straight toes, so that bent toes do not make the foot shorter.

    Args:
        scene: without free parameters.

    Raises:
        Error: the character has no feet.
    """
    found = {}
    for side, foot in zip(SIDES, feet_of(scene), strict=True):
        along = _along(scene, foot)
        depths = np.array([np.maximum(point.depth, 0.0) for point in foot_points(recording, scene, foot)])
        force = recording[f"foot_force_{side}"][:, 1] / body_weight(scene)
        pushed = depths.sum(axis=0)
        there = (force > LOADED) & (pushed > 0.0)
        middle = along @ depths / np.where(there, pushed, 1.0)
        found[side] = np.where(there, 100.0 * middle, np.nan)
    return found


def travel(centre: Floats) -> Floats:
    """How far a centre of pressure (F,) moves in each stance (S,), from its rearmost to its foremost place, in %."""
    stances = spans(np.isfinite(centre))
    return np.array([np.ptp(centre[span]) for span in stances if span.stop - span.start >= SHORTEST_STANCE])


def _along(scene: Scene, foot: str) -> Floats:
    """Places (P,) of the points of `foot_points` along the straight foot, 0 at the heel and 1 at the toe."""
    character = scene.character
    joints = {joint.child: joint for joint in character.joints.values()}
    places: list[float] = []
    ends: list[float] = []
    for name in foot_bodies(character, foot):
        joint = joints[name]
        moved = 0.0 if name == foot else float(joint_place(joint)[2]) - first_number(joint.position_in_child[2])
        for shape in character.bodies[name].shapes:
            for place, radius in contact_points(shape):
                at, size = float(place[2]) + moved, float(radius)
                places.append(at)
                ends += [at - size, at + size]
    heel, toe = min(ends, default=0.0), max(ends, default=1.0)
    return (np.array(places) - heel) / max(toe - heel, 1e-9)
