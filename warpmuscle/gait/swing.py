"""What happens while a leg swings that hardly any objective asks for: clearance of the foot, arms, a calf at rest."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.gait.cycles import PERCENT, Strides, body_weight, over_strides, sagittal_angle
from warpmuscle.gait.foot_contact import SIDES, contacts_of
from warpmuscle.gait.foot_sliding import foot_points
from warpmuscle.gait.measures import feet_of
from warpmuscle.gait.muscle_timing import muscle_curves
from warpmuscle.gait.pelvis_and_trunk import segments
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints.symmetry import side_of
from warpmuscle.scene.masses import body_mass

CLEARANCE, ARMS, CALF = "clearance in mid-swing", "arm swing, range", "gastrocnemius in swing, of stance"
MIDDLE = (0.35, 0.65)  # of the time that a foot swings, in which toes come lowest, half-way in people (Winter 1992)
HEAVY = 0.01  # of the body's mass: an upper arm of people has 0.02 to 0.03


def swing_measures(
    recording: Recording, scene: Scene, cycles: dict[str, Strides], stance: float
) -> dict[str, float | None]:
    """Measures of the swing by name; none of what a body has not.

    Args:
        scene: without free parameters. stance: % of the gait cycle.
    """
    clear = clearances(recording, scene, cycles)
    found: dict[str, float | None] = {CLEARANCE: 100.0 * float(np.mean(clear)) if clear else None}
    if arms := arm_joints(scene):
        found[ARMS] = float(np.mean([_range(recording, joint, cycles[side]) for side, joint in arms.items()]))
    heads = muscle_curves(recording, recording.muscle_activation, cycles).get("gastrocnemius", [])
    if heads:
        found[CALF] = of_stance(np.mean(heads, axis=0), stance)
    return found


def clearances(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> list[float]:
    """How far the lowest point of a foot stays above the ground in the middle of each swing, m; below 0 if it scuffs.

    Swings are those that begin within the gait cycles. Feet without points that touch the ground have none.
    """
    found = []
    for side, foot in zip(SIDES, feet_of(scene), strict=True):
        depths = [point.depth for point in foot_points(recording, scene, foot)]
        if not depths:
            continue
        height = -np.max(depths, axis=0)
        begin, end = cycles[side][0][0], cycles[side][-1][1]
        times = contacts_of(recording, side, body_weight(scene))
        for lifted, landed in zip(
            (one.lift_off for one in times[:-1]), (one.touch_down for one in times[1:]), strict=True
        ):
            if lifted is None or landed is None or not begin <= lifted < end:
                continue
            first, last = (lifted + part * (landed - lifted) for part in MIDDLE)
            inside = (recording.time >= first) & (recording.time <= last)
            if inside.any():
                found.append(float(height[inside].min()))
    return found


def arm_joints(scene: Scene) -> dict[str, str]:
    """Joints of the upper arms by side: of the heaviest pair of bodies that hang on the trunk and are no legs."""
    trunk = segments(scene).get("Trunk")
    character = scene.character
    hanging = {name: joint for name, joint in character.joints.items() if joint.parent == trunk}
    sides = {name: side_of(name, character.joints) for name in hanging}
    least = HEAVY * body_mass(character)
    pairs: dict[str, str] = {}
    mass = {name: first_number(character.bodies[joint.child].mass) for name, joint in hanging.items()}
    for name in sorted(hanging, key=lambda name: mass[name]):  # heavier ones last
        if sides[name] and mass[name] > least:
            pairs[sides[name]] = name
    return {side: pairs[side] for side in SIDES} if len(pairs) == 2 else {}


def of_stance(curve: Floats, stance: float) -> float | None:
    """Mean of a curve (101,) over the swing, in % of that over the stance; None where that is 0."""
    swings = PERCENT[:-1] >= stance
    if not swings.any() or swings.all() or (carried := float(curve[:-1][~swings].mean())) <= 0.0:
        return None
    return 100.0 * float(curve[:-1][swings].mean()) / carried


def _range(recording: Recording, joint: str, cycles: Strides) -> float:
    """Range of the mean curve of a joint's turn about the mediolateral axis over the gait cycle, deg."""
    return float(
        np.degrees(np.ptp(over_strides(recording.time, sagittal_angle(recording, joint), cycles).mean(axis=0)))
    )
