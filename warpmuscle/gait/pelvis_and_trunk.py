"""How pelvis and trunk turn in a walk: tilt, obliquity and rotation against the way that the body goes."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import rotate
from warpmuscle.gait.cycles import Strides, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.measures import heading
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg, leg_joints

TURNS = ("tilt", "obliquity", "rotation")
SHORTEST = 0.1  # m, from which on the way of a stride has a direction


def segments(scene: Scene) -> dict[str, str]:
    """Bodies of pelvis and trunk: what the hips hang on, and the heaviest other body that is no part of a leg.

    There is no trunk where nothing heavy is above the pelvis, and neither without legs.
    """
    if scene.feet is None or len(leg_joints(scene, 0)) < 3:
        return {}
    character = scene.character
    pelvis = character.joints[leg_joints(scene, 0)[0]].parent
    legs = {character.joints[name].child for foot in scene.feet for name in leg(character, foot)}
    above = {joint.child for joint in character.joints.values() if joint.parent == pelvis} - legs
    masses = {name: first_number(character.bodies[name].mass) for name in above}
    trunk = max(masses, key=lambda name: masses[name], default=None)
    heavy = trunk is not None and masses[trunk] > 0.1 * sum(
        first_number(body.mass) for body in character.bodies.values()
    )
    return {"Pelvis": pelvis} | ({"Trunk": trunk} if heavy and trunk is not None else {})


def turn_curves(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> dict[str, list[Floats]]:
    """Mean curves (101,) over the gait cycles of each side, degrees: "Pelvis tilt", "Pelvis obliquity" and so on.

    They turn about the vertical first (rotation), then about the way forwards (obliquity), then about the mediolateral
    axis (tilt), as clinics count (Baker 2001, Hum. Mov. Sci. 20:655). Tilt is positive forwards; obliquity and rotation
    are positive where the side of the cycle is up, and where it is in front. The way is that of each stride, along
    which the centre of mass goes; in place, where the root looks in the mean.
    """
    every = stride_turns(recording, scene, cycles)
    return {name: [sides[side].mean(axis=0) for side in SIDES] for name, sides in every.items()}


def stride_turns(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> dict[str, dict[str, Floats]]:
    """The same by side, a row (101,) for each cycle."""
    found: dict[str, dict[str, Floats]] = {}
    for segment, body in segments(scene).items():
        orientation = recording.body_orientation[:, recording.body_names.index(body)].astype(float)
        of_sides = {side: _of_side(recording, orientation, cycles[side], side) for side in SIDES}
        for k, turn in enumerate(TURNS):
            found[f"{segment} {turn}"] = {side: turns[:, :, k] for side, turns in of_sides.items()}
    return found


def _of_side(recording: Recording, orientation: Floats, cycles: Strides, side: str) -> Floats:
    """Tilt, obliquity and rotation (S, 101, 3) in a side's cycles."""
    strides, sign = [], 1.0 if side == "left" else -1.0
    for stride in cycles:
        ends = over_strides(recording.time, recording.com.astype(float), [stride])[0][[0, -1]]
        way = (ends[1] - ends[0])[[0, 2]]
        turned = over_strides(recording.time, heading(recording), [stride])[0].mean()
        course = float(np.arctan2(*way)) if np.linalg.norm(way) > SHORTEST else turned
        # backwards the body still looks where its root does
        course += np.pi if np.cos(course - turned) < 0.0 else 0.0
        strides.append(over_strides(recording.time, _turns(orientation, course), [stride])[0])
    return np.asarray(strides) * [1.0, sign, -sign]


def _turns(orientation: Floats, course: float) -> Floats:
    """Tilt, obliquity, left side up, and rotation to the left (F, 3), deg, of a body against a course, rad."""
    left, forwards = (rotate(orientation, np.array(axis)) for axis in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    obliquity = np.arcsin(np.clip(left[:, 1], -1.0, 1.0))
    rotation = np.arctan2(-left[:, 2], left[:, 0]) - course
    rotation = (rotation + np.pi) % (2.0 * np.pi) - np.pi
    up = rotate(orientation, np.array([0.0, 1.0, 0.0]))
    tilt = np.arctan2(-forwards[:, 1], up[:, 1])
    return np.asarray(np.degrees(np.stack([tilt, obliquity, rotation], axis=1)))
