"""What a model needs to stand on: soles of its feet, and springs in joints that no muscle moves."""

from __future__ import annotations

import math

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import conjugate, multiply, rotate, rotation_vector
from warpmuscle.model.path_table import joints_of_muscles
from warpmuscle.scene import Actuation, Box, Character, Scene
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.initial_pose import Poses, plain_number, plain_vector, world_poses
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.muscles import Drive, is_cable
from warpmuscle.scene.topology import subtree, topology
from warpmuscle.walking.legs import Leg, joint_anchor

# Over a person's height (Winter 2009, fig. 4.1).
FOOT_LENGTH, FOOT_BREADTH, ANKLE_HEIGHT = 0.152, 0.055, 0.039
HEEL = 0.2  # of a foot's length, behind the ankle
THICKNESS = 0.5  # of the height of the ankle, from the sole up
TOES = 0.6  # of that thickness
SHORTEST = 0.2  # of a foot's length, of its parts before and behind the joint of its toes
MOST_TILT = 20.0  # degrees, of a foot's axes in the reference pose
# Springs of joints that no muscle moves, over the moment of gravity of what they hold at a right angle: upright ones
# must be stiffer than gravity, those that hang need little.
UPRIGHT, HANGING = 4.0, 0.4
DAMPING = 0.25  # of critical damping
TOE_STIFFNESS = 15.0 / 75.0  # N m/(rad kg), over the mass of the body, as in `gait2392_walk`
TOE_DAMPING = 0.5 / 75.0
GRAVITY = 9.81  # m/s^2
DIGITS = 3  # of numbers in a file


def has_soles(character: Character, legs: tuple[Leg, Leg]) -> bool:
    """Whether both feet, or what hangs on them, have shapes already."""
    return all(any(character.bodies[name].shapes for name in foot_bodies(character, leg.foot)) for leg in legs)


def soles(scene: Scene, leg: Leg) -> dict[str, Box]:
    """Boxes for a foot and its toes, by body, m, in the frames of the bodies: as long, broad and low as a person's.

    Where a muscle is attached behind the heel, in front of the toes or lower, a box reaches as far.

    Args:
        scene: in its reference pose.

    Raises:
        SceneError: the foot's axes are not those of the scene, along which boxes lie.
    """
    poses, height = world_poses(scene), leg.height()
    for body in filter(None, (leg.foot, leg.toes)):
        tilt = math.degrees(float(np.linalg.norm(rotation_vector(poses[body][1]))))
        if tilt > MOST_TILT:
            raise SceneError(
                f"its axes are turned by {tilt:.0f} degrees in the reference pose, where a sole lies along the "
                "scene's; give it shapes that touch the ground",
                key=f"character.bodies.{body}",
            )
    ankle = _seen_from(poses, leg.foot, leg.ankle)
    back = ankle[2] - HEEL * FOOT_LENGTH * height
    front, sole = back + FOOT_LENGTH * height, ankle[1] - ANKLE_HEIGHT * height
    attached = _attachments(scene.character, poses, [leg.foot, *filter(None, [leg.toes])], leg.foot)
    if len(attached):
        low, high = attached.min(axis=0), attached.max(axis=0)
        back, front, sole = min(back, low[2]), max(front, high[2]), min(sole, low[1])
    half, thickness = 0.5 * FOOT_BREADTH * height, THICKNESS * ANKLE_HEIGHT * height
    if not leg.toes:
        return {leg.foot: _box((ankle[0] - half, sole, back), (ankle[0] + half, sole + thickness, front))}
    name = next(name for name, joint in scene.character.joints.items() if joint.child == leg.toes)
    ball = _seen_from(poses, leg.foot, joint_anchor(scene.character, poses, name))
    least = SHORTEST * FOOT_LENGTH * height
    back, front, middle = min(back, ball[2] - least), max(front, ball[2] + least), 0.5 * (ankle[0] + ball[0])
    low, high = np.array([ball[0] - half, sole, ball[2]]), np.array([ball[0] + half, sole + TOES * thickness, front])
    shift, _ = _relative(poses, leg.toes, leg.foot)
    toes = _box(tuple(low - shift), tuple(high - shift))
    return {leg.foot: _box((middle - half, sole, back), (middle + half, sole + thickness, ball[2])), leg.toes: toes}


def springs(scene: Scene, legs: tuple[Leg, Leg]) -> dict[str, Actuation]:
    """Springs and dampers, by joint, for the toes and for joints of their own coordinates that no muscle crosses."""
    character, poses = scene.character, world_poses(scene)
    muscles = replace(
        character, muscles={name: muscle for name, muscle in character.muscles.items() if not is_cable(muscle)}
    )
    crossed = {joint for joints in joints_of_muscles(muscles, topology(character)).values() for joint in joints}
    mass = body_mass(character)
    found: dict[str, Actuation] = {}
    for name, joint in character.joints.items():
        if not joint_type(joint).speeds:
            continue
        if joint.child in {leg.toes for leg in legs}:
            drive: Drive = "muscle" if name in crossed else "passive"
            found[name] = Actuation(drive, rounded(TOE_STIFFNESS * mass), rounded(TOE_DAMPING * mass))
        elif name not in crossed:
            found[name] = _spring(character, poses, name)
    return found


def _spring(character: Character, poses: Poses, name: str) -> Actuation:
    """A spring that holds what hangs on a joint, or stands on it, and swings out within a period or two."""
    anchor = joint_anchor(character, poses, name)
    held = sorted(subtree(character, character.joints[name].child))  # in one order, so that sums are the same
    masses = np.array([plain_number(character.bodies[body].mass) for body in held])
    away = np.array([poses[body][0] for body in held]) - anchor
    own = sum(max(plain_vector(character.bodies[body].inertia)) for body in held)
    inertia = float(masses @ np.sum(away * away, axis=1)) + own
    moment = GRAVITY * float(np.linalg.norm(masses @ away))  # N m, at a right angle to gravity
    stands = float(masses @ away[:, 1]) > 0.0
    stiffness = (UPRIGHT if stands else HANGING) * moment
    swinging = stiffness + (-moment if stands else moment)
    damping = 2.0 * DAMPING * math.sqrt(swinging * inertia)
    return Actuation("passive", rounded(stiffness), rounded(damping))


def _attachments(character: Character, poses: Poses, bodies: list[str], frame: str) -> Floats:
    """Points (n, 3) of muscles' paths on bodies, m, in the frame of one of them."""
    found = []
    for muscle in character.muscles.values():
        for point in muscle.path:
            if point.body in bodies:
                shift, turn = _relative(poses, point.body, frame)
                found.append(shift + rotate(turn, plain_vector(point.place())))
    return np.array(found).reshape(-1, 3)


def _relative(poses: Poses, body: str, frame: str) -> tuple[Floats, Floats]:
    """Position and orientation of a body in the frame of another one."""
    (place, turn), back = poses[body], conjugate(poses[frame][1])
    return np.asarray(rotate(back, place - poses[frame][0])), np.asarray(multiply(back, turn))


def _seen_from(poses: Poses, body: str, place: Floats) -> Floats:
    """A place in the world, m, in the frame of a body."""
    position, turn = poses[body]
    return np.asarray(rotate(conjugate(turn), place - position))


def _box(low: tuple[float, ...], high: tuple[float, ...]) -> Box:
    (x0, y0, z0), (x1, y1, z1) = (tuple(map(rounded_length, corner)) for corner in (low, high))
    return Box((x0, y0, z0), (x1, y1, z1))


def rounded_length(length: float) -> float:
    """A length to a tenth of a millimetre."""
    return round(float(length), 4)


def rounded(number: float) -> float:
    """A number to three digits."""
    return float(f"{number:.{DIGITS}g}")
