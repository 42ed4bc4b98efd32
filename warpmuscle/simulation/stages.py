"""The stages of a step one at a time, for a batch of states: for tests and for other pipelines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.pose import normalized
from warpmuscle.formats import SceneLike
from warpmuscle.kernels import stages, structs
from warpmuscle.kernels.contact.contact_laws import LAWS
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.model.build import replaced
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.joints import joint_number
from warpmuscle.model.muscles import muscle_kind, shared_joints
from warpmuscle.model.path_table import path_table
from warpmuscle.model.paths import paths_struct, route_struct
from warpmuscle.model.polynomials import monomial_room
from warpmuscle.results.recorded_quantities import MUSCLE_QUANTITIES
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.simulation.kernel_cache import launched
from warpmuscle.simulation.recorder import Recorder
from warpmuscle.simulation.rollout import Rollout

GREATEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class MusclePaths:
    """Geometry of all M muscles of a character in n states; a crossing is a joint and a muscle acting on it."""

    length: Floats  # (n, M) m
    speed: Floats  # (n, M) m/s
    moment_arm: Floats  # (n, C, 3) m, world: a tension F puts the torque F r on the joint's parent
    muscle: tuple[int, ...]  # (C,) of each crossing
    joint: tuple[int, ...]  # (C,) as in `names.joints`


class Contacts(NamedTuple):
    """Contacts of all B bodies with the ground in n states, at the start of a step.

    Over the step the force becomes less by C a + B^T alpha and the moment about its joint by A alpha + B a, where
    the joint accelerates by a and the body turns faster by alpha (see `kernels.contact.contact`).
    """

    force: Floats  # (n, B, 3) N
    moment: Floats  # (n, B, 3) N m, about the centre of mass
    a: Floats  # (n, B, 3, 3) kg m^2
    b: Floats  # (n, B, 3, 3) kg m
    c: Floats  # (n, B, 3, 3) kg


class Stages(Rollout):
    """A batch whose states are set by the caller and whose stages of a step are run one at a time.

    All results are float32 NumPy arrays; bodies and joints are numbered as in `names`.

    Attributes:
        workspace: scratch memory on the device that kernels of `kernels.stages` take.
    """

    def __init__(self, scene: SceneLike, instances: int = 1, device: str | None = None, *, trust: bool = False) -> None:
        """Prepare room for so many states; see `Rollout`.

        Raises:
            RolloutError: see there; or a joint of a type that was registered, which only the whole step has.
        """
        super().__init__(scene, instances, device, trust=trust)
        known = {joint.number for joint in stages.KNOWN_JOINTS if joint in self.structure.skeleton.joints}
        for name, joint in self.scene.character.joints.items():
            if joint_type(joint).by_coordinate and joint_number(name, self.scene.character) not in known:
                raise RolloutError(f"single stages know no {joint.type} joint; run the whole step instead")
        monomials = monomial_room(self.scene.character.muscles.values())
        skeleton = self.structure.skeleton
        floats = work_floats(
            capacity_of(len(self.names.bodies)), True, monomials, followed=skeleton.open, pushes=skeleton.constraints,
            entries=skeleton.entries,
        )  # fmt: skip
        self.workspace = wp.zeros((self.instances, floats), dtype=float, device=self.device)

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
        joint_coordinate: ArrayLike = 0.0,
        joint_speed: ArrayLike = 0.0,
    ) -> None:
        """Set the states of all instances, n = instances, J = joints.

        Args:
            root_position: (n, 3) m. root_orientation: (n, 4) x, y, z, w.
            root_velocity, root_angular_velocity: (n, 3) world, m/s and rad/s.
            joint_orientation: (n, J, 4) child in parent; hinges and universal joints take the nearest angles.
            joint_angular_velocity: (n, J, 3) of the child relative to the parent, parent's axes, rad/s.
            phase, stance (0 left, 1 right), machine_state: (n,) of a SIMBICON controller.
            foot_force: (n, 2, 3) N, on the left and the right foot in the step before.
            joint_coordinate, joint_speed: (n, J) of joints whose motion is a function of one coordinate, m or rad.

        Raises:
            RolloutError: another shape, or a number that is not finite.
        """
        joints = len(self.names.joints)
        position = self._rows(root_position, "root_position", 3)
        velocity = self._rows(root_velocity, "root_velocity", 3)
        angular = self._rows(root_angular_velocity, "root_angular_velocity", 3)
        turned = self._turns(root_orientation, "root_orientation", 4)
        orientation = self._turns(joint_orientation, "joint_orientation", joints, 4)
        rate = self._rows(joint_angular_velocity, "joint_angular_velocity", joints, 3)
        feet = self._rows(foot_force, "foot_force", 2, 3)
        coordinate = self._rows(joint_coordinate, "joint_coordinate", joints)
        speed = self._rows(joint_speed, "joint_speed", joints)
        states = 1 if self.scene.simbicon is None else len(self.scene.simbicon.states)
        most = {"phase": np.inf, "stance": 1, "machine_state": states - 1}
        of_controller = {"phase": phase, "stance": stance, "machine_state": machine_state}
        numbers = {name: self._rows(values, name) for name, values in of_controller.items()}
        for name, values in numbers.items():
            if np.any((values < 0.0) | (values > most[name])):
                raise RolloutError(f"{name} must lie within 0 and {most[name]:g}")
        root = root_type(self.scene.character)
        root_q, root_v = root.coordinates_of(position, turned, velocity, angular)
        coordinates, speeds = [root_q], [root_v]
        for i, name in enumerate(self.names.joints):
            joint = self.numeric.character.joints[name]
            joint_q, joint_v = joint_type(joint).nearest(joint, orientation[:, i], rate[:, i])
            if joint_type(joint).by_coordinate and joint_type(joint).moves:
                joint_q, joint_v = coordinate[:, i : i + 1], speed[:, i : i + 1]
            coordinates.append(joint_q)
            speeds.append(joint_v)
        s = self.state
        s.accelerations.zero_()
        s.coordinates.assign(np.concatenate(coordinates, axis=1).astype(np.float32))
        s.speeds.assign(np.concatenate(speeds, axis=1).astype(np.float32))
        if self.scene.simbicon is not None:
            s.simbicon.phase.assign(numbers["phase"].astype(np.float32))
            s.simbicon.stance.assign(numbers["stance"].astype(np.int32))
            s.simbicon.machine_state.assign(numbers["machine_state"].astype(np.int32))
        s.foot_force.assign(feet.astype(np.float32))

    def _rows(self, values: ArrayLike, name: str, *shape: int) -> Floats:
        """Finite numbers of all instances, (n, *shape), also from one number or row for all of them."""
        array, full = as_array(values, name, error=RolloutError), (self.instances, *shape)
        try:
            every = np.broadcast_to(array, full).astype(np.float64)
        except ValueError:
            raise RolloutError(f"{name} has shape {array.shape}, not {full}") from None
        if not np.all(np.abs(every) <= GREATEST):
            raise RolloutError(f"a number of {name} is not finite, or too great")
        return every

    def _turns(self, values: ArrayLike, name: str, *shape: int) -> Floats:
        """Quaternions of all instances, (n, *shape), of unit length."""
        every = self._rows(values, name, *shape)
        if np.any(np.linalg.norm(every, axis=-1) < 1e-6):
            raise RolloutError(f"a quaternion of {name} has no length")
        return normalized(every)

    def _run(self, kernel: Any, inputs: list[Any], outputs: Sequence[tuple[tuple[int, ...], Any]]) -> list[Floats]:
        arrays = [wp.zeros((self.instances, *shape), dtype=dtype, device=self.device) for shape, dtype in outputs]
        base = [self.model, self.state, self.workspace, *inputs]
        with launched(kernel, self.device, "what measures bodies and muscles"):
            wp.launch(kernel, dim=self.instances, inputs=base, outputs=arrays, device=self.device)
        return [array.numpy() for array in arrays]

    @property
    def force_extensions(self) -> Any:
        """Parameters of the scene's forces on the device, as kernels of `kernels.force` take them."""
        return self._extensions.struct.rest

    def forward_kinematics(self) -> dict[str, Floats]:
        """Of all bodies: position, velocity (n, B, 3), orientation (n, B, 4), angular_velocity; com (n, 2, 3)."""
        b = len(self.names.bodies)
        outputs = [((b,), wp.vec3), ((b,), wp.quat), ((b,), wp.vec3), ((b,), wp.vec3), ((2,), wp.vec3)]
        names = ("position", "orientation", "velocity", "angular_velocity", "com")
        return dict(zip(names, self._run(stages.forward_kinematics, [], outputs), strict=True))

    def controller_torques(self) -> tuple[Floats, Floats]:
        """Targets (n, J, 4) and torques (n, J, 3), world, N m, + on the parent and - on the child."""
        b = len(self.names.bodies)
        kernel = stages.controller_torques(self.structure.controller)
        target, torque = self._run(kernel, [self._extensions.struct.first], [((b,), wp.quat), ((b,), wp.vec3)])
        return target[:, 1:], torque[:, 1:]

    def contact_forces(self) -> tuple[Floats, Floats]:
        """Contact force on every body (n, B, 3), N, and its moment about the body's centre of mass, N m."""
        return self.contacts()[:2]

    def contacts(self) -> Contacts:
        """Contacts of every body with the ground: forces, and the inertia that they add in an implicit step."""
        b = len(self.names.bodies)
        kernel = stages.contact_forces_of(
            LAWS[self.scene.ground.law], self.structure.skeleton.terrain, self.structure.skeleton.moves
        )
        return Contacts(*self._run(kernel, [], [((b,), dtype) for dtype in (wp.vec3, wp.vec3, *[wp.mat33] * 3)]))

    def muscle_paths(self) -> MusclePaths:
        """Paths of all muscles of the character, whether or not they drive a joint."""
        character, names = self.numeric.character, self.names
        paths = character.muscles
        table = path_table(paths, names, character)
        grouped = grouped_paths(table, names, character, together=False)
        fields = {"paths": paths_struct(table, grouped, names, character, self.device), "muscles.count": len(paths)}
        fields["routes"] = route_struct(table, grouped, paths, names, character, self.device)
        kind = grouped.kind_of(self.scene.character.muscles.values(), self.scene.character)
        kernel = stages.muscle_paths_of(kind)
        count = max(len(paths), 1)
        outputs = [((count,), float), ((count,), float), ((max(len(table.crossings), 1),), wp.vec3)]
        with replaced(self.model, fields):
            length, speed, arm = self._run(kernel, [], outputs)
        muscles, joints = ([getattr(c, key) for c in table.crossings] for key in ("muscle", "joint"))
        return MusclePaths(
            length[:, : len(paths)], speed[:, : len(paths)], arm[:, : len(muscles)],
            tuple(muscles), tuple(joint - 1 for joint in joints),
        )  # fmt: skip

    def muscle_torques(self, desired: ArrayLike) -> tuple[Floats, dict[str, Floats]]:
        """Run the simulated muscles for one step towards desired joint torques (n, J, 3), world.

        Activations, delay lines and fibre lengths are kept from call to call; `reset` puts them back to their start.

        Returns:
            The torques that drive the joints (n, J, 3), and by name the quantities of the muscles (n, M), as in
            `recording.MUSCLE_QUANTITIES`.
        """
        n, b = self.instances, len(self.names.bodies)
        torque = np.zeros((n, b, 3), dtype=np.float32)
        torque[:, 1:] = self._rows(desired, "desired", b - 1, 3)
        torques = wp.array(torque, dtype=wp.vec3, device=self.device)
        actuation = self.structure.actuation
        recorder = Recorder(self.structure, n, list(range(n)), 1, 1, self.device)
        muscles = actuation.of(self.scene)
        grouped = grouped_paths(actuation.table, self.names, self.scene.character)
        kind = muscle_kind(self.scene.muscle_model, muscles)._replace(
            coordinate_joints=bool(self.structure.skeleton.joints), followers=self.structure.skeleton.follows,
            paths=grouped.kind_of(muscles, self.scene.character),
            shared=shared_joints(self.scene, self.names, actuation),
        )  # fmt: skip
        kernel = stages.muscle_torques(kind, self.structure.controller)
        extension = self._extensions.struct.first
        result = self._run(kernel, [extension, torques, recorder.record], [((b,), wp.vec3)])[0]
        quantities = recorder.record.muscle.numpy()[:, 0, :, : len(actuation.muscles)]
        return result[:, 1:], {name: quantities[:, k] for k, name in enumerate(MUSCLE_QUANTITIES)}

    def forward_dynamics(self, joint_torque: ArrayLike = 0.0) -> dict[str, Floats]:
        """Accelerations under joint torques (n, J, 3), world, + on the parent.

        Returns:
            speed_rate (n, S); of all bodies acceleration of the centre of mass and angular_acceleration (n, B, 3).
        """
        n, b = self.instances, len(self.names.bodies)
        torque = np.zeros((n, b, 3), dtype=np.float32)
        torque[:, 1:] = self._rows(joint_torque, "joint_torque", b - 1, 3)
        torques = wp.array(torque, dtype=wp.vec3, device=self.device)
        outputs = [((self.names.speeds,), float), ((b,), wp.vec3), ((b,), wp.vec3)]
        skeleton = self.structure.skeleton
        kernel = stages.forward_dynamics_of(skeleton.followed, skeleton.constraints, skeleton.entries, skeleton.single)
        results = self._run(kernel, [torques], outputs)
        return dict(zip(("speed_rate", "acceleration", "angular_acceleration"), results, strict=True))

    def mass_matrix(self) -> Floats:
        """Joint-space inertia (n, S, S)."""
        return self._run(stages.mass_matrix, [], [((self.names.speeds, self.names.speeds), float)])[0]

    @property
    def structs(self) -> tuple[structs.Model, structs.State]:
        """Model and state as Warp structures, for other kernels."""
        return self.model, self.state
