"""Writes the scenes of the throwing arm for a subject and the mean of recorded free throws.

For docs/explanation/throwing.md.

python tools/research/throw_scenes.py throws22.npz [--height 1.91] [--mass 90.7] [--output warpmuscle/scenes/throws]

The recordings are those that `warpmuscle throw fit` reads: angles in degrees and keypoints in m over time.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.interpolate import make_interp_spline
from throw_muscles import planar, spatial, with_tendons
from throw_subject import FLEXION, LUMBAR, SHOULDER, SPATIAL, WholeBody, arm, hinges, rounded, spatial_arm, trunk

from warpmuscle.core.pose import about, multiply
from warpmuscle.formats.toml_layout import layout
from warpmuscle.markers.arm import ANGLES, Choices, arm_angles
from warpmuscle.markers.files import Markers
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    Failure,
    Ground,
    InitialState,
    JointState,
    Motion,
    Muscle,
    MuscleModel,
    Part,
    Pulley,
    Scene,
    Surface,
    ViaPoint,
)
from warpmuscle.scene.anthropometry import Segment, segment
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.muscles import initial_path_lengths

KNOTS, DURATION, RATE = 16, 1.5, 100
DATA = """\
# Motion: mean of 22 free throws of one thrower, 1.91 m and 90.7 kg; computed from MLSE Sport Performance Lab (SPL)
# Open Data, basketball/freethrow (CC BY-NC-SA 4.0): markerless, 30 Hz, low-pass 8 Hz; 0 s is 1 s before the fastest
# extension of the elbow. Sixteen knots a coordinate by least squares, within 0.5 degrees and 1 mm of 151 samples.
# The muscles drive the three joints; their motion is what fits compare with. In a free throw the forearm is pronated,
# so that palmar flexion turns the hand against the elbow's flexion."""
SOURCES = """\
# f_max: Holzbaur 2005 (deltoids, ECU, FCR; long heads of biceps and triceps as in OpenSim's arm26). l_opt, l_slack:
# Saul 2015. Moment arms: means over the joint's range in the upper limb model of Saul 2015, computed with OpenSim 4.6.
# Rest angles and lengths are a choice (Cruz Ruiz 2015, section 2.5: arbitrary, then optimised), and so are their ends.
# These six stand for whole groups: f_max is at most the sum of the group's muscles in Saul 2015 (m1: DELT1, DELT2,
# PECM1; m2: DELT3, LAT; m3: both heads of the biceps, BRA, BRD; m4: all heads of the triceps; m5: FCR, FCU, FDS; m6:
# ECRL, ECRB, ECU), and at least a fifth of its source. Pennation is neglected, as in Cruz Ruiz 2015."""
STRONGEST = {"m1": 2766.7, "m2": 998.6, "m3": 2295.3, "m4": 2206.8, "m5": 1555.5, "m6": 782.4}  # N, such sums
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
SPATIAL_DAMPING = {
    "shoulder": 0.5, "shoulder_abduction": 0.5, "shoulder_rotation": 0.3, "elbow": 0.3, "forearm_rotation": 0.05,
    "wrist_deviation": 0.05, "wrist": 0.05,
}  # fmt: skip
DAMPING = {"shoulder": 0.5, "elbow": 0.3, "wrist": 0.05}  # N m s/rad
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
}


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
        time, names = data["time"] - data["time"][0], tuple(str(name) for name in data["keypoints"])
        choices = Choices(low_pass=0.0, before=None)  # they have been filtered
        every = [arm_angles(Markers(file, time, names, one.astype(float)), choices) for one in data["keypoint_pos_m"]]
        mean = knots(np.mean([one.angles for one in every], axis=0))
        self.angles |= {name: column for name, column in zip(ANGLES, mean.T, strict=True) if name not in FLEXION}
        self.pitch = knots(pitch.mean(axis=0))
        self.height = float(place[:, 0, 2].mean())  # m, of the shoulder at the start
        self.moved = knots((place - place[:, :1]).mean(axis=0)[:, [0, 2]])  # forwards and up

    def motion(self, joint: str) -> Motion:
        return Motion(self.time, value=rounded(self.angles[joint]))

    def start(self, joint: str, axis: Sequence[float] | None = None) -> JointState:
        """Angle and rate at the start, from the knots, about an axis, by default that of the planar arm."""
        curve = make_interp_spline(self.time, self.angles[joint], k=5)
        axis = np.array(FLEXION[joint] if axis is None else axis)
        return JointState(
            tuple(rounded(about(axis, float(curve(0.0))), 5)), tuple(rounded(axis * float(curve(0.0, nu=1)) + 0.0))
        )

    def root(self, home: tuple[float, float], shoulder: tuple[float, float]) -> Motion:
        """Motion of a body from its place forwards and up, m, as its shoulder, so far away, moved."""
        cosine, sine = np.cos(self.pitch), np.sin(self.pitch)
        forward, up = shoulder
        turned = np.stack([forward * cosine - up * sine, forward * sine + up * cosine], axis=1)
        place = np.asarray(home) + np.asarray(shoulder) + self.moved - turned
        position = [(0.0, y, z) for z, y in rounded(place)]
        return Motion(self.time, rotation=[(-p, 0.0, 0.0) for p in rounded(self.pitch)], position=position)


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
            f_max=free(f_max, 0.2, STRONGEST[name] / f_max), l_opt=l_opt, l_slack=l_slack,
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
    lengths = rest_lengths(Character("trunk", bodies.bodies, bodies.joints, "planar", muscles))
    for name, muscle in muscles.items():
        slack = lengths[name] - MUSCLES[name][2]
        muscle.l_slack = Free(*rounded([slack, slack - 0.2 * MUSCLES[name][2], slack + 0.2 * MUSCLES[name][2]]))
        muscle.f_max = free(MUSCLES[name][1], 0.2, STRONGEST[name] / MUSCLES[name][1])
    return muscles


def rest_lengths(character: Character) -> dict[str, float]:
    """Lengths of the paths, m, at the angles of rest."""
    rest = {}
    for joint, degrees in REST.items():
        axis = np.array(character.joints[joint].axes[0], dtype=float)
        rest[joint] = JointState(tuple(about(axis, np.radians(degrees)).tolist()))
    return initial_path_lengths(Scene("rest", character, initial_state=InitialState(joints=rest)))


def many_muscles(bodies: Character, parts: dict[str, Segment], shoulder: np.ndarray) -> Part:
    """Eighteen muscles round the bones."""
    muscles, surfaces = planar(parts, shoulder)
    with_tendons(
        muscles,
        rest_lengths(
            Character("trunk", bodies.bodies, bodies.joints, "planar", muscles, surfaces, wrapping="shortest")
        ),
    )
    return Paths("shortest", surfaces, muscles)


def spatial_character(height: float, mass: float, body: Body, shoulder: np.ndarray) -> Character:
    """The arm in three dimensions, with its muscles, on the trunk."""
    bodies, joints, parts = spatial_arm(height, mass, shoulder)
    muscles, surfaces = spatial(parts, shoulder)
    character = Character("trunk", {"trunk": body, **bodies}, joints, "planar", muscles, surfaces, wrapping="shortest")
    with_tendons(muscles, rest_lengths(character))
    return character


def spatial_scene(character: Character, throws: Throws, root: Motion) -> Scene:
    """Its throw."""
    scene = common("throw23", TWENTY_THREE, character, throws, root)
    for joint, (_, _, axis, _) in SPATIAL.items():
        scene.initial_state.joints[joint] = throws.start(joint, axis)
        scene.motion[joint] = throws.motion(joint)
        scene.actuation[joint] = Actuation("muscle", damping=SPATIAL_DAMPING[joint])
    return scene


class Tables(Part):
    """Tables of a character file."""

    muscles: dict[str, Muscle]


class Paths(Part):
    """The same, with the surfaces that muscles run over."""

    wrapping: str
    surfaces: dict[str, Surface]
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
        duration=DURATION, time_step=0.001, gravity=9.81,
    )  # fmt: skip


def whole_scene(body: WholeBody, throws: Throws) -> Scene:
    """The throw; the feet stay where they are while the body rises."""
    lumbar = np.array([0.0, LUMBAR * body.height])
    shoulder = (0.0, (SHOULDER[1] - LUMBAR) * body.height)
    risen = throws.root((0.0, 0.0), shoulder)  # of the lumbar joint
    forward, up = np.array([[p[2], p[1]] for p in risen.position]).T
    forward, up = forward - forward.mean(), up - up.max() - 0.01
    com = body.com["pelvis"]
    position = [(0.0, y, z) for y, z in rounded(np.stack([lumbar[1] + up + com[1], forward + com[2]], axis=1))]
    hip, knee = legs(body.height, body.mass, forward, up)
    time, root = throws.time, Motion(throws.time, position=position)
    scene = common("throw_body", WHOLE, body.character, throws, root)
    motion = {"root": scene.motion["root"], "lumbar": Motion(time, rotation=risen.rotation)}
    for letter in "lr":
        motion[f"{letter}_hip"] = Motion(time, rotation=[(-angle, 0.0, 0.0) for angle in rounded(hip)])
        motion[f"{letter}_knee"] = Motion(time, value=rounded(knee))
        motion[f"{letter}_ankle"] = Motion(time, value=[[0.0] * KNOTS, rounded(knee - hip)])
    motion |= {"elbow": Motion([0.0], value=[rounded(np.pi)]), "wrist": Motion([0.0], value=[0.0])}
    motion["l_elbow"] = Motion([0.0], value=[[rounded(np.pi)], [0.6]])
    scene.motion = motion | {"shoulder": scene.motion["shoulder"]}
    scene.actuation = {name: Actuation("kinematic") for name, joint in body.joints.items() if joint.type != "fixed"}
    scene.actuation["shoulder"] = Actuation("muscle", damping=DAMPING["shoulder"])
    for joint in ("elbow", "wrist"):
        scene.actuation[joint] = Actuation(["kinematic", "muscle"], damping=DAMPING[joint])
    start = scene.initial_state.joints
    start["elbow"] = pronated(body, throws, "elbow", np.pi)
    start["wrist"] = pronated(body, throws, "wrist", 0.0)
    return scene


def pronated(body: WholeBody, throws: Throws, joint: str, turn: float) -> JointState:
    """Start of a flexion beside which the child is turned about its own other axis."""
    curve = make_interp_spline(throws.time, throws.angles[joint], k=5)
    own, flex = (np.array(axis) for axis in body.joints[joint].axes)
    orientation = multiply(about(flex, float(curve(0.0))), about(own, turn))
    return JointState(tuple(rounded(orientation, 5)), tuple(rounded(flex * float(curve(0.0, nu=1)))))


def legs(height: float, mass: float, forward: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Flexion of hip and knee, rad, with which the ankles stay as the hips move, m, from above them."""
    thigh, shank = (segment(name, height, mass).length for name in ("thigh", "shank"))
    down, back = thigh + shank + up, -forward
    reach = np.hypot(down, back)
    knee = np.arccos(np.clip((reach**2 - thigh**2 - shank**2) / (2.0 * thigh * shank), -1.0, 1.0))
    lean = np.arctan2(back, down)
    return lean + np.arctan2(shank * np.sin(knee), thigh + shank * np.cos(knee)), knee


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("throws", type=Path, help="recordings, .npz")
    parser.add_argument("--height", type=float, default=1.91, help="m")
    parser.add_argument("--mass", type=float, default=90.7, help="kg")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[2] / "warpmuscle" / "scenes" / "throws")
    given = parser.parse_args()
    throws = Throws(given.throws)
    bodies, parts = arm(given.height, given.mass)
    body, shoulder = trunk(given.height, given.mass)
    character = Character("trunk", {"trunk": body, **bodies}, hinges(parts, "trunk", shoulder), "planar")
    who = f"a man of {given.height:g} m and {given.mass:g} kg: segments after Dumas 2007, see `scene/anthropometry.py`"
    to_add = "Tables to add to a character with the joints shoulder, elbow and wrist."
    headers = {
        "throw_arm": f"A right arm on the trunk of {who}.\n# Tables to add muscles to.",
        "throw_pulleys": f"Six muscles of an arm on pulleys. {to_add}\n{SOURCES}",
        "throw_points": "Six muscles of `throw_arm.toml` through points, which are a choice; so moment arms vary."
        f"\n{SOURCES}",
        "throw18_muscles": MANY,
        "throw_whole": f"The whole body of {who}.\n# 21 segments, 32 degrees of freedom. Torso and head with neck are "
        "divided by length; half a kilogram\n# of the torso turns with each arm's flexion.",
    }
    whole = WholeBody(given.height, given.mass)
    pulleys = pulley_muscles()
    tables: dict[str, Part] = {
        "throw_arm": character,
        "throw_pulleys": Tables(pulleys),
        "throw_points": Tables(point_muscles(character, parts, shoulder)),
        "throw18_muscles": many_muscles(character, parts, shoulder),
        "throw_whole": whole.character,
    }
    second = "\n".join(f"{name}.pulleys.0.axis = 1" for name, muscle in MUSCLES.items() if muscle[0] != "shoulder")
    ends = {"throw_whole": f"\n# Flexion of elbow and wrist is their second angle.\n[muscles]\n{second}\n"}
    for name, part in tables.items():
        write(given.output / f"{name}.toml", f"# {headers[name]}\n\n{layout(part)}{ends.get(name, '')}")
    home = throws.height - shoulder[1]
    deep = spatial_character(given.height, given.mass, body, shoulder)
    write(given.output / "throw23_arm.toml", f"# {DEEP.format(who=who)}\n\n{layout(deep)}")
    moved = throws.root((0.0, home), (0.0, shoulder[1]))
    save(spatial_scene(deep, throws, moved), ["throw23_arm.toml"], given.output)
    planar = common("throw", PLANAR, character, throws, throws.root((0.0, home), (0.0, shoulder[1])))
    save(planar, ["throw_arm.toml", "throw_pulleys.toml"], given.output)
    for name, muscles, description in (("throw_via", "throw_points", VIA), ("throw18", "throw18_muscles", EIGHTEEN)):
        text = f'# {description}\n\nname = "{name}"\nbase = "throw.toml"\n'
        text += f'character = ["throw_arm.toml", "{muscles}.toml"]\ndescription = "{description}"\n'
        write(given.output / f"{name}.toml", text)
    save(whole_scene(whole, throws), ["throw_pulleys.toml", "throw_whole.toml"], given.output)


PLANAR = (
    "A planar arm of three joints and six pulley muscles throws overhead; its trunk moves as recorded (Cruz Ruiz 2015)."
)
VIA = "The throwing arm with muscles through points, whose moment arms vary with the angles."
TWENTY_THREE = "An arm of seven angles throws by 23 muscles in three dimensions; its trunk moves as recorded."
DEEP = """\
A right arm in three dimensions on the trunk of {who}.
# The shoulder's three hinges are one behind the other at one place, as the angles of a ball joint: forwards, outwards,
# about the humerus; then elbow, forearm about itself, wrist to the thumb's side and to the palm's. Small bodies lie
# between them. Muscles: those of `throw18_muscles.toml`, with supraspinatus, infraspinatus, subscapularis, pronator
# teres and supinator."""
EIGHTEEN = "The throwing arm with 18 muscles of shoulder, elbow and wrist, guided over the bones by via points."
MANY = """\
Eighteen muscles of `throw_arm.toml` that run over the bones; nine of them cross two joints.
# Deltoid in three parts, clavicular pectoralis, latissimus, both heads of the biceps, brachialis, brachioradialis,
# three heads of the triceps, flexors (radialis, ulnaris) and extensors (radialis longus, brevis, ulnaris) of the wrist,
# and the superficial flexor of the fingers. f_max, l_opt, pennation: Saul 2015, parts of one muscle summed up.
# Points: after OpenSim's arm26 and Holzbaur 2005, as far from the joint that they act on as there, over the subject's
# longer bones. The girdle does not move here, so muscles of the shoulder begin where they have the moment arms of one
# that does. l_slack: fibres are as long as in arm26 at shoulder 75, elbow 70, wrist 0 degrees, or near their best."""
WHOLE = "A body of 21 segments throws: six muscles move three joints of the right arm; all other motion is prescribed."


def save(scene: Scene, files: list[str], folder: Path) -> None:
    """Write a scene whose character stands in other files."""
    write(folder / f"{scene.name}.toml", f"# {scene.description}\n{DATA}\n\n{layout(scene, {'character': files})}")


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
