"""What the start of a scene is probably mistaken in: bodies or the whole in the ground, speeds of no gait."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Scene
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import Poses, plain_number, plain_vector, world_poses
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.masses import center_of_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.validation.constraints import loop_warnings
from warpmuscle.scene.validation.damping import damping_warnings
from warpmuscle.scene.validation.muscles import SceneWarning, muscle_warnings
from warpmuscle.scene.validation.objective import sign_warnings
from warpmuscle.scene.validation.objects import object_warnings

LOOKED_AT = 100  # scenes of a sweep, which may have very many
DEEP = 0.02  # m in the ground, ten times as deep as feet that carry a body; beyond it the ground throws it up


def doubts_of(scene: Scene) -> list[SceneError]:
    """What is probably a mistake in a checked scene, as errors that are not raised, so that a reader can place them."""
    doubts = [*muscle_warnings(scene), *start_warnings(scene), *damping_warnings(scene), *sign_warnings(scene)]
    return [*doubts, *object_warnings(scene), *loop_warnings(scene)]


def start_warnings(scene: Scene) -> list[SceneError]:
    """Bodies or the whole deep in the ground, and a root that starts faster than any gait; see `doubts_of`.

    Free parameters count with their start values.
    """
    plain = at_start(scene)
    poses = world_poses(plain)
    return [*(_in_the_ground(plain, poses) or _below_the_ground(plain, poses)), *_too_fast(plain)]


def warn_of_changed_starts(where: str, changed: Iterable[tuple[str, Scene]], scenes: Iterable[Scene]) -> None:
    """Warn of starts that are in doubt only since scenes were changed, as on a slope; of what several have, once.

    Args:
        where: that what changes them is said. changed: first ones of them, with names. scenes: as they were.
    """
    before = list(scenes)
    known = {str(doubt) for scene in before for doubt in start_warnings(scene)}
    looked_at = [_what_starts(scene) for scene in before]
    for name, scene in itertools.islice(changed, LOOKED_AT):
        own = _what_starts(scene)
        if own in looked_at:  # most scenes of a sweep start alike, and to compare them takes a hundredth of the time
            continue
        looked_at.append(own)
        for doubt in start_warnings(scene):
            if str(doubt) not in known:
                known.add(str(doubt))
                warnings.warn(f"{where}: {name}: {doubt}", SceneWarning, stacklevel=4)


def _what_starts(scene: Scene) -> tuple[Any, ...]:
    """All of a scene that `start_warnings` depends on."""
    body, failure = scene.character, scene.failure
    return (
        scene.initial_state, scene.ground, body.root_joint, body.bodies, body.joints,
        failure.com_height, failure.max_com_speed,
    )  # fmt: skip


def _in_the_ground(scene: Scene, poses: Poses) -> list[SceneError]:
    """One for the deepest body of all that are deep in the ground."""
    if plain_number(scene.ground.stiffness) <= 0.0:
        return []
    depths = start_depths(scene, poses)
    deepest = max(depths, key=lambda name: depths[name], default="")
    if not deepest or not depths[deepest] > DEEP:
        return []
    depth = depths[deepest]
    others = sum(other > DEEP for other in depths.values()) - 1
    among = f", the deepest of {number_of(others + 1, 'body')}" if others else ""
    fixed = not root_type(scene.character).moving
    key = "ground.height" if fixed else "initial_state.root_position"
    remedy = (
        f"lower ground.height by {depth:.2f} m" if fixed else f"raise the root by {depth:.2f} m, or lower the ground"
    )
    return [
        SceneError(
            f"{deepest} starts {depth:.2f} m deep in the ground{among}, which will throw the character up; {remedy}",
            key,
        )
    ]


def _below_the_ground(scene: Scene, poses: Poses) -> list[SceneError]:
    """One if the centre of mass starts below the ground, where it counts as fallen at once."""
    if plain_number(scene.failure.com_height) <= 0.0:
        return []
    com = center_of_mass(scene.character, {name: position for name, (position, _) in poses.items()})
    depth = -float(surface(scene.ground).above(com))
    if depth < 0.0:
        return []
    message = (
        f"the centre of mass starts {depth:.2f} m below the ground, so that it has fallen at once; raise the root, or "
        "set failure.com_height to 0"
    )
    return [SceneError(message, "initial_state.root_position")]


def _too_fast(scene: Scene) -> list[SceneError]:
    """One if the root starts at a speed that is divergence."""
    speed = float(np.linalg.norm(plain_vector(scene.initial_state.root_velocity)))
    most = plain_number(scene.failure.max_com_speed)
    if not root_type(scene.character).moving or speed <= most:
        return []
    message = f"the root starts at {speed:.3g} m/s, and beyond failure.max_com_speed {most:g} m/s it has diverged"
    return [SceneError(message, "initial_state.root_velocity")]


def start_depths(scene: Scene, poses: Poses | None = None) -> dict[str, float]:
    """How deep every body with shapes starts in the ground, m; negative above it.

    Args:
        scene: checked scene without free parameters.
        poses: of its bodies in the world, where somebody knows them.
    """
    poses, ground = poses or world_poses(scene), surface(scene.ground)
    found = {}
    for name, body in scene.character.bodies.items():
        position, orientation = poses[name]
        depths = [
            plain_number(radius) - float(ground.above(position + rotate(orientation, point)))
            for shape in body.shapes
            for point, radius in ((plain_vector(point), radius) for point, radius in contact_points(shape))
        ]
        if depths:
            found[name] = float(max(depths))
    return found
