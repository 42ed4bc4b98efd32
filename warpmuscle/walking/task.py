"""The text of a scene in which a model learns to walk: a base, and what a walk needs besides."""

from __future__ import annotations

import math
from typing import NamedTuple

from msgspec.structs import replace

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.toml_layout import inline, key_text
from warpmuscle.scene import Actuation, Box, Character, Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.scene.initial_pose import plain_vector, world_poses
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.joints.symmetry import is_symmetric
from warpmuscle.scene.masses import body_mass, massless
from warpmuscle.scene.norms import REFERENCES
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import subtree
from warpmuscle.walking.legs import Leg, find_legs, in_reference_pose
from warpmuscle.walking.support import has_soles, rounded, rounded_length, soles, springs

PERSON = 1.75  # m, for whose height speeds and times are given; those of others go with the root of their height
SPEEDS, CLOCK_SPEED = (1.0, 1.5), 1.25  # m/s
CYCLE_TIME = 2.0 * 60.0 / REFERENCES["cadence"].low  # s
PUSH = 50.0 / 75.0  # N s/kg
WEIGHTS = (4, 3, 3)  # of hip, knee and ankle, besides 1 of every other joint
TRUNK_WEIGHT = 2
STEP_WIDTH = 0.1 / PERSON  # m, over the height
PELVIS_TILT = 7  # deg; over 4 the feet of the key points are flat in mid-stance, over 9 they land as early as asked
PROGRESS = 0.3  # m/s, of a person; a body that has learnt to stand earns too much to find out how to walk
OBJECTIVE = """
[objective]
joint_limits = 0.02
metabolic = 0.02
metabolic_model = "bhargava"
""".rstrip().split("\n")
REWARDS = """
[learning.rewards]
speed = 20
speed_width = 0.4
progress = 20
alive = 10
imitation = 60
imitation_width = 0.15
force = 20
force_width = 0.2
overload = 60
objective = 1
action = 0.3
action_rate = 0.1

[learning.tightening]  # at first a body that falls soon must not lose less than one that tries to walk
costs = 0.15
decisions = 100_000_000
""".rstrip().split("\n")


class WalkingTask(NamedTuple):
    """What a model learns to walk with."""

    feet: tuple[str, str]
    soles: dict[str, Box]  # of feet and toes, where these have no shapes yet
    springs: dict[str, Actuation]
    root_position: tuple[float, float, float]  # m, at which the lowest point touches the ground
    height: float  # m, of a person with such legs
    mass: float  # kg
    joints: tuple[list[str], list[str]]  # hip, knee and ankle of either side
    trunk: list[str]  # joints between the root and the upper body
    symmetric: bool
    spatial: bool  # it may lean and step to its sides


def walking_task(scene: Scene) -> WalkingTask:
    """What a model needs to learn to walk.

    Args:
        scene: checked; its free parameters are at their start.

    Raises:
        SceneError: it has no two legs with hips, knees and ankles, no muscles, or a root that stays where it is.
    """
    numeric = at_start(scene)
    character = numeric.character
    if not character.muscles:
        raise SceneError("a walk is learnt by muscles, and it has none", key="character.muscles")
    if not root_type(character).moving:
        raise SceneError("the root is fixed, and cannot walk", key="character.root_joint")
    reference = in_reference_pose(numeric)
    legs = find_legs(reference)
    boxes: dict[str, Box] = {}
    if not has_soles(character, legs):
        boxes = {body: box for leg in legs for body, box in soles(reference, leg).items()}
    bodies = character.bodies | {name: replace(character.bodies[name], shapes=[box]) for name, box in boxes.items()}
    feet = (legs[0].foot, legs[1].foot)
    standing = replace(numeric, character=replace(character, bodies=bodies, feet=feet))
    return WalkingTask(
        feet,
        boxes,
        springs(reference, legs),
        _on_the_ground(standing),
        sum(leg.height() for leg in legs) / 2.0,
        body_mass(character),
        _legs_of(standing, legs),
        _trunk(character, legs),
        is_symmetric(standing.character),
        len(root_type(character).moving) > 2,
    )


def _on_the_ground(scene: Scene) -> tuple[float, float, float]:
    """Where the root starts so that the lowest point of the feet is on level ground, m."""
    x, y, z = plain_vector(scene.initial_state.root_position)
    return rounded_length(x), rounded_length(y - lowest_point(scene.character, world_poses(scene))), rounded_length(z)


def _legs_of(scene: Scene, legs: tuple[Leg, Leg]) -> tuple[list[str], list[str]]:
    """Hip, knee and ankle of either side."""
    left, right = leg_joints(scene, 0), leg_joints(scene, 1)
    for joints, leg in zip((left, right), legs, strict=True):
        if len(joints) < len(WEIGHTS):
            said = f"fewer than three joints bend between the root and {leg.foot!r}: {', '.join(joints) or 'none'}"
            raise SceneError(said, key="character.joints")
    return left, right


def _trunk(character: Character, legs: tuple[Leg, Leg]) -> list[str]:
    """Joints by which the root carries anything but legs, those after each other with nothing heavy between them."""
    found, above, feet = [], {character.root}, {leg.foot for leg in legs}
    for name, joint in character.joints.items():
        if joint.parent in above and not subtree(character, joint.child) & feet:
            if massless(character.bodies[joint.child]):
                above.add(joint.child)
            if joint_type(joint).speeds:
                found.append(name)
    return found


def text_of(task: WalkingTask, name: str, base: str, heading: str = "") -> str:
    """TOML text of a scene with this task.

    Args:
        name: of the scene. base: name of the file of the model, in the same folder. heading: first lines, comments.
    """
    lines = [
        *([heading] if heading else []),
        f"name = {inline(name)}",
        f"base = {inline(base)}",
        "duration = 10",
        *(["time_step = 0.001"] if task.soles else []),
        *(["implicit_pd = true  # springs of light toes would be too stiff for a step"] if task.springs else []),
        "",
        "[character]",
        f"feet = {inline(list(task.feet))}",
        *_sole_lines(task),
        "",
        "[initial_state]",
        f"root_position = {inline(list(task.root_position))}  # the lowest point is on the ground",
        f"root_velocity = {inline([0, 0, _scaled(task, SPEEDS[0])])}",
        *_spring_lines(task),
        "",
        "[failure]",
        f"no_progress = {inline(_scaled(task, PROGRESS))}  # m/s, so that standing is no way to stay up",
        *OBJECTIVE,
        *_learning_lines(task),
        *REWARDS,
        "",
        "[learning.variation]",
        "start_states = 100",
        "velocity_noise = 0.1",
        "mass = 0.1",
        f"push = {inline(rounded(PUSH * task.mass))}",
        "growth = 0.1  # of pushes and noise, with each episode that lasts",
    ]
    return "\n".join(lines) + "\n"


def _scaled(task: WalkingTask, number: float) -> float:
    """A speed or time of a person for this body, as dynamically similar gaits have it (Alexander 1983)."""
    return rounded(number * math.sqrt(task.height / PERSON))


def _learning_lines(task: WalkingTask) -> list[str]:
    """Tables of what is wanted and imitated."""
    speeds = [_scaled(task, speed) for speed in SPEEDS]
    weights = {name: weight for joints in task.joints for name, weight in zip(joints, WEIGHTS, strict=True)}
    weights |= dict.fromkeys(task.trunk, TRUNK_WEIGHT)
    return [
        "",
        "[learning]",
        f"speed = {inline(speeds)}  # m/s, for legs as those of a person of {task.height:.2f} m",
        "command_time = 5",
        "episode_time = 10",
        f"symmetric = {inline(task.symmetric)}",
        "",
        "[learning.imitation]",
        'norm = "key points"  # as people bend their hips, knees and ankles',
        "moving = true",
        f"pelvis_tilt = {PELVIS_TILT}",
        f"cycle_time = {inline(_scaled(task, CYCLE_TIME))}",
        f"clock_speed = {inline(_scaled(task, CLOCK_SPEED))}",
        "cadence_power = 0.58",
        *([f"step_width = {inline(rounded(STEP_WIDTH * task.height))}"] if task.spatial else []),
        "",
        "[learning.imitation.weights]",
        *(f"{key_text(joint)} = {weight}" for joint, weight in weights.items()),
    ]


def _sole_lines(task: WalkingTask) -> list[str]:
    """Tables of the bodies that get soles."""
    lines = []
    for body, box in task.soles.items():
        written = inline([{"type": "box", "low": box.low, "high": box.high}])
        lines += ["", f"[character.bodies.{key_text(body)}]", f"shapes = {written}"]
    return lines


def _spring_lines(task: WalkingTask) -> list[str]:
    """The table of springs."""
    if not task.springs:
        return []
    rows = [
        f"{key_text(name)} = {inline({'drive': one.drive, 'stiffness': one.stiffness, 'damping': one.damping})}"
        for name, one in task.springs.items()
    ]
    return ["", "[actuation]  # springs in the toes and where no muscle pulls", *rows]
