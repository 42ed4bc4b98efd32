"""The motion that a scene itself tells of its joints, as if it had been recorded."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import twist_angle
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.throw.arm import X_AXIS, Arm, joint_positions
from warpmuscle.throw.motion import RATE, Motion


def motion_of(scene: Scene, arm: Arm) -> Motion:
    """The motion of a scene whose joints are all kinematic.

    Raises:
        SceneError: a joint that the arm's muscles move has no motion in it.
    """
    for name in arm.joints:
        if name not in scene.motion or not _whole(scene, name):
            raise SceneError(f"{scene.name} has no motion of {name!r}; name files with motions", key="motion")
    actuation = arm.actuation(dict.fromkeys(arm.joints, "kinematic"))
    rollout = Rollout(
        msgspec.structs.replace(scene, actuation=actuation), 1, "cpu", record=[0], record_rate=RATE,
        quantities=["coordinates", "speeds"],
    )  # fmt: skip
    rollout.run()
    coordinates = np.concatenate([rollout.recorded("coordinates")[0], rollout.state.coordinates.numpy()]).astype(float)
    time = np.arange(len(coordinates)) / RATE
    root = root_type(scene.character)
    pitch = np.unwrap(twist_angle(root.motion(coordinates).orientation, X_AXIS)) if root.speeds else np.zeros(len(time))
    place = joint_positions(arm, coordinates)[0][:, [2, 1]]
    return Motion(scene.name, 0.0, time, coordinates[:, arm.coordinate_places], pitch, place - place[0])


def _whole(scene: Scene, name: str) -> bool:
    """Whether the motion of a joint is one of all its angles, not of those alone beside what muscles move."""
    count, value = len(joint_type(scene.character.joints[name]).speeds), scene.motion[name].value
    return count == 1 or not value or len(value) == count
