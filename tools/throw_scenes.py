"""Writes the scenes of the throwing arm for a subject and the mean of recorded free throws.

python tools/throw_scenes.py throws22.npz [--height 1.91] [--mass 90.7] [--output scenes]

The recordings are those that `warpmuscle throw` reads: angles in degrees and keypoints in m over time.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from warpmuscle.formats.toml_layout import layout
from warpmuscle.number import Free
from warpmuscle.scene import (
    Actuation,
    Body,
    Box,
    Capsule,
    Character,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    MuscleModel,
    Part,
    Pulley,
    Scene,
    Sphere,
    ViaPoint,
)
from warpmuscle.segments import Segment, segment
from warpmuscle.validate_muscles import initial_path_lengths

KNOTS, DURATION, RATE = 16, 1.5, 100
SHOULDER = (
    -0.104,
    0.818,
)  # of the height: half the width of the shoulders to the right, and their height (Winter 2009)
DATA = """# Mean of 22 free throws of one thrower, 1.91 m and 90.7 kg; computed from MLSE Sport Performance Lab (SPL) Open Data,
# basketball/freethrow (CC BY-NC-SA 4.0): markerless, 30 Hz, low-pass 8 Hz; 0 s is 1 s before the fastest extension of the
# elbow. Sixteen knots a coordinate, fitted by least squares to 151 samples, within 0.5 degrees and 1 mm of them."""
SOURCES = """# f_max: Holzbaur 2005 (deltoids, ECU and FCR; biceps long head and triceps long head as in OpenSim's arm26). l_opt and
# l_slack: Saul 2015. Moment arms: means over the joint's range in the upper limb model of Saul 2015, computed with OpenSim
# 4.6. Rest angles and lengths are a choice (Cruz Ruiz 2015, section 2.5: arbitrary, then optimised), as are the bounds:
# these six stand for whole groups of muscles. Pennation is neglected, as in Cruz Ruiz 2015."""
# name: joint, f_max N, l_opt m, l_slack m, moment arm m
MUSCLES = {
    "m1": ("shoulder", 1142.6, 0.0976, 0.093, 0.0223),  # anterior deltoid
    "m2": ("shoulder", 259.9, 0.1367, 0.038, -0.0087),  # posterior deltoid
    "m3": ("elbow", 624.3, 0.1157, 0.2723, 0.034),  # biceps
    "m4": ("elbow", 798.5, 0.134, 0.143, -0.0211),  # triceps
    "m5": ("wrist", 74.0, 0.0628, 0.244, 0.0143),  # wrist flexors
    "m6": ("wrist", 93.2, 0.0622, 0.2285, -0.004),  # wrist extensors
}
REST = {"shoulder": 75.0, "elbow": 70.0, "wrist": 0.0}  # degrees
DAMPING = {"shoulder": 0.5, "elbow": 0.3, "wrist": 0.05}  # N m s/rad
FLEXION = {"shoulder": (-1.0, 0.0, 0.0), "elbow": (-1.0, 0.0, 0.0), "wrist": (1.0, 0.0, 0.0)}
SEGMENTS = {"shoulder": "upper_arm", "elbow": "forearm", "wrist": "hand"}
Place = tuple[
    str, float, float
]  # segment, and m forwards of its axis and up from its distal end, the trunk's from the shoulder
POINTS: dict[str, list[Place]] = {
    "m1": [("trunk", -0.04, 0.06), ("upper_arm", 0.035, -0.03), ("upper_arm", 0.02, -0.15)],
    "m2": [("trunk", -0.05, -0.05), ("upper_arm", -0.03, -0.03), ("upper_arm", -0.02, -0.15)],
    "m3": [("upper_arm", 0.025, -0.105), ("forearm", 0.015, -0.045)],
    "m4": [("upper_arm", -0.02, -0.12), ("upper_arm", -0.025, -0.295), ("forearm", -0.015, 0.02)],
    "m5": [("forearm", -0.012, -0.06), ("forearm", -0.015, -0.255), ("hand", -0.013, -0.03)],
    "m6": [("forearm", 0.012, -0.06), ("forearm", 0.013, -0.255), ("hand", 0.011, -0.03)],
}  # the upper arm's from the shoulder, the forearm's from the elbow, the hand's from the wrist


def rounded(numbers: Any, digits: int = 4) -> Any:
    """Plain numbers without noise."""
    return np.round(np.asarray(numbers, dtype=float), digits).tolist()


def knots(values: np.ndarray) -> np.ndarray:
    """Values at the knots of the spline of fifth degree that is nearest to samples (T,) or (T, k)."""
    time, places = np.arange(len(values)) / RATE, np.linspace(0.0, DURATION, KNOTS)
    basis = make_interp_spline(places, np.eye(KNOTS), k=5)(time)
    return np.linalg.lstsq(basis, values, rcond=None)[0]


class Throws:
    """Means over recorded throws, at the knots; rad and m."""

    def __init__(self, file: Path) -> None:
        data = np.load(file, allow_pickle=False)
        angles = {joint: np.radians(data[f"{joint}_flexion"].astype(float)) for joint in FLEXION}
        pitch = np.radians(data["shoulder_flexion_gravity"].astype(float)) - angles["shoulder"]
        place = data["keypoint_pos_m"][:, :, list(data["keypoints"]).index("R_SHOULDER")].astype(float)
        self.time = rounded(np.linspace(0.0, DURATION, KNOTS))
        self.angles = {joint: knots(angle.mean(axis=0)) for joint, angle in angles.items()}
        self.pitch = knots(pitch.mean(axis=0))
        self.moved = knots((place - place[:, :1]).mean(axis=0)[:, [0, 2]])  # forwards and up

    def motion(self, joint: str) -> Motion:
        return Motion(self.time, value=rounded(self.angles[joint]))

    def start(self, joint: str) -> JointState:
        """Angle and rate at the start, from the knots."""
        curve = make_interp_spline(self.time, self.angles[joint], k=5)
        sign, angle = FLEXION[joint][0], float(curve(0.0))
        turn = (sign * np.sin(0.5 * angle), 0.0, 0.0, np.cos(0.5 * angle))
        return JointState(tuple(rounded(turn, 5)), tuple(rounded((sign * float(curve(0.0, nu=1)), 0.0, 0.0))))

    def root(self, home: tuple[float, float], shoulder: tuple[float, float]) -> Motion:
        """Motion of a body from its place forwards and up, m, as its shoulder, so far away, moved."""
        cosine, sine = np.cos(self.pitch), np.sin(self.pitch)
        forward, up = shoulder
        turned = np.stack([forward * cosine - up * sine, forward * sine + up * cosine], axis=1)
        place = np.asarray(home) + np.asarray(shoulder) + self.moved - turned
        position = [(0.0, y, z) for z, y in rounded(place)]
        return Motion(self.time, rotation=[(-p, 0.0, 0.0) for p in rounded(self.pitch)], position=position)


def arm(height: float, mass: float) -> tuple[dict[str, Body], dict[str, Segment]]:
    """The segments of the right arm as bodies."""
    parts = {name: segment(name, height, mass) for name in SEGMENTS.values()}
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
        joints[name] = Joint("hinge", parent, child, tuple(rounded(place)), in_child, [FLEXION[name]])
        parent, place = child, np.array([0.0, -part.length, 0.0]) - part.com
    return joints


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


def free(value: float, low: float, high: float) -> Free:
    """A free number whose bounds are given as factors."""
    ends = sorted((value * low, value * high))
    return Free(value, *rounded(ends, 6))


def pulley_muscles() -> dict[str, Muscle]:
    """Six muscles on pulleys."""
    muscles, first = {}, {}
    for name, (joint, f_max, l_opt, l_slack, moment_arm) in MUSCLES.items():
        key = f"character.muscles.{first.setdefault(joint, name)}.pulleys.0.rest_angle"
        rest = Free(rounded(np.radians(REST[joint])), -3.1416, 3.1416) if first[joint] == name else Free(same_as=key)
        ends = rounded([l_slack + share * l_opt for share in (1.0, 0.8, 1.2)], 5)
        muscles[name] = Muscle(
            pulleys=[Pulley(joint, free(moment_arm, 0.3, 4.0), rest)], rest_length=Free(*ends),
            f_max=free(f_max, 0.2, 10.0), l_opt=l_opt, l_slack=l_slack,
        )  # fmt: skip
    return muscles


def point_muscles(bodies: Character, parts: dict[str, Segment], shoulder: np.ndarray) -> dict[str, Muscle]:
    """The same muscles through points; their fibres are as long as is best at the rest angles."""
    muscles = {}
    for name, (_, f_max, l_opt, _, _) in MUSCLES.items():
        path = []
        for body, forward, up in POINTS[name]:
            origin = shoulder if body == "trunk" else -np.array(parts[body].com)
            path.append(ViaPoint(body, tuple(rounded(np.add(origin, (0.0, up, forward))))))
        muscles[name] = Muscle(path=path, f_max=f_max, l_opt=l_opt, l_slack=0.0)
    rest = {}
    for joint, degrees in REST.items():
        half = 0.5 * np.radians(degrees)
        rest[joint] = JointState((FLEXION[joint][0] * float(np.sin(half)), 0.0, 0.0, float(np.cos(half))))
    character = Character("trunk", bodies.bodies, bodies.joints, "planar", muscles)
    lengths = initial_path_lengths(Scene("rest", character, initial_state=InitialState(joints=rest)))
    for name, muscle in muscles.items():
        slack = lengths[name] - MUSCLES[name][2]
        muscle.l_slack = Free(*rounded([slack, slack - 0.2 * MUSCLES[name][2], slack + 0.2 * MUSCLES[name][2]]))
        muscle.f_max = free(MUSCLES[name][1], 0.2, 10.0)
    return muscles


class Tables(Part):
    """Tables of a character file."""

    muscles: dict[str, Muscle]


def common(name: str, description: str, character: Character, throws: Throws, root: Motion) -> Scene:
    """What the scenes share."""
    return Scene(
        name, character, description=description,
        initial_state=InitialState(joints={joint: throws.start(joint) for joint in FLEXION}),
        ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0),
        muscle_model=MuscleModel(
            curves="thelen_explicit", activation="neural", rise_time=0.05, fall_time=0.05, damping=0.0,
            implicit_damping=True, initial_activation=0.05,
        ),
        actuation={joint: Actuation("muscle", damping=damping) for joint, damping in DAMPING.items()},
        motion={"root": root, **{joint: throws.motion(joint) for joint in FLEXION}},
        duration=DURATION, time_step=0.001, gravity=9.81, implicit_pd=True,
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("throws", type=Path, help="recordings, .npz")
    parser.add_argument("--height", type=float, default=1.91, help="m")
    parser.add_argument("--mass", type=float, default=90.7, help="kg")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "scenes")
    given = parser.parse_args()
    throws = Throws(given.throws)
    bodies, parts = arm(given.height, given.mass)
    body, shoulder = trunk(given.height, given.mass)
    character = Character("trunk", {"trunk": body, **bodies}, hinges(parts, "trunk", shoulder), "planar")
    who = f"of a man of {given.height:g} m and {given.mass:g} kg: segments after Dumas 2007, see `warpmuscle/segments.py`."
    write(
        given.output / "throw_arm.toml",
        f"# A right arm on a trunk, {who}\n# Tables to add muscles to.\n\n{layout(character)}",
    )
    write(
        given.output / "throw_pulleys.toml",
        f"# The muscles of `throw_arm.toml` on pulleys.\n{SOURCES}\n\n{layout(Tables(pulley_muscles()))}",
    )
    points = point_muscles(character, parts, shoulder)
    write(
        given.output / "throw_points.toml",
        f"# The muscles of `throw_arm.toml` through points, whose moment arms change with the angles; the points are a choice.\n{SOURCES}\n\n{layout(Tables(points))}",
    )
    height = SHOULDER[1] * given.height
    root = throws.root((0.0, height - shoulder[1]), (0.0, shoulder[1]))
    scene = common(
        "throw",
        "A planar arm of three joints and six pulley muscles throws overhead; its trunk moves as recorded (Cruz Ruiz 2015).",
        character,
        throws,
        root,
    )
    files = ["throw_arm.toml", "throw_pulleys.toml"]
    write(given.output / "throw.toml", f"# {scene.description}\n{DATA}\n\n{layout(scene, {'character': files})}")


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
