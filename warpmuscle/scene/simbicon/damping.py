"""Damping of the joints that SIMBICON drives, as its PD control has it."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.joints import joint_type

BOUND = 2.0  # see `kernels.control.control.ExplicitDamping`: it takes speeds in the middle of the step before


def simbicon_damping(scene: Scene) -> dict[str, tuple[str, Floats]]:
    """Damping of each speed of each joint, N m s/rad, and the key of the scene that gives it.

    Args:
        scene: checked scene without free parameters that has this controller.
    """
    assert scene.controller is not None
    found: dict[str, tuple[str, Floats]] = {}
    for name, joint in scene.character.joints.items():
        gains, count = scene.controller.pd.get(name), len(joint_type(joint).speeds)
        if gains is not None and count:
            scale = plain_vector(gains.scale) if count == 3 else np.ones(count)
            found[name] = (f"controller.pd.{name}.kd", plain_number(gains.kd) * scale)
    return found
