"""From the description of a creature to its scene."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about
from warpmuscle.creatures.checks import check_creature
from warpmuscle.creatures.description import Creature, sided
from warpmuscle.creatures.gait import controller, moving_joints
from warpmuscle.creatures.muscles import muscles
from warpmuscle.creatures.skeleton import JOINT_AXIS, middle, place, quaternion, rounded, skeleton
from warpmuscle.formats.toml import Source
from warpmuscle.scene import Character, Failure, InitialState, JointState, MuscleModel, Objective, Scene
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.scene.initial_pose import plain_vector, world_poses
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene

FAILURE_COST = 1.0e4  # of who falls, above that of any gait
ABOVE_GROUND = 0.001  # m, of the lowest foot at the start
SLOWEST = 0.3  # of the wanted speed, below which nobody goes on, so that no search ends at standing still
WINDOW = 0.5  # s, over which its speed is taken for that
SIDEWAYS = (0.0, -0.4, 0.4)  # m/s to the left at the start of who moves in space: value, lowest, highest
OVERLAP = 0.01  # m, by which legs may pass into each other


def read_creature(path: str | Path) -> Creature:
    """The description in a TOML file.

    Raises:
        SceneError: what is wrong with it, with file, line and key.
    """
    source = Source.read(Path(path))
    try:
        creature = to_type(source.data, Creature)
        check_creature(creature)
    except SceneError as error:
        raise source.placed(error) from None
    return creature


def creature_scene(creature: Creature, name: str = "") -> Scene:
    """A scene of a creature, checked: what a search is to change is free in it.

    Args:
        name: of the scene; by default the creature's.

    Raises:
        SceneError: it is no sound creature, or makes no sound scene.
    """
    check_creature(creature)
    root, bodies, joints = skeleton(creature)
    feet = (sided(creature.gait.feet, "l"), sided(creature.gait.feet, "r"))
    bare = Character(
        root=root, bodies=bodies, joints=joints, root_joint="free" if creature.spatial else "planar", feet=feet
    )
    standing = InitialState(root_position=place(middle(creature.segments[root])))
    poses = world_poses(Scene(name=creature.name, character=bare, initial_state=standing))
    scene = Scene(
        name=name or creature.name,
        description=creature.description,
        character=muscles(creature, bare, poses),
        controller=controller(creature),
        initial_state=_start(creature, bare, standing),
        muscle_model=MuscleModel(sharing="least_effort", implicit_damping=True),
        failure=_failure(creature),
        objective=_objective(creature),
        duration=creature.duration,
        time_step=creature.time_step,
        implicit_pd=True,
    )
    try:
        check_scene(scene)
    except SceneError as error:
        raise _described(creature, error) from None
    return scene


def _described(creature: Creature, error: SceneError) -> SceneError:
    """An error of the scene at what describes it: the segment of a body, or a muscle."""
    kinds: dict[str, tuple[str, Iterable[str]]] = {
        "bodies": ("segments", creature.segments), "muscles": ("muscles", creature.muscles)
    }  # fmt: skip
    table, kind, own, *_ = *error.key.split("."), "", "", ""
    called, names = kinds.get(kind if table == "character" else "", ("", ()))
    for name in names:
        if own in (name, sided(name, "l"), sided(name, "r")):
            return SceneError(f"makes no sound scene: {error.key}: {error.message}", key=f"{called}.{name}")
    return error


def _start(creature: Creature, character: Character, standing: InitialState) -> InitialState:
    """The pose at the start, with the lowest point just above the ground, and a forward speed that a search finds."""
    joints: dict[str, JointState] = {}
    paired = moving_joints(creature)
    for name, angle in sorted(creature.gait.start.items(), key=lambda item: not paired.get(item[0])):
        names = [sided(name, side) for side in "lr"] if paired.get(name) else [name]
        turned = quaternion(about(np.array(JOINT_AXIS), np.array(angle)))
        joints |= {own: JointState(orientation=turned) for own in names}
    posed = Scene(
        name=creature.name, character=character, initial_state=InitialState(standing.root_position, joints=joints)
    )
    x, y, z = plain_vector(standing.root_position)
    height = rounded(y - lowest_point(character, world_poses(posed)) + ABOVE_GROUND)
    speed = creature.gait.speed
    free = Free(speed, rounded(0.3 * speed), rounded(1.5 * speed)) if speed > 0.0 else 0.0
    sideways = Free(*SIDEWAYS) if creature.spatial else 0.0
    return InitialState(root_position=(x, height, z), root_velocity=(sideways, 0.0, free), joints=joints)


def _failure(creature: Creature) -> Failure:
    """Who falls or stands still has failed, and in space who lets its legs pass through each other."""
    failure = Failure(
        com_height=creature.fall, no_progress=rounded(SLOWEST * creature.gait.speed), no_progress_window=WINDOW
    )
    if creature.spatial:
        legs = [name for name, segment in creature.segments.items() if segment.paired]
        pairs = [(sided(one, "l"), sided(other, "r")) for one in legs for other in legs]
        failure = msgspec.structs.replace(failure, self_collision=OVERLAP, self_collision_pairs=pairs)
    return failure


def _objective(creature: Creature) -> Objective:
    """What a search minimises: errors of the speed, metabolic energy, pulls at stops and of stretched fibres."""
    weights = {
        "speed": 100.0,
        "cost_of_transport": 5.0,
        "effort_cubed": 1.0,
        "joint_limits": 0.1,
        "passive_force": 0.002,
        "fibre_range": 3000.0,
    }
    if creature.spatial:
        weights["heading"] = 10.0
    return msgspec.structs.replace(Objective(), target_speed=creature.gait.speed, failure_cost=FAILURE_COST, **weights)
