"""Properties of muscles fitted to a skeleton and its gait by one rule, for any character.

Slack lengths and forces taken over from another model seldom suit a skeleton: a muscle that is too short for its path
is a passive spring, one that is too long pulls on nothing, and sides that differ make a gait turn. The rule

- lets the character make its motion on torques, and takes each path's mean length L and mean moment arm |r| over it;
- keeps the optimal fibre length, but makes it at least `fibre_per_arm` |r|, so that the muscle works over the joint's
  range, and at most so long that a tenth of the path is left for the tendon;
- sets the slack length to L - `mean_length` l_opt, so that the fibre works about there;
- gives both sides the same properties: means of lengths, and the greater f_max, times `strength`.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from warpmuscle.core.arguments import as_number
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation, Muscle, Part, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.symmetry import counterpart
from warpmuscle.scene.number import Number
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

LEAST_TENDON = 0.1  # of the path


class Properties(Part):
    """What is fitted of a muscle, as in `scene.Muscle`."""

    f_max: Number
    l_opt: Number
    l_slack: Number


class PropertyTable(Part):
    """Fitted properties as the tables of a TOML file that adds to a character."""

    muscles: dict[str, Properties]

    @classmethod
    def of(cls, scene: Scene) -> PropertyTable:
        """The properties of all muscles of a scene."""
        muscles = scene.character.muscles
        return cls({name: Properties(m.f_max, m.l_opt, m.l_slack) for name, m in muscles.items()})


@dataclass(frozen=True)
class Geometry:
    """Means over a motion, by muscle."""

    length: Floats  # (M,) m, of the path
    arm: Floats  # (M,) m, of the moment arm, at the joint where it is greatest


def fit_muscles(
    scene: Scene,
    *,
    mean_length: float = 1.0,
    fibre_per_arm: float = 1.0,
    strength: float = 1.5,
    settle: float = 1.0,
    device: str | None = None,
) -> Scene:
    """The scene with fitted f_max, l_opt and l_slack of all muscles, see the module; numbers are no longer free.

    Args:
        scene: its motion is made on torques, over its duration.
        mean_length: fibre length over l_opt at the mean length of the path.
        fibre_per_arm: least optimal fibre length over the mean moment arm.
        strength: factor on f_max.
        settle: time at the start that does not count, s, where the motion lasts longer.
        device: see `make_rollout`; of several the first one.

    Raises:
        ArgumentError: a number is not finite, or not positive.
        SceneError: the scene has no muscles, or the motion fails on torques before anything could be measured.
    """
    mean_length = as_number(mean_length, "mean_length", above=0)
    fibre_per_arm = as_number(fibre_per_arm, "fibre_per_arm", least=0)
    strength = as_number(strength, "strength", above=0)
    settle = as_number(settle, "settle", least=0)
    scene = at_start(scene)
    muscles = scene.character.muscles
    if not muscles:
        raise SceneError("the character has no muscles to fit", key="character.muscles")
    geometry = muscle_geometry(scene, torque_motion(scene, settle, device))
    fitted = {}
    for i, name in enumerate(muscles):
        pair = [i, *(k for k, other in enumerate(muscles) if other == counterpart(name, muscles))]
        both = [list(muscles.values())[k] for k in pair]
        length, arm = float(geometry.length[pair].mean()), float(geometry.arm[pair].mean())
        fitted[name] = _fitted(muscles[name], both, length, arm, mean_length, fibre_per_arm, strength)
    character = msgspec.structs.replace(scene.character, muscles=fitted)
    return msgspec.structs.replace(scene, character=character)


def _fitted(
    muscle: Muscle, both: list[Muscle], length: float, arm: float, mean_length: float, per_arm: float, strength: float
) -> Muscle:
    """A muscle with fitted properties, of the muscles of both sides, rounded to 0.1 mm and 1 N."""
    l_opt = max(float(np.mean([m.l_opt for m in both])), per_arm * arm)
    l_opt = min(l_opt, (1.0 - LEAST_TENDON) * length / mean_length)
    f_max = strength * max(float(m.f_max) for m in both)  # type: ignore[arg-type]
    return msgspec.structs.replace(
        muscle, f_max=round(f_max), l_opt=round(l_opt, 4), l_slack=round(length - mean_length * l_opt, 4)
    )


def torque_motion(scene: Scene, settle: float, device: str | None) -> Recording:
    """The motion that the scene makes on torques alone, without its first seconds if it lasts longer than those."""
    joints = {name: Actuation("torque") for name, joint in scene.character.joints.items() if joint_type(joint).moves}
    rollout = Rollout(
        msgspec.structs.replace(scene, actuation=joints), 1, str(find_devices(device)[0]), record=[0], threads=1
    )
    rollout.run()
    motion = rollout.recording()
    if motion.frames == 0:
        raise SceneError("the motion on torques ends at once, so that there is nothing to fit the muscles to")
    return motion.window(settle) if motion.time[-1] > settle else motion


def muscle_geometry(scene: Scene, motion: Recording) -> Geometry:
    """Mean path lengths and moment arms of all muscles over a motion."""
    stages = Stages(without_code(scene), motion.frames, "cpu")
    stages.set_state(
        motion.root_position, motion.root_orientation, motion.root_velocity, motion.root_angular_velocity,
        motion.joint_orientation, motion.joint_angular_velocity,
    )  # fmt: skip
    paths = stages.muscle_paths()
    arm = np.zeros(len(scene.character.muscles))
    mean = np.linalg.norm(paths.moment_arm, axis=-1).mean(axis=0)
    for k, muscle in enumerate(paths.muscle):
        arm[muscle] = max(arm[muscle], mean[k])
    return Geometry(paths.length.mean(axis=0), arm)
