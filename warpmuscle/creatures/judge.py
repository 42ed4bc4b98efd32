"""Whether the muscles of a moving body could be those of an animal: leverage, fibres, forces, strength and mass.

Bounds are those of animals, as far as they are known:
- a muscle keeps away from the centre of each joint that it crosses, and does not change sides. At a joint of several
  axes its moment arm is a vector, and its side is the direction of the mean: a flexor may well lift the leg outwards a
  little in one pose, and pull it inwards in another one;
- its moment arm is at most 30 % of the longer one of the segments at the joint: people's hip extensors have 20 %, their
  calves 12 % (moment arms of Arnold 2010, up to 8 cm of a thigh of 40 cm and 5 cm of a shank of 40 cm);
- its fibres stay between 0.5 and 1.5 optimal lengths, where actin and myosin overlap (Zajac 1989);
- its tension is at most 1.8 times its isometric strength, as a fibre's that is stretched (Katz 1939);
- its isometric strength is at most 15 body weights: people's vasti have 7 to 13;
- all muscles together are at most 50 % of the body's mass; in mammals it is 40 to 45 % (Calder 1996).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.initial_pose import Poses, initial_pose, plain_number, plain_vector
from warpmuscle.scene.masses import body_mass, total_mass
from warpmuscle.scene.topology import topology
from warpmuscle.studies.moment_arms import muscle_geometry

LEAST_ARM = 0.003  # m; a path that comes nearer to the centre of a joint goes through it
LONGEST_ARM = 0.3  # of the longer one of the segments at the joint
FIBRE = (0.5, 1.5)  # l_opt
STRETCHED = 1.8  # f_max
STRONGEST = 15.0  # body weights
HEAVIEST = 0.5  # of the body
FRAMES = 200  # that are looked at


@dataclass(frozen=True)
class Crossing:
    """A muscle at a joint that it crosses, over a motion."""

    muscle: str
    joint: str
    least: float  # m, of the moment arm, positive where it turns the child towards greater angles; of several axes its
    # part along the direction of the mean
    greatest: float  # m
    longest: float  # m, that it may be
    doubts: tuple[str, ...]


@dataclass(frozen=True)
class MuscleUse:
    """A muscle over a motion."""

    muscle: str
    shortest: float  # l_opt
    longest: float  # l_opt
    force: float  # f_max, the greatest tension
    strength: float  # body weights, f_max
    doubts: tuple[str, ...]


@dataclass(frozen=True)
class Plausibility:
    """What was found of a moving body."""

    crossings: tuple[Crossing, ...]
    muscles: tuple[MuscleUse, ...]
    muscle_share: float  # of the body's mass

    @property
    def doubts(self) -> tuple[str, ...]:
        """Everything that no animal has, a line each."""
        found = [f"{one.muscle} at {one.joint}: {doubt}" for one in self.crossings for doubt in one.doubts]
        found += [f"{one.muscle}: {doubt}" for one in self.muscles for doubt in one.doubts]
        if self.muscle_share > HEAVIEST:
            found.append(f"muscles are {100.0 * self.muscle_share:.0f} % of the body, more than {100 * HEAVIEST:.0f}")
        return tuple(found)


def plausibility(scene: Scene, recording: Recording) -> Plausibility:
    """Judge the muscles of a scene over one of its motions.

    Args:
        scene: without free parameters. recording: of it, with coordinates, fibre lengths and forces.

    Raises:
        Error: the scene has no muscles, or the recording lacks what is asked for.
    """
    if not scene.character.muscles:
        raise Error(f"{scene.name} has no muscles to judge")
    if not recording.frames:
        raise Error(f"the motion of {scene.name} has no frames: it ended at once")
    if any(not len(recording[name]) for name in ("coordinate", "muscle_force")):
        raise Error("takes a motion with its coordinates, fibre lengths and muscle forces")
    frames = np.unique(np.linspace(0, recording.frames - 1, min(FRAMES, recording.frames)).astype(int))
    _, arms = muscle_geometry(scene, recording.coordinate[frames])
    share = total_mass(list(scene.character.muscles.values()), scene.muscle_model) / body_mass(scene.character)
    return Plausibility(tuple(_crossings(scene, arms)), tuple(_uses(scene, recording)), share)


def _crossings(scene: Scene, arms: Floats) -> Iterator[Crossing]:
    """All muscles at all joints that they cross; arms (n, M, S), m."""
    names, (poses, _) = topology(scene.character), initial_pose(scene)
    for k, muscle in enumerate(scene.character.muscles):
        for number, joint in enumerate(names.joints, 1):
            own = arms[:, k, names.speed_start[number] : names.speed_start[number + 1]]
            if np.any(own != 0.0):
                along, whole = one_arm(own)
                longest = LONGEST_ARM * _length(scene, scene.character.joints[joint], poses)
                low, high = float(along.min()), float(along.max())
                doubts = tuple(_arm_doubts(low, high, float(whole.max()), longest))
                yield Crossing(muscle, joint, low, high, longest, doubts)


def one_arm(arms: Floats) -> tuple[Floats, Floats]:
    """Of moment arms (n, D) about the axes of a joint: the part (n,) along the direction of the mean, and the whole.

    About one axis, the part is the moment arm itself.
    """
    if arms.shape[1] == 1:
        return arms[:, 0], np.abs(arms[:, 0])
    mean = arms.mean(axis=0)
    length = float(np.linalg.norm(mean))
    along = arms @ (mean / length) if length > 0.0 else np.zeros(len(arms))
    return along, np.linalg.norm(arms, axis=1)


def _arm_doubts(low: float, high: float, greatest: float, longest: float) -> Iterator[str]:
    if low * high <= 0.0 or min(abs(low), abs(high)) < LEAST_ARM:
        yield f"goes through the joint: moment arm {1e3 * low:.1f} to {1e3 * high:.1f} mm"
    if greatest > longest:
        yield f"moment arm of {1e3 * greatest:.0f} mm, more than {1e3 * longest:.0f}"


def _length(scene: Scene, joint: Joint, poses: Poses) -> float:
    """Length of the longer one of the two bodies at a joint: between its farthest joints and ends of shapes, m."""
    return max(_extent(scene, body, poses) for body in (joint.parent, joint.child))


def _extent(scene: Scene, body: str, poses: Poses) -> float:
    """Of a body; joints that slide as they turn are where they start."""
    place, turn = poses[body]
    points = [plain_vector(one.position_in_child) for one in scene.character.joints.values() if one.child == body]
    for joint in scene.character.joints.values():
        if joint.parent == body:
            below, turned = poses[joint.child]
            anchor = below + rotate(turned, plain_vector(joint.position_in_child))
            points.append(rotate(conjugate(turn), anchor - place))
    for shape in scene.character.bodies[body].shapes:
        ends = [getattr(shape, name) for name in ("start", "end", "low", "high", "center") if hasattr(shape, name)]
        points += [plain_vector(end) for end in ends]
    return max((math.dist(a, b) for a in points for b in points), default=0.0)


def _uses(scene: Scene, recording: Recording) -> Iterator[MuscleUse]:
    weight = plain_number(scene.gravity) * body_mass(scene.character)
    for k, name in enumerate(recording.muscle_names):
        muscle = scene.character.muscles[name]
        f_max, l_opt = plain_number(muscle.f_max), plain_number(muscle.l_opt)
        fibre = recording.muscle_fibre_length[:, k] / l_opt
        force = float(recording.muscle_force[:, k].max()) / f_max
        low, high = float(fibre.min()), float(fibre.max())
        strength = f_max / weight
        yield MuscleUse(name, low, high, force, strength, tuple(_use_doubts(low, high, force, strength)))


def _use_doubts(low: float, high: float, force: float, strength: float) -> Iterator[str]:
    if low < FIBRE[0] or high > FIBRE[1]:
        yield f"fibres of {low:.2f} to {high:.2f} l_opt, beyond {FIBRE[0]:g} to {FIBRE[1]:g}"
    if force > STRETCHED:
        yield f"tension of {force:.2f} f_max, more than {STRETCHED:g}"
    if strength > STRONGEST:
        yield f"strength of {strength:.0f} body weights, more than {STRONGEST:g}"
