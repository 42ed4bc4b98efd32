"""Joints whose pose is a function of one coordinate, which a state gives as such."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Joint, JointState
from warpmuscle.scene.joints.joint_type import JointKinematics, JointType, MujocoJoint
from warpmuscle.scene.validation.checks import Checks


class Coordinate(JointType):
    """What such joints have in common. The device keeps their torques along axis a, see `coordinate_joint`."""

    def check_state(self, checks: Checks, key: str, state: JointState) -> None:
        for field in ("orientation", "angular_velocity"):
            if getattr(state, field) != getattr(JointState(), field):
                raise SceneError(f"a {self.name} joint starts from `coordinate` and `speed`", key=f"{key}.{field}")

    def start(self, joint: Joint, state: JointState) -> tuple[Floats, Floats]:
        return rows([state.coordinate]), rows([state.speed])

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        """The coordinate does not follow from the orientation; it is 0 unless `shown` finds it."""
        return np.zeros((len(orientation), 1)), np.zeros((len(orientation), 1))

    def pulled_about(self, joint: Joint, q: Floats) -> list[Floats]:
        still = np.zeros((len(q), 1))
        return [np.asarray(rotate(self.motion(joint, q, still).orientation, self.frame(joint)[0]))]


class Slide(Coordinate):
    """Translation along an axis; limits are in m, their stiffness and damping in N/m and N s/m."""

    def unit(self, joint: Joint) -> str:
        return "m"

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        a, zero = self.frame(joint)[0], np.zeros((len(q), 3))
        upright = np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1))
        return JointKinematics(upright, a * q, [zero], [np.broadcast_to(a, zero.shape)], zero, zero)

    def shown(self, joint: Joint, orientation: Floats, place: Floats, breaks: ArrayLike = ()) -> Floats:
        return np.asarray(np.sum(place * self.frame(joint)[0], axis=-1, keepdims=True))


SLIDE = Slide(
    name="slide",
    kernel="warpmuscle.kernels.body.joint_motion:slide_motion",
    coordinates=("",),
    speeds=("",),
    axes=1,
    limits=1,
    angles=("",),
    angle_names=("position",),
    mujoco=(MujocoJoint("", "slide", 0),),
    mujoco_coordinates=(0,),
    mujoco_speeds=(0,),
)
