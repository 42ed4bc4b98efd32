"""Joints that turn about a point which both bodies have: ball, universal joint and hinge; and none at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import orthogonal
from warpmuscle.core.pose import (
    about,
    conjugate,
    euler_xyz,
    hinge_coordinates,
    multiply,
    normalized,
    rotate,
    universal_coordinates,
)
from warpmuscle.scene import Joint
from warpmuscle.scene.joints.joint_type import JointKinematics, JointType, MujocoJoint
from warpmuscle.scene.validation.checks import Checks


class Ball(JointType):
    """Coordinates are the quaternion of the child in its parent, speeds the angular velocity along the child's axes."""

    @property
    def axes_optional(self) -> bool:
        return True

    def check(self, checks: Checks, key: str, joint: Joint) -> None:
        super().check(checks, key, joint)
        if joint.axes:
            checks.independent(f"{key}.axes", *joint.axes)

    def frame(self, joint: Joint) -> tuple[Floats, Floats]:
        a, b = super().frame(joint)
        return a, orthogonal(b, a)

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        return orientation, rotate(conjugate(orientation), angular_velocity)

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        orientation, zero = normalized(q), np.zeros((len(q), 3))
        turning = [rotate(orientation, np.broadcast_to(unit, (len(q), 3))) for unit in np.eye(3)]
        return JointKinematics(orientation, zero, turning, [zero] * 3, zero, zero)

    def shown(self, joint: Joint, orientation: Floats, place: Floats, breaks: ArrayLike = ()) -> Floats:
        return euler_xyz(orientation, breaks)

    def turned(self, joint: Joint, angles: Floats) -> Floats:
        x, y, z = (about(axis, angle) for axis, angle in zip(np.eye(3), angles.T, strict=True))
        return multiply(multiply(x, y), z)

    def components(self, joint: Joint, torque: Floats) -> Floats:
        return torque

    def posed(self, axis: int, angles: Floats, q: Floats) -> Floats:
        return about(np.eye(3)[axis], angles)

    def angles_of(self, joint: Joint, q: Floats) -> Floats:
        """Those that its limits are of: about swing, swing x twist and twist, as in `limits.ball_angles`."""
        swing, twist = self.frame(joint)
        middle = np.cross(swing, twist)

        def along(axis: Floats, turned: Floats) -> Floats:
            return np.asarray(np.sum(axis * rotate(q, turned), axis=-1))

        first = np.arctan2(along(middle, twist), along(twist, twist))
        second = -np.arcsin(np.clip(along(swing, twist), -1.0, 1.0))
        third = np.arctan2(along(swing, middle), along(swing, swing))
        return np.stack([first, second, third], axis=-1)

    def range(self, joint: Joint, axis: int) -> tuple[float, float] | None:
        return None  # its limits are about other axes


class Universal(JointType):
    """Angles alpha, beta with the child in its parent at rot(b, beta) rot(a, alpha)."""

    def check(self, checks: Checks, key: str, joint: Joint) -> None:
        super().check(checks, key, joint)
        checks.independent(f"{key}.axes", *joint.axes)

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        return universal_coordinates(orientation, angular_velocity, *self.frame(joint))

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        a, b = self.frame(joint)
        zero = np.zeros((len(q), 3))
        orientation = multiply(about(b, q[:, 1]), about(a, q[:, 0]))
        turning = [rotate(orientation, a), np.broadcast_to(b, zero.shape)]
        drift = np.cross(turning[1] * v[:, 1:], turning[0] * v[:, :1])  # axis a rides on what b turns
        return JointKinematics(orientation, zero, turning, [zero] * 2, drift, zero)


class Hinge(JointType):
    """One angle about an axis that both bodies have."""

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        return hinge_coordinates(orientation, angular_velocity, self.frame(joint)[0])

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        a, zero = self.frame(joint)[0], np.zeros((len(q), 3))
        return JointKinematics(about(a, q[:, 0]), zero, [np.broadcast_to(a, zero.shape)], [zero], zero, zero)


class Fixed(JointType):
    """The child is welded to its parent in the reference pose."""

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        return np.zeros((len(orientation), 0)), np.zeros((len(orientation), 0))

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        zero = np.zeros((len(q), 3))
        return JointKinematics(np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1)), zero, [], [], zero, zero)


BALL = Ball(
    name="ball",
    device="BALL",
    coordinates=("qx", "qy", "qz", "qw"),
    speeds=("x", "y", "z"),
    axes=2,
    limits=3,
    angles=("x", "y", "z"),
    angle_names=("about x", "about y", "about z"),
    mujoco=(MujocoJoint("", "ball", 0),),
    mujoco_coordinates=(3, 0, 1, 2),
    mujoco_speeds=(0, 1, 2),
    keyword="ballInSocketJoint",
    opposite_limits=(0, 2),
)
UNIVERSAL = Universal(
    name="universal",
    device="UNIVERSAL",
    coordinates=("0", "1"),
    speeds=("0", "1"),
    axes=2,
    limits=2,
    angles=("a", "b"),
    angle_names=("angle 1", "angle 2"),
    mujoco=(MujocoJoint("_b", "hinge", 1), MujocoJoint("_a", "hinge", 0)),
    mujoco_coordinates=(1, 0),
    mujoco_speeds=(1, 0),
    keyword="universalJoint",
)
HINGE = Hinge(
    name="hinge",
    device="HINGE",
    coordinates=("",),
    speeds=("",),
    axes=1,
    limits=1,
    angles=("",),
    angle_names=("angle",),
    mujoco=(MujocoJoint("", "hinge", 0),),
    mujoco_coordinates=(0,),
    mujoco_speeds=(0,),
    keyword="hingeJoint",
)
FIXED = Fixed(
    name="fixed",
    device="FIXED",
    coordinates=(),
    speeds=(),
    axes=0,
    limits=0,
    angles=(),
    angle_names=(),
    keyword="stiffJoint",
)
