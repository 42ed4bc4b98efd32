"""Joints between the root body and the world. Arrays are (n, ...), n states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, normalized, twist_angle
from warpmuscle.scene.joints.joint_type import JointKinematics, MujocoJoint

X_AXIS = np.array([1.0, 0.0, 0.0])
_ORIENTATION = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True, kw_only=True)
class RootType:
    """One type of root; speeds that move it come before those that turn it, along axes of the world."""

    name: str  # in a scene
    device: str  # name of the constant in `kernels.structs`
    coordinates: tuple[str, ...]
    speeds: tuple[str, ...]
    moving: tuple[int, ...] = ()  # world axes of the speeds that move it, m/s
    turning: tuple[int, ...] = ()  # and of those that turn it, rad/s
    on_ground: tuple[int, ...] = ()  # coordinates that say where it is on the ground
    forward: int | None = None  # the one along z; None: it goes nowhere
    keyword: str = ""  # of the original program's files
    mujoco: tuple[MujocoJoint, ...] = ()

    @property
    def placed(self) -> bool:
        """Whether the coordinates are position and quaternion."""
        return len(self.coordinates) == 7

    def coordinates_of(
        self, position: Floats, orientation: Floats, velocity: Floats, angular_velocity: Floats
    ) -> tuple[Floats, Floats]:
        """Coordinates and speeds from its motion in the world, (n, 3) and (n, 4) each; also of its accelerations."""
        count = max(map(len, (position, orientation, velocity, angular_velocity)))
        turn = orientation if self.placed else twist_angle(orientation, X_AXIS)[:, None]
        place = position if self.placed else position[:, list(self.moving)]
        q = [np.broadcast_to(part, (count, part.shape[1])) for part in (place, turn)]
        rates = (velocity[:, list(self.moving)], angular_velocity[:, list(self.turning)])
        v = [np.broadcast_to(part, (count, part.shape[1])) for part in rates]
        return np.concatenate(q, axis=1), np.concatenate(v, axis=1)

    def velocity(self, speeds: Floats) -> Floats:
        """Velocity (n, 3) of the root, world, from all speeds (n, S)."""
        found = np.zeros((len(speeds), 3))
        found[:, list(self.moving)] = speeds[:, : len(self.moving)]
        return found

    def motion(self, q: Floats) -> JointKinematics:
        """Its pose and motion subspace at coordinates (n, C)."""
        zero = np.zeros((len(q), 3))
        position = q[:, :3]
        if not self.placed:
            position = zero.copy()
            position[:, list(self.moving)] = q[:, : len(self.moving)]
        orientation = normalized(q[:, 3:7]) if self.placed else about(X_AXIS, q[:, 2])
        unit: list[Floats] = [np.broadcast_to(axis, zero.shape) for axis in np.eye(3)]
        turning: list[Floats] = [zero] * len(self.moving) + [unit[k] for k in self.turning]
        moving: list[Floats] = [unit[k] for k in self.moving] + [zero] * len(self.turning)
        return JointKinematics(orientation, position, turning, moving, zero, zero)


FREE = RootType(
    name="free",
    device="ROOT_FREE",
    coordinates=("x", "y", "z", *_ORIENTATION),
    speeds=("x", "y", "z", "wx", "wy", "wz"),
    moving=(0, 1, 2),
    turning=(0, 1, 2),
    on_ground=(0, 2),
    forward=2,
    mujoco=(MujocoJoint("_free", "free", 0),),
)
PLANAR = RootType(
    name="planar",
    device="ROOT_PLANAR",
    coordinates=("y", "z", "turn"),
    speeds=("y", "z", "turn"),
    moving=(1, 2),
    turning=(0,),
    on_ground=(1,),
    forward=1,
    keyword="planar",
    mujoco=(MujocoJoint("_y", "slide", 1), MujocoJoint("_z", "slide", 2), MujocoJoint("_turn", "hinge", 0)),
)
FIXED_ROOT = RootType(
    name="fixed", device="ROOT_FIXED", coordinates=("x", "y", "z", *_ORIENTATION), speeds=(), keyword="static"
)
