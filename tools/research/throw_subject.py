"""The bodies and joints of the throwing scenes, from a subject's height and mass.

For docs/explanation/throwing.md.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from warpmuscle.scene import Body, Box, Capsule, Character, Joint, Sphere
from warpmuscle.scene.anthropometry import Segment, segment

SHOULDER = (-0.104, 0.818)  # of the height: half the width of the shoulders, to the right; their height (Winter 2009)
LUMBAR = 0.583  # of the height: that of the lumbar joint
FLEXION = {"shoulder": (-1.0, 0.0, 0.0), "elbow": (-1.0, 0.0, 0.0), "wrist": (1.0, 0.0, 0.0)}
LIMITS = {"shoulder": (-1.0472, 3.2289), "elbow": (-0.1745, 2.618), "wrist": (-1.3963, 1.3963)}  # rad
LIMIT_SPRING = (100.0, 1.0)  # N m/rad, N m s/rad: soft, for light segments
SEGMENTS = {"shoulder": "upper_arm", "elbow": "forearm", "wrist": "hand"}
SPLIT = {  # parts of segments, from their lower ends
    "abdomen": ("torso", 0.0, 0.39),
    "thorax": ("torso", 0.39, 1.0),
    "neck": ("head", 0.0, 0.3),
    "head": ("head", 0.3, 1.0),
}
UPRIGHT = {  # its parent, and its joint to that
    "abdomen": ("pelvis", "ball"),
    "thorax": ("abdomen", "fixed"),
    "neck": ("thorax", "ball"),
    "head": ("neck", "fixed"),
}
GIRDLE = 0.5  # kg, of the torso, that turns with the flexion of each arm


def rounded(numbers: Any, digits: int = 4) -> Any:
    """Plain numbers without noise."""
    return np.round(np.asarray(numbers, dtype=float), digits).tolist()


def arm(height: float, mass: float) -> tuple[dict[str, Body], dict[str, Segment]]:
    """The segments of the right arm as bodies, forearm and hand pronated: their palmar sides face backwards."""
    parts = {name: segment(name, height, mass) for name in SEGMENTS.values()}
    for name in ("forearm", "hand"):
        x, y, z = parts[name].com
        parts[name] = replace(parts[name], com=(-x, y, -z))
    bodies = {}
    for name, part in parts.items():
        top, bottom = np.negative(part.com), np.array([0.0, -part.length, 0.0]) - part.com
        radius = {"upper_arm": 0.045, "forearm": 0.035, "hand": 0.025}[name]
        shape = Capsule(tuple(rounded(top)), tuple(rounded(bottom)), radius)
        bodies[name] = Body(rounded(part.mass), tuple(rounded(part.inertia, 6)), [shape])
    return bodies, parts


def hinges(parts: dict[str, Segment], parent: str, shoulder: Any) -> dict[str, Joint]:
    """The joints of the planar arm, the first at a place of its parent."""
    joints, place = {}, shoulder
    for name, child in SEGMENTS.items():
        part = parts[child]
        in_child = tuple(rounded(np.negative(part.com)))
        joints[name] = Joint(
            "hinge", parent, child, tuple(rounded(place)), in_child, [FLEXION[name]], [LIMITS[name]], *LIMIT_SPRING
        )
        parent, place = child, np.array([0.0, -part.length, 0.0]) - part.com
    return joints


SPATIAL = {  # parent, child, axis, limits: hinges one behind the other
    "shoulder": ("trunk", "scapula", (-1.0, 0.0, 0.0), (-1.0472, 3.2289)),
    "shoulder_abduction": ("scapula", "humeral_head", (0.0, 0.0, -1.0), (-0.8727, 2.0944)),
    "shoulder_rotation": ("humeral_head", "upper_arm", (0.0, 1.0, 0.0), (-1.5708, 1.7453)),
    "elbow": ("upper_arm", "ulna", (-1.0, 0.0, 0.0), (-0.1745, 2.618)),
    "forearm_rotation": ("ulna", "radius", (0.0, 1.0, 0.0), (-1.5708, 1.7453)),
    "wrist_deviation": ("radius", "carpus", (-1.0, 0.0, 0.0), (-0.8727, 0.8727)),
    "wrist": ("carpus", "hand", (0.0, 0.0, 1.0), (-1.3963, 1.3963)),
}
BETWEEN = 0.1  # kg, of the bodies between hinges at one place, each as a ball of 3 cm


def spatial_arm(
    height: float, mass: float, shoulder: Any
) -> tuple[dict[str, Body], dict[str, Joint], dict[str, Segment]]:
    """Bodies, joints and segments of a right arm whose thumb points forwards where all angles are zero."""
    parts = {name: segment(name, height, mass) for name in SEGMENTS.values()}
    for name in ("forearm", "hand"):
        x, y, z = parts[name].com
        parts[name] = replace(parts[name], com=(z, y, -x))
    of = {"upper_arm": "upper_arm", "ulna": "forearm", "radius": "forearm", "hand": "hand"}
    bodies = {}
    for _, child, _, _ in SPATIAL.values():
        if child not in of:
            inertia = round(0.4 * BETWEEN * 0.03**2, 7)
            bodies[child] = Body(BETWEEN, (inertia, inertia, inertia), [Sphere((0.0, 0.0, 0.0), 0.03)])
            continue
        part, share = parts[of[child]], 0.5 if of[child] == "forearm" else 1.0
        top, bottom = np.negative(part.com), np.array([0.0, -part.length, 0.0]) - part.com
        radius = {"upper_arm": 0.045, "hand": 0.025}.get(child, 0.028)
        lighter = BETWEEN if child == "hand" else 0.0
        bodies[child] = Body(
            rounded(share * part.mass - lighter), tuple(rounded(share * np.array(part.inertia), 6)),
            [Capsule(tuple(rounded(top)), tuple(rounded(bottom)), radius)],
        )  # fmt: skip
    joints = {}
    for name, (parent, child, axis, limits) in SPATIAL.items():
        lower = name in ("elbow", "wrist_deviation")  # at the far end of its parent
        place: Any = np.zeros(3)
        if parent == "trunk":
            place = shoulder
        elif parent in of:
            part = parts[of[parent]]
            place = np.array([0.0, -part.length if lower else 0.0, 0.0]) - part.com
        in_child = np.negative(parts[of[child]].com) if child in of else np.zeros(3)
        joints[name] = Joint(
            "hinge", parent, child, tuple(rounded(place)), tuple(rounded(in_child)), [axis], [limits], *LIMIT_SPRING
        )
    return bodies, joints, parts


def trunk(height: float, mass: float) -> tuple[Body, np.ndarray]:
    """Head, torso, pelvis and left arm as one body, which only moves as prescribed, and the place of its shoulder."""
    names = ("head", "torso", "pelvis", "upper_arm", "forearm", "hand")
    whole = sum(segment(name, height, mass).mass for name in names)
    size = 0.5 * np.array([0.22, 0.36, 0.12]) * height
    inertia = (
        whole / 3.0 * np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2])
    )
    shape = Box(tuple(rounded(-0.9 * size)), tuple(rounded(0.9 * size)))
    head = Sphere((0.0, round(1.35 * size[1], 4), 0.0), 0.1)
    body = Body(rounded(whole), tuple(rounded(inertia)), [shape, head])
    return body, np.array([SHOULDER[0] * height, 0.8 * size[1], 0.0])


class WholeBody:
    """Twenty-one segments; muscles are to drive three flexions of the right arm."""

    def __init__(self, height: float, mass: float) -> None:
        self.height, self.mass = height, mass
        self.bodies: dict[str, Body] = {}
        self.joints: dict[str, Joint] = {}
        self.com: dict[str, np.ndarray] = {}  # m, from the joint above, or the lumbar joint for the pelvis
        pelvis = segment("pelvis", height, mass)
        self._add("pelvis", pelvis.mass, pelvis.inertia, np.array(pelvis.com), 0.09)
        lower = -np.array(pelvis.com)
        for name, (parent, kind) in UPRIGHT.items():
            lower = self._upright(name, parent, kind, lower)
        for side in ("right", "left"):
            self._arm(side)
            self._leg(side)
        self.character = Character("pelvis", self.bodies, self.joints)

    def _add(self, name: str, mass: float, inertia: Any, com: np.ndarray, radius: float, end: Any = None) -> None:
        """A body, its shape from its joint to a place."""
        shape: Any = Sphere((0.0, 0.0, 0.0), radius)
        if end is not None:
            shape = Capsule(tuple(rounded(-com)), tuple(rounded(np.asarray(end) - com)), radius)
        self.bodies[name] = Body(rounded(mass), tuple(rounded(inertia, 6)), [shape])
        self.com[name] = com

    def _joint(self, name: str, kind: str, parent: str, child: str, place: Any, axes: list[Any]) -> None:
        """A joint at a place from the parent's centre of mass."""
        self.joints[name] = Joint(kind, parent, child, tuple(rounded(place)), tuple(rounded(-self.com[child])), axes)  # type: ignore[arg-type]

    def _upright(self, name: str, parent: str, kind: str, place: np.ndarray) -> np.ndarray:
        """A part of torso or head on top of another body; the place of its upper end from its centre of mass."""
        source, low, high = SPLIT[name]
        whole, share = segment(source, self.height, self.mass), high - low
        inertia = share * np.array(whole.inertia) * [share**2, 1.0, share**2]
        length, mass = share * whole.length, share * whole.mass
        if name == "thorax":
            mass -= 2.0 * GIRDLE
        radius = {"abdomen": 0.12, "thorax": 0.14, "neck": 0.05, "head": 0.09}[name]
        com = np.array([0.0, 0.5 * length, 0.0])
        self._add(name, mass, inertia, com, radius, (0.0, length, 0.0))
        title = {"abdomen": "lumbar", "thorax": "thoracic", "neck": "cervical", "head": "atlas"}[name]
        self._joint(title, kind, parent, name, place, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] if kind == "ball" else [])
        return np.array([0.0, length, 0.0]) - com

    def _limb(self, body: str, source: str, side: Any, radius: float) -> np.ndarray:
        """A segment that hangs down as a body; the place of its lower end from its centre of mass."""
        part = segment(source, self.height, self.mass, side=side)
        com, end = np.array(part.com), np.array([0.0, -part.length, 0.0])
        self._add(body, part.mass, part.inertia, com, radius, end)
        return end - com

    def _arm(self, side: str) -> None:
        """The joints of the right arm have the names of those of the planar one."""
        right = side == "right"
        outwards = SHOULDER[0] * (1.0 if right else -1.0)
        thorax_joint = 0.39 * segment("torso", self.height, self.mass).length
        above_lumbar = (SHOULDER[1] - LUMBAR) * self.height - thorax_joint
        place = np.array([outwards * self.height, above_lumbar, 0.0]) - self.com["thorax"]
        girdle, upper, fore, hand = (
            name if right else f"l_{name}" for name in ("girdle", "upper_arm", "forearm", "hand")
        )
        names = [name if right else f"l_{name}" for name in ("shoulder", "glenohumeral", "elbow", "wrist")]
        self._add(girdle, GIRDLE, [0.4 * GIRDLE * 0.05**2] * 3, np.zeros(3), 0.05)
        self._joint(names[0], "hinge", "thorax", girdle, place, [FLEXION["shoulder"]])
        flex, up, out = FLEXION["elbow"], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
        end = self._limb(upper, "upper_arm", side, 0.045)
        self._joint(names[1], "universal", girdle, upper, np.zeros(3), [up, out])
        below = self._limb(fore, "forearm", side, 0.035)
        self._joint(names[2], "universal", upper, fore, end, [up, flex])
        self._limb(hand, "hand", side, 0.025)
        self._joint(names[3], "universal", fore, hand, below, [out, flex])

    def _leg(self, side: str) -> None:
        letter = "r" if side == "right" else "l"
        outwards = (-1.0 if side == "right" else 1.0) * 0.05 * self.height
        pelvis = np.array([outwards, -segment("pelvis", self.height, self.mass).length, 0.0]) - self.com["pelvis"]
        knee = self._limb(f"{letter}_thigh", "thigh", side, 0.07)
        self._joint(f"{letter}_hip", "ball", "pelvis", f"{letter}_thigh", pelvis, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        ankle = self._limb(f"{letter}_shank", "shank", side, 0.05)
        self._joint(f"{letter}_knee", "hinge", f"{letter}_thigh", f"{letter}_shank", knee, [[1.0, 0.0, 0.0]])
        foot = segment("foot", self.height, self.mass, side=side)  # type: ignore[arg-type]
        toe = np.array([0.0, -0.03 * self.height, 0.6 * foot.length])
        share = 0.85  # of the foot's mass, that of the toes is the rest
        self._add(f"{letter}_foot", share * foot.mass, share * np.array(foot.inertia), np.array(foot.com), 0.03, toe)
        axes = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
        self._joint(f"{letter}_ankle", "universal", f"{letter}_shank", f"{letter}_foot", ankle, axes)
        toes, tip = 0.15 * foot.mass, np.array([0.0, 0.0, 0.2 * foot.length])
        self._add(f"{letter}_toes", toes, [0.4 * toes * 0.03**2] * 3, 0.5 * tip, 0.025, tip)
        self._joint(f"{letter}_toe_joint", "fixed", f"{letter}_foot", f"{letter}_toes", toe - np.array(foot.com), [])
