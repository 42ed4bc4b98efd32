"""The stages of a step one at a time, for a batch of given states: for tests and for pipelines of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.arrays import Floats
from warpmuscle.frames import Frames
from warpmuscle.kernels import stages, structs
from warpmuscle.kernels.lanes import capacity_of, work_floats
from warpmuscle.model import joint_coordinates, model_struct, root_coordinates
from warpmuscle.muscles import muscle_kind
from warpmuscle.paths import path_table, paths_struct
from warpmuscle.pose import normalized
from warpmuscle.recording import MUSCLE_QUANTITIES
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Scene


@dataclass(frozen=True)
class MusclePaths:
    """Geometry of all M muscles of a character in n states; a crossing is a joint and a muscle acting on it."""

    length: Floats  # (n, M) m
    speed: Floats  # (n, M) m/s
    moment_arm: Floats  # (n, C, 3) m, world: a tension F puts the torque F r on the joint's parent
    muscle: tuple[int, ...]  # (C,) of each crossing
    joint: tuple[int, ...]  # (C,) as in `names.joints`


class Stages(Rollout):
    """A rollout whose states are set from outside and whose stages are run one by one.

    All results are float32 NumPy arrays; bodies and joints are numbered as in `names`.
    """

    def __init__(self, scene: Scene, instances: int = 1, device: str | None = None) -> None:
        """Prepare room for so many states; see `Rollout`."""
        super().__init__(scene, instances, device)
        floats = work_floats(capacity_of(len(self.names.bodies)))
        self._workspace = wp.zeros((instances, floats), dtype=float, device=self.device)

    def set_state(
        self,
        root_position: ArrayLike,
        root_orientation: ArrayLike,
        root_velocity: ArrayLike,
        root_angular_velocity: ArrayLike,
        joint_orientation: ArrayLike,
        joint_angular_velocity: ArrayLike,
        *,
        phase: ArrayLike = 0.0,
        stance: ArrayLike = 0,
        machine_state: ArrayLike = 0,
        foot_force: ArrayLike = 0.0,
    ) -> None:
        """Set the states of all instances, n = instances, J = joints.

        Args:
            root_position: (n, 3) m. root_orientation: (n, 4) x, y, z, w.
            root_velocity, root_angular_velocity: (n, 3) world, m/s and rad/s.
            joint_orientation: (n, J, 4) child in parent; hinges and universal joints take the nearest angles.
            joint_angular_velocity: (n, J, 3) of the child relative to the parent, parent's axes, rad/s.
            phase, stance (0 left, 1 right), machine_state: (n,) of the controller.
            foot_force: (n, 2, 3) N, on the left and the right foot in the step before.
        """
        n = self.instances
        position, velocity, angular = (
            np.asarray(v, dtype=np.float64) for v in (root_position, root_velocity, root_angular_velocity)
        )
        kind = self.scene.character.root_joint
        root_q, root_v = root_coordinates(kind, position, normalized(root_orientation), velocity, angular)
        coordinates, speeds = [root_q], [root_v]
        orientation, rate = normalized(joint_orientation), np.asarray(joint_angular_velocity, dtype=np.float64)
        for i, name in enumerate(self.names.joints):
            joint_q, joint_v = joint_coordinates(self._numeric.character.joints[name], orientation[:, i], rate[:, i])
            coordinates.append(joint_q)
            speeds.append(joint_v)
        s = self._state
        s.accelerations.zero_()
        s.coordinates.assign(np.concatenate(coordinates, axis=1).astype(np.float32))
        s.speeds.assign(np.concatenate(speeds, axis=1).astype(np.float32))
        s.phase.assign(np.broadcast_to(np.asarray(phase, np.float32), (n,)).copy())
        s.stance.assign(np.broadcast_to(np.asarray(stance, np.int32), (n,)).copy())
        s.machine_state.assign(np.broadcast_to(np.asarray(machine_state, np.int32), (n,)).copy())
        s.foot_force.assign(np.broadcast_to(np.asarray(foot_force, np.float32), (n, 2, 3)).copy())

    def _run(self, kernel: Any, inputs: list[Any], outputs: Sequence[tuple[tuple[int, ...], Any]]) -> list[Floats]:
        arrays = [wp.zeros((self.instances, *shape), dtype=dtype, device=self.device) for shape, dtype in outputs]
        base = [self._model, self._state, self._workspace, *inputs]
        wp.launch(kernel, dim=self.instances, inputs=base, outputs=arrays, device=self.device)
        return [array.numpy() for array in arrays]

    def forward_kinematics(self) -> dict[str, Floats]:
        """Of all bodies: position, velocity (n, B, 3), orientation (n, B, 4), angular_velocity; com (n, 2, 3)."""
        b = len(self.names.bodies)
        outputs = [((b,), wp.vec3), ((b,), wp.quat), ((b,), wp.vec3), ((b,), wp.vec3), ((2,), wp.vec3)]
        names = ("position", "orientation", "velocity", "angular_velocity", "com")
        return dict(zip(names, self._run(stages.forward_kinematics, [], outputs), strict=True))

    def controller_torques(self) -> tuple[Floats, Floats]:
        """Targets (n, J, 4) and torques (n, J, 3), world, N m, + on the parent and - on the child."""
        b = len(self.names.bodies)
        target, torque = self._run(stages.controller_torques, [], [((b,), wp.quat), ((b,), wp.vec3)])
        return target[:, 1:], torque[:, 1:]

    def contact_forces(self) -> tuple[Floats, Floats]:
        """Contact force on every body (n, B, 3), N, and its moment about the body's centre of mass, N m."""
        b = len(self.names.bodies)
        force, moment = self._run(stages.contact_forces, [], [((b,), wp.vec3), ((b,), wp.vec3)])
        return force, moment

    def muscle_paths(self) -> MusclePaths:
        """Paths of all muscles of the character, whether or not they drive a joint."""
        character, names = self._numeric.character, self.names
        paths = character.muscles
        table = path_table(paths, names, character)
        self._model.paths = paths_struct(paths, names, character, self.device)
        self._model.muscles.count = len(paths)
        count = max(len(paths), 1)
        outputs = [((count,), float), ((count,), float), ((max(len(table.crossings), 1),), wp.vec3)]
        length, speed, arm = self._run(stages.muscle_paths, [], outputs)
        muscles, joints = ([getattr(c, key) for c in table.crossings] for key in ("muscle", "joint"))
        self._model = model_struct(self._numeric, names, self._driven, self.device)
        return MusclePaths(
            length[:, : len(paths)], speed[:, : len(paths)], arm[:, : len(muscles)],
            tuple(muscles), tuple(joint - 1 for joint in joints),
        )  # fmt: skip

    def muscle_torques(self, desired: ArrayLike) -> tuple[Floats, dict[str, Floats]]:
        """Let the simulated muscles answer to desired joint torques (n, J, 3), world, for one step.

        Activations, delay lines and fibre lengths are kept from call to call; `reset` puts them back to their start.

        Returns:
            The torques that drive the joints (n, J, 3), and by name the quantities of the muscles (n, M), as in
            `recording.MUSCLE_QUANTITIES`.
        """
        n, b = self.instances, len(self.names.bodies)
        torque = np.zeros((n, b, 3), dtype=np.float32)
        torque[:, 1:] = desired
        given = wp.array(torque, dtype=wp.vec3, device=self.device)
        frames = Frames(self.names, self._driven.muscles, n, list(range(n)), 1, 1, self.device)
        kernel = stages.muscle_torques(muscle_kind(self.scene.muscle_model, self._driven.of(self.scene)))
        result = self._run(kernel, [given, frames.record], [((b,), wp.vec3)])[0]
        quantities = frames.record.muscle.numpy()[:, 0, :, : len(self._driven.muscles)]
        return result[:, 1:], {name: quantities[:, k] for k, name in enumerate(MUSCLE_QUANTITIES)}

    def forward_dynamics(self, joint_torque: ArrayLike = 0.0) -> dict[str, Floats]:
        """Accelerations under joint torques (n, J, 3), world, + on the parent.

        Returns:
            speed_rate (n, S); of all bodies acceleration of the centre of mass and angular_acceleration (n, B, 3).
        """
        n, b = self.instances, len(self.names.bodies)
        torque = np.zeros((n, b, 3), dtype=np.float32)
        torque[:, 1:] = joint_torque
        given = wp.array(torque, dtype=wp.vec3, device=self.device)
        outputs = [((self.names.speeds,), float), ((b,), wp.vec3), ((b,), wp.vec3)]
        results = self._run(stages.forward_dynamics, [given], outputs)
        return dict(zip(("speed_rate", "acceleration", "angular_acceleration"), results, strict=True))

    def mass_matrix(self) -> Floats:
        """Joint-space inertia (n, S, S)."""
        return self._run(stages.mass_matrix, [], [((self.names.speeds, self.names.speeds), float)])[0]

    @property
    def structs(self) -> tuple[structs.Model, structs.State]:
        """Model and state as Warp structures, for kernels of one's own."""
        return self._model, self._state
