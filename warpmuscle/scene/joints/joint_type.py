"""What the host knows of a type of joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import normalized
from warpmuscle.scene import Joint, JointState
from warpmuscle.scene.validation.checks import Checks

NO_AXIS = (1.0, 0.0, 0.0)
OTHER_AXIS = (0.0, 1.0, 0.0)


class JointKinematics(NamedTuple):
    """How a joint of S speeds holds and moves its child in n states, in the parent's axes."""

    orientation: Floats  # (n, 4) of the child in its parent
    place: Floats  # (n, 3) m, of the child's joint point from that of the parent
    turning: list[Floats]  # S of (n, 3), angular velocity that a unit of each speed gives: the motion subspace's rows
    moving: list[Floats]  # S of (n, 3), and velocity of the child's joint point
    turning_drift: Floats  # (n, 3) rad/s^2, angular acceleration at constant speeds: the subspace's rate times them
    moving_drift: Floats  # (n, 3) m/s^2


class MujocoJoint(NamedTuple):
    """A joint of MuJoCo that stands for one of ours, or for a part of it."""

    suffix: str  # of its name
    kind: str
    axis: int  # which of our axes is its own


@dataclass(frozen=True, kw_only=True)
class JointType:
    """One type of joint; its subclasses say how one moves. Arrays are (rows, ...): one row, or a row an instance."""

    name: str  # in a scene
    device: str = ""  # name of the constant in `kernels.structs` that stands for it on the device
    kernel: str = (
        ""  # or, of a joint of one coordinate, `module:function` of its motion, see `kernels.body.joint_motion`
    )
    coordinates: tuple[str, ...]  # words behind the joint's name in names of coordinates
    speeds: tuple[str, ...]  # the same of speeds
    axes: int  # that a scene gives
    limits: int  # that a scene may give
    angles: tuple[str, ...]  # words behind the joint's name where files and figures show its angles
    angle_names: tuple[str, ...]  # the same in titles
    mujoco: tuple[MujocoJoint, ...] = ()  # outermost first; none: welded
    mujoco_coordinates: tuple[int, ...] = ()  # ours in MuJoCo's order
    mujoco_speeds: tuple[int, ...] = ()
    keyword: str = ""  # of the original program's files; none: they have no such joint
    opposite_limits: tuple[int, ...] = ()  # those that these files give with the other sign

    displaced = False  # whether it has `rotations` and `translations`

    @property
    def quaternion(self) -> bool:
        """Whether the coordinates are a quaternion, and the joint as a whole is prescribed or not."""
        return len(self.coordinates) > len(self.speeds)

    @property
    def by_coordinate(self) -> bool:
        """Whether its motion is a function of one coordinate, which moves the child's joint point, too."""
        return bool(self.kernel)

    @property
    def moves(self) -> bool:
        """Whether it has any speed."""
        return bool(self.speeds)

    @property
    def scalars(self) -> int:
        """How many coordinates are numbers of their own, on which conditions, pulleys and reflexes may depend."""
        return 0 if self.quaternion else len(self.coordinates)

    def angles_of(self, joint: Joint, q: Floats) -> Floats:
        """The angles or lengths (n, A) that conditions of paths may depend on, by coordinates (n, C)."""
        return q[:, : self.scalars]

    def check(self, checks: Checks, key: str, joint: Joint) -> None:
        """Raise SceneError unless a joint has the axes and limits of its type."""
        if len(joint.axes) != self.axes and not (self.axes_optional and not joint.axes and not joint.limits):
            raise SceneError(
                f"a {self.name} joint takes {number_of(self.axes, 'axis')}, got {len(joint.axes)}", key=f"{key}.axes"
            )
        if len(joint.limits) not in (0, self.limits):
            message = f"a {self.name} joint takes {number_of(self.limits, 'limit')} or none, got {len(joint.limits)}"
            raise SceneError(message, key=f"{key}.limits")
        for field in ("rotations", "translations"):
            if getattr(joint, field) and not self.displaced:
                raise SceneError(f"a {self.name} joint takes no {field}", key=f"{key}.{field}")
        for index, axis in enumerate(joint.axes):
            checks.not_zero(f"{key}.axes.{index}", axis, "axis")

    def check_state(self, checks: Checks, key: str, state: JointState) -> None:
        """Raise SceneError unless a joint of this type can start from a state."""
        checks.not_zero(f"{key}.orientation", state.orientation, "quaternion")
        for field in ("coordinate", "speed"):
            if getattr(state, field) != 0.0:
                message = f"a {self.name} joint starts from `orientation` and `angular_velocity`"
                raise SceneError(message, key=f"{key}.{field}")

    def unit(self, joint: Joint) -> str:
        """Unit of the coordinates and angles, rad or m; of a quaternion that of its angles."""
        return "rad"

    @property
    def axes_optional(self) -> bool:
        """Whether axes are needed with limits only."""
        return False

    def frame(self, joint: Joint) -> tuple[Floats, Floats]:
        """Axes a and b of a joint as (rows, 3) unit vectors, as `kernels.body_structs.BodyRow` has them."""
        return (
            normalized(rows(joint.axes[0] if joint.axes else NO_AXIS)),
            normalized(rows(joint.axes[-1] if joint.axes else OTHER_AXIS)),
        )

    def start(self, joint: Joint, state: JointState) -> tuple[Floats, Floats]:
        """Coordinates and speeds of a state of a scene."""
        return self.nearest(joint, normalized(rows(state.orientation)), rows(state.angular_velocity))

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        """Coordinates (n, C) and speeds (n, S) that come nearest to a child's motion relative to its parent.

        Args:
            orientation: child in parent, (n, 4) unit quaternions.
            angular_velocity: of the child relative to the parent, parent's axes, (n, 3), rad/s.
        """
        raise NotImplementedError

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        """How the joint holds and moves its child at coordinates (n, C) and speeds (n, S)."""
        raise NotImplementedError

    def shown(self, joint: Joint, orientation: Floats, place: Floats, breaks: ArrayLike = ()) -> Floats:
        """The angles (n, A), rad or m, that files and figures show.

        Args:
            orientation: of the child in its parent, (n, 4). place: as in `JointKinematics`, (n, 3).
            breaks: rows at which other motions begin; angles go on without jumps from row to row but there.
        """
        still = np.zeros((len(orientation), 3))
        return self.nearest(joint, orientation, still)[0]

    def turned(self, joint: Joint, angles: Floats) -> Floats:
        """Orientation (n, 4) of the child in its parent at the angles (n, A) of `shown`."""
        return self.motion(joint, angles, np.zeros_like(angles)).orientation

    def components(self, joint: Joint, torque: Floats) -> Floats:
        """Torque (n, 3) in the parent's axes along those of the joint, (n, A)."""
        axes = np.concatenate([np.zeros((0, 3)), *self.frame(joint)[: len(self.angles)]])
        return np.asarray(torque @ axes.T)

    def pulled_about(self, joint: Joint, q: Floats) -> list[Floats]:
        """Axes (n, 3), one a speed, parent's: along them the device keeps torques and moment arms."""
        return self.motion(joint, q, np.zeros((len(q), len(self.speeds)))).turning

    def posed(self, axis: int, angles: Floats, q: Floats) -> Floats:
        """Coordinates (n, C) with one degree of freedom at angles (n,), and the others as they were."""
        posed = q.copy()
        posed[:, axis] = angles
        return posed

    def range(self, joint: Joint, axis: int) -> tuple[float, float] | None:
        """Limits of a degree of freedom, if it has any."""
        if not joint.limits:
            return None
        low, high = (first_number(number) for number in joint.limits[axis])
        return low, high
