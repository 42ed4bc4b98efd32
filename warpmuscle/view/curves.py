"""Curves over time to plot below a replay: all that was recorded of joints, muscles, feet and body; numbers only."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.gait.cycles import ALONG_X, along_x, flexion_signs
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Character, Scene
from warpmuscle.scene.anatomy import Side, joint_place, leg_joints
from warpmuscle.scene.force import power_name
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.joints import joint_type
from warpmuscle.view.bones.limbs import Limbs

LEG_TITLES = ("hip flexion", "knee flexion", "ankle dorsiflexion")
# Turns of a trunk on the pelvis about x, which points to the left, y upwards and z ahead: all are positive.
TRUNK_TITLES = {"x": "trunk flexion", "y": "trunk rotation to the left", "z": "trunk bending to the right"}
WORDS = {
    "mtp": "metatarsophalangeal", "elev": "elevation", "elv": "elevation", "flex": "flexion", "ext": "extension",
    "add": "adduction", "rot": "rotation", "dev": "deviation",
}  # that names of joints and coordinates shorten  # fmt: skip
BESIDE = {"l": "left", "r": "right"}
MIDDLE = 0.03  # m, from the plane of symmetry, of what is a neck rather than a shoulder
ALONG_Z = 0.8  # of a unit axis, about which a leg or a foot turns inwards and outwards
STANDING = 1e-3  # rad/s, below which the power of a device says nothing of its torque
FULL_FORCE = 1.5  # f_max, that the page stores as the greatest force of a muscle


class Stored(NamedTuple):
    """Where the page has a curve already: a column of one of a track's arrays, times a factor."""

    array: str
    column: int
    factor: float = 1.0


@dataclass(frozen=True)
class Line:
    """One curve of a panel."""

    name: str
    side: Side
    values: Floats  # (F,)
    stored: Stored | None = None


@dataclass(frozen=True)
class Panel:
    """Curves in common axes, of the left and the right side where there are both."""

    group: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    joint: str = ""  # whose first component the first line is, if it is one


Curves = dict[str, tuple[Floats, Stored | None]]


def panels_of(recording: Recording, scene: Scene, everything: bool = False) -> list[Panel]:
    """All panels of a recording and its scene without free parameters, group by group.

    Angles are a joint's own, of a ball joint turns about the child's x, then y, then z axis; torques act on the child,
    about the same axes, of a ball joint those of the parent. Flexion of hips, knees and ankles is positive, and so is a
    torque towards it (see `leg_curves`). Forces of muscles are clipped at `FULL_FORCE` f_max, as the page has them.
    Torques that nobody wanted and forces on feet that never touch the ground are left out but for `everything`. The
    power of a device, W, is positive where it gives energy to the body; the torque of one at a joint is that over the
    joint's speed, with the signs of the joint's own.
    """
    legs = leg_curves(scene)
    groups = [*_muscles(recording, scene), *_devices(recording, scene, legs), *_body(recording)]
    titles = {key: title for key, (title, _) in legs.items()}
    panels = [
        replace(panel, title=_in_full(panel.title))
        for group in _joints(recording, scene, legs, everything)
        for panel in _panels(*group, titles)
    ]
    panels += [panel for group in groups for panel in _panels(*group, titles)]
    return panels + _ground_forces(recording, everything)


LegCurves = Mapping[str, tuple[str, float]]  # as `leg_curves` has them
Group = tuple[str, str, Curves, Mapping[str, str]]  # name, unit, curves, and joints of first components by curve


def _joints(recording: Recording, scene: Scene, legs: LegCurves, everything: bool) -> Iterator[Group]:
    """Angles or positions, and torques or forces, that act and that were wanted."""
    shown: dict[str, tuple[Curves, Curves, Curves]] = {"rad": ({}, {}, {}), "m": ({}, {}, {})}
    first: dict[str, str] = {}
    orientations = dict(zip(recording.body_names, np.moveaxis(recording.body_orientation, 1, 0), strict=True))
    numbers = {name: number for number, name in enumerate(recording.joint_names)}
    for name in filter(numbers.__contains__, _limb_by_limb(scene.character)):
        number = numbers[name]
        joint = scene.character.joints[name]
        kind, own = joint_type(joint), joint_angles(recording, scene.character, name)
        if kind.unit(joint) == "rad":
            own = np.unwrap(own, axis=0)  # an elbow that bends past 180 degrees does not jump to -180
        to_parent, factor = conjugate(orientations[joint.parent]), np.degrees(1.0) if kind.unit(joint) == "rad" else 1.0
        torques = (-recording.joint_torque[:, number], -recording.joint_torque_desired[:, number])
        acting = [kind.components(joint, rotate(to_parent, torque)) for torque in torques]
        for axis, word in enumerate(kind.angles):
            key = f"{name} {word}".strip()
            sign = legs[key][1] if key in legs else 1.0
            values = (factor * own[:, axis], *(one[:, axis] for one in acting))
            for curves, value in zip(shown[kind.unit(joint)], values, strict=True):
                curves[key] = (sign * value, None)
            if axis == 0:
                first[key] = name
    yield "angles", "°", shown["rad"][0], first
    yield "positions", "m", shown["m"][0], {}
    yield "torques", "N m", shown["rad"][1], {}
    yield "forces", "N", shown["m"][1], {}
    wanted = [(key, values) for key, (values, _) in shown["rad"][2].items() if everything or np.any(values)]
    stored: Curves = {key: (values, Stored("wanted", column)) for column, (key, values) in enumerate(wanted)}
    yield "desired torques", "N m", stored, {}


def leg_curves(scene: Scene) -> dict[str, tuple[str, float]]:
    """What curves of hips, knees and ankles are called in anatomy, and the sign that makes them so, by joint and axis.

    Flexion and dorsiflexion are about the first axis. Of hips that are ball joints turns about y and z are rotation,
    positive inwards, and abduction, positive away from the other leg; so it is about the second of two axes, if that
    points ahead. Of ankles such a turn is inversion, positive where the sole looks at the other foot. Toes flex towards
    the sole.
    """
    found: dict[str, tuple[str, float]] = {}
    for name, sign in flexion_signs(scene).items():
        side = next(number for number in (0, 1) if name in leg_joints(scene, number))
        place = leg_joints(scene, side).index(name)
        kind = joint_type(scene.character.joints[name])
        words = list(kind.angles)
        found[f"{name} {words[0]}".strip()] = LEG_TITLES[place], sign
        if place == 2:
            found |= _toe_curves(scene.character, scene.character.joints[name].child)
        if place == 0 and words == ["x", "y", "z"]:
            outwards = 1.0 if side == 0 else -1.0
            found |= {f"{name} y": ("hip rotation", -outwards), f"{name} z": ("hip abduction", outwards)}
        ahead = first_number(scene.character.joints[name].axes[1][2]) if words == ["a", "b"] else 0.0
        if abs(ahead) > ALONG_Z and place != 1:  # which lifts a left leg outwards, and the outer edge of a left foot
            outwards = float(np.sign(ahead)) * (1.0 if side == 0 else -1.0)
            found[f"{name} b"] = ("hip abduction", outwards) if place == 0 else ("ankle inversion", -outwards)
    return found | _trunk_curves(scene) | _arm_curves(scene)


def _toe_curves(character: Character, foot: str) -> dict[str, tuple[str, float]]:
    """The same of the only hinge across a foot that hangs on it, or on a body below it: it bends the toes."""
    below = [foot]
    found: dict[str, tuple[str, float]] = {}
    for body in below:
        for name, joint in character.joints.items():
            if joint.parent == body:
                below.append(joint.child)
                words, along = joint_type(joint).angles, along_x(joint)
                if len(words) == 1 and abs(along) > ALONG_X:
                    found[f"{name} {words[0]}".strip()] = "toe flexion", float(np.sign(along))
    return found if len(found) == 1 else {}


def _arm_curves(scene: Scene) -> dict[str, tuple[str, float]]:
    """The same of shoulders that are ball joints, whose arms point aside in the reference pose, and of their elbows.

    Flexion of a shoulder lifts the arm ahead, rotation is positive inwards, and abduction is 0 of an arm that points
    aside and -90 degrees of one that hangs. Flexion of an elbow is what its limits leave most room for.
    """
    if not scene.feet:
        return {}
    joints, limbs = scene.character.joints, Limbs(scene.character, scene.feet)
    found: dict[str, tuple[str, float]] = {}
    arms: set[str] = set()
    for name, joint in joints.items():
        place = first_row(joint.position_in_child)
        aside = abs(place[0]) > ALONG_Z * float(np.linalg.norm(place))
        if limbs.role(joint.child) == "upper arm" and list(joint_type(joint).angles) == ["x", "y", "z"] and aside:
            arms.add(joint.child)
            outwards = 1.0 if place[0] < 0.0 else -1.0  # from its joint a left arm points to the left, along x
            found |= {f"{name} x": ("shoulder flexion", -1.0), f"{name} y": ("shoulder rotation", -outwards),
                      f"{name} z": ("shoulder abduction from level", outwards)}  # fmt: skip
    for name, joint in joints.items():
        if joint.parent in arms and limbs.role(joint.child) == "forearm" and len(joint.limits) == 1:
            low, high = (first_number(limit) for limit in joint.limits[0])
            words = list(joint_type(joint).angles)
            found[f"{name} {words[0]}".strip()] = "elbow flexion", 1.0 if abs(high) > abs(low) else -1.0
    return found


def _trunk_curves(scene: Scene) -> dict[str, tuple[str, float]]:
    """The same of a ball joint between the body that both legs hang on and a trunk above it."""
    legs = [leg_joints(scene, number) for number in (0, 1)] if scene.feet else []
    joints = scene.character.joints
    if not all(legs) or not legs or len({joints[leg[0]].parent for leg in legs}) > 1:
        return {}
    pelvis, hips = joints[legs[0][0]].parent, {leg[0] for leg in legs}
    above = [name for name, joint in joints.items() if joint.parent == pelvis and name not in hips]
    words = list(joint_type(joints[above[0]]).angles) if len(above) == 1 else []
    if words != ["x", "y", "z"]:
        return {}
    trunk = joints[above[0]].child
    necks = [name for name, joint in joints.items() if joint.parent == trunk and abs(joint_place(joint)[0]) < MIDDLE]
    found = {f"{above[0]} {word}": (title, 1.0) for word, title in TRUNK_TITLES.items()}
    if len(necks) == 1 and list(joint_type(joints[necks[0]]).angles) == words:
        found |= {f"{necks[0]} {word}": (title.replace("trunk", "neck"), 1.0) for word, title in TRUNK_TITLES.items()}
    return found


def _limb_by_limb(character: Character) -> list[str]:
    """Joints from the root outwards, each limb to its end, and those of two sides before those of the trunk.

    Of a body on two legs these are hips, knees, ankles, toes, then the trunk, arms and the head.
    """
    joints = character.joints
    rights = {right for name in joints if (right := _right_of(name)) in joints}
    paired = rights | {name for name in joints if _right_of(name) in rights}
    below: dict[str, list[str]] = {}
    for name in sorted(joints, key=lambda name: name not in paired):
        below.setdefault(joints[name].parent, []).append(name)
    order: list[str] = []
    rest = below.get(character.root, [])[::-1]
    while rest:
        order.append(rest.pop())
        rest += below.get(joints[order[-1]].child, [])[::-1]
    return order


def _muscles(recording: Recording, scene: Scene) -> Iterator[Group]:
    names = recording.muscle_names
    full = [FULL_FORCE * plain_number(scene.character.muscles[name].f_max) for name in names]
    optimal = np.array([plain_number(scene.character.muscles[name].l_opt) for name in names])
    force = np.minimum(recording.muscle_force, full)

    def curves(array: str, values: Floats, factors: list[float] | None = None) -> Curves:
        columns = [Stored(array, k, 1.0 if factors is None else factors[k]) for k in range(len(names))]
        return {name: (values[:, k], columns[k]) for k, name in enumerate(names)}

    yield "activations", "", curves("activation", recording.muscle_activation), {}
    yield "muscle forces", "N", curves("load", force, full), {}
    yield "excitations", "", curves("excitation", recording.muscle_excitation), {}
    yield "fibre lengths", "l_opt", curves("fibre", recording.muscle_fibre_length / optimal), {}


def _devices(recording: Recording, scene: Scene, legs: LegCurves) -> Iterator[Group]:
    """Torques of devices at joints, and powers of all."""
    torques, powers = Curves(), Curves()
    for name, force in scene.forces.items():
        if power_name(name) not in recording.recorded_names:
            continue
        power = recording.recorded[:, recording.recorded_names.index(power_name(name))]
        powers[f"{name} power"] = power, None
        first = [
            k for k, one in enumerate(recording.speed_names) if force.joint and one.partition(".")[0] == force.joint
        ]
        if first:
            speed = recording.speed[:, first[0]]
            moving = np.abs(speed) > STANDING
            moments = np.arange(len(power))
            key = f"{force.joint} {joint_type(scene.character.joints[force.joint]).angles[0]}".strip()
            sign = legs[key][1] if key in legs else 1.0
            if moving.any():
                torque = np.interp(moments, moments[moving], power[moving] / speed[moving])
                torques[f"{name} torque"] = sign * torque, None
    yield "devices", "N m", torques, {}
    yield "devices", "W", powers, {}


def _body(recording: Recording) -> Iterator[Group]:
    axes = ("to the left", "upwards", "forwards")
    place: Curves = {word: (recording.com[:, axis], Stored("com", axis)) for axis, word in enumerate(axes)}
    yield "centre of mass", "m", place, {}
    speed: Curves = {f"speed {word}": (recording.com_velocity[:, axis], None) for axis, word in enumerate(axes)}
    yield "centre of mass", "m/s", speed, {}


def _ground_forces(recording: Recording, everything: bool) -> list[Panel]:
    feet = (recording.foot_force_left, recording.foot_force_right)
    panels = []
    if everything or any(np.any(force) for force in feet):
        for word, axis in (("vertical", 1), ("forwards", 2), ("to the left", 0)):
            left, right = (force[:, axis] for force in feet)
            lines = (
                Line("left foot", "left", left, Stored("force", axis)),
                Line("right foot", "right", right, Stored("force", 3 + axis)),
            )
            panels.append(Panel("ground forces", word, "N", lines))
    return panels


def _panels(group: str, unit: str, curves: Curves, joints: Mapping[str, str], titles: Mapping[str, str]) -> list[Panel]:
    """A panel for each curve, or for the curves of both sides, whose names differ in l and r."""
    panels = []
    pairs = {name: other for name in curves if (other := _right_of(name)) in curves}
    rights = set(pairs.values())
    for name, (values, stored) in curves.items():
        if name in rights:
            continue
        other, joint = pairs.get(name), joints.get(name, "")
        if other is None:
            line = Line(name, "middle", values, stored)
            panels.append(Panel(group, titles.get(name, _plain(name)), unit, (line,), joint))
        else:
            lines = (Line(name, "left", values, stored), Line(other, "right", *curves[other]))
            panels.append(Panel(group, titles.get(name, _without_side(name)), unit, lines, joint))
    return panels


def _right_of(name: str) -> str | None:
    """What the same is called on the right side, of a name that may be of the left one."""
    if name.startswith("l"):
        return "r" + name[1:]
    other = re.sub(r"_l(?=$|[ _])", "_r", name, count=1)
    return other if other != name else None


def _without_side(name: str) -> str:
    bare = name[1:] if name.startswith("l") else re.sub(r"_l(?=$|[ _])", "", name, count=1)
    return _plain(bare) if re.search("[a-z]", bare) else bare.replace("_", " ").strip()


def _plain(name: str) -> str:
    """A name of a scene in words: ToeJoint is toe joint; what stands in capitals, as SOL of a muscle, stays."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", " ", name.replace("_", " ")).strip().split()
    return " ".join(word if word.upper() == word else word[0].lower() + word[1:] for word in words)


def _in_full(title: str) -> str:
    """A title of a joint without short words, and with its side ahead: r shoulder elev is right shoulder elevation."""
    words = title.split()
    side = next((word for word in (words[0], words[-1]) if word in BESIDE), "") if len(words) > 1 else ""
    rest = [WORDS.get(word, word) for word in words if not side or word != side]
    return " ".join([BESIDE[side], *rest] if side else rest)
