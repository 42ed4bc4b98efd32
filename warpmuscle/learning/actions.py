"""What the actions of a policy do: excitations, synergies, targets or torques of joints."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.kernels import structs
from warpmuscle.kernels.control.control import given_effort
from warpmuscle.kernels.learning import policy_actions
from warpmuscle.learning.symmetry import BodySymmetry, Image, action_image
from warpmuscle.model.build import Fields, start_of
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.learning import Task
from warpmuscle.scene.masses import muscle_masses
from warpmuscle.scene.validation.checks import near
from warpmuscle.simulation.fused_kernel import KernelConfig
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import excited, moved, sensing

OFFSET = {"excitation": 0.1, "synergies": 0.1}
SCALE = {"excitation": 0.4, "synergies": 0.4, "joint_targets": 0.5, "torques": 100.0}
HUGE_ACTION = 1e6  # which counts as nothing, see `policy_actions.finite`
BY_MUSCLES = ("excitation", "synergies")


class Actions:
    """Actions of a batch.

    Attributes:
        names: of the numbers. requested: (instances, actions), where a policy puts them. action, previous: what counts.
        excitation: (instances, muscles) that they make, or of no columns. fields: what the model has for them.
        limit: N m, of torques.
    """

    def __init__(self, task: Task, rollout: Rollout) -> None:
        """Make room; raises SceneError for actions that the scene has nothing for."""
        self.kind, self._device, n = task.actions, rollout.device, rollout.instances
        self._scene = rollout.numeric
        self._offset = OFFSET.get(task.actions, 0.0) if task.action_offset is None else task.action_offset
        self._scale = SCALE[task.actions] if task.action_scale is None else task.action_scale
        self._middle = wp.zeros(0, dtype=float, device=self._device)
        muscles = rollout.structure.actuation.muscles
        self.fields: Fields = {}
        self.excitation = wp.zeros(
            (n, len(muscles) if task.actions in BY_MUSCLES else 0), dtype=float, device=self._device
        )
        if task.actions in BY_MUSCLES:
            if not muscles:
                raise SceneError("muscles drive no joint of this scene; see `joint_targets`", key="learning.actions")
            self.names = tuple(muscles)
            if task.actions == "synergies":
                self.names = tuple(task.synergies)
                self._weights = to_device(synergy_weights(task, muscles), float, self._device)
            self.fields = self._excitations(len(muscles))
        else:
            self.names = rollout.torque_names
            if not self.names:
                raise SceneError("there are no joints to move in this scene", key="learning.actions")
            self.fields = self._efforts(task, rollout)
        shape = (n, len(self.names))
        empty = [wp.zeros(shape, dtype=float, device=self._device) for _ in range(3)]
        self.requested, self.action, self.previous = empty

    @property
    def change(self) -> Callable[[KernelConfig], KernelConfig]:
        """The configuration of a kernel that takes them, from the usual one, which says what it records."""
        kind = self.kind

        def changed(config: KernelConfig) -> KernelConfig:
            config = sensing(config)
            if kind in BY_MUSCLES:
                return excited(config)
            return moved(config, given_effort if kind == "torques" else policy_actions.target_effort)

        return changed

    @property
    def range(self) -> tuple[float, float] | None:
        """Actions beyond which the nearer of these two does the same; None if there are none."""
        if self.kind not in BY_MUSCLES or not self._scale:
            return None
        none, full = -self._offset / self._scale, (1.0 - self._offset) / self._scale
        if self.kind == "synergies":  # several of which excite a muscle
            full = math.copysign(HUGE_ACTION, self._scale)
        low, high = np.clip([min(none, full), max(none, full)], -HUGE_ACTION, HUGE_ACTION).tolist()
        return (low, high) if low < high else None

    @property
    def muscle_shares(self) -> Floats | None:
        """(actions,) share of each muscle's mass in that of all; None unless actions excite muscles by themselves."""
        if self.kind != "excitation" or not self._scale > 0.0:
            return None
        scene = self._scene
        muscles = [scene.character.muscles[name] for name in self.names]
        mass = muscle_masses(muscles, scene.muscle_model)
        return np.array(mass) / max(sum(mass), 1e-9)

    @property
    def changing(self) -> list[wp.array]:
        """Arrays that decisions change and that later ones depend on."""
        return [self.action, self.previous]

    def image(self, body: BodySymmetry) -> Image:
        """Which actions move the body's mirror image so; raises SceneError where none do."""
        middle = self._middle.numpy() if len(self._middle) else np.zeros(len(self.names))
        return action_image(self.kind, self.names, middle, self._scale, body)

    def take(self) -> None:
        """Let what was requested count from now on."""
        inputs = [self.requested, self.action, self.previous]
        wp.launch(policy_actions.take_actions, self.action.shape, inputs, device=self._device)
        if self.kind == "excitation":
            inputs = [self.action, self._offset, self._scale, self.excitation]
            wp.launch(policy_actions.excite, self.excitation.shape, inputs, device=self._device)
        elif self.kind == "synergies":
            inputs = [self.action, self._offset, self._scale, self._weights, self.excitation]
            wp.launch(policy_actions.excite_synergies, self.excitation.shape, inputs, device=self._device)
        else:
            inputs = [self.action, self._middle, self._scale, self._effort]
            wp.launch(policy_actions.aim, self.action.shape, inputs, device=self._device)

    def _excitations(self, muscles: int) -> Fields:
        """Excitations of one knot a muscle."""
        first = np.arange(muscles)[None]
        spans = structs_to_device(structs.TimedExcitation, {"first_knot": first, "end_knot": first + 1}, self._device)
        time = wp.zeros((1, muscles), dtype=float, device=self._device)
        return {"muscles.timed": spans, "muscles.knot_time": time, "muscles.knot_value": self.excitation}

    def _efforts(self, task: Task, rollout: Rollout) -> Fields:
        """Torques, or targets with the gains of PD behind them, see `policy_actions.target_effort`."""
        count, targets = len(rollout.torque_names), task.actions == "joint_targets"
        middle = np.full(count, self._offset)
        table = np.zeros((rollout.instances, 3 * count if targets else count), dtype=np.float32)
        if targets:
            middle += start_angles(rollout)
            table[:, count:] = np.concatenate(gains(task, rollout))
        self._middle, self._effort = to_device(middle, float, self._device), to_device(table, float, self._device)
        return {"actuation.effort": self._effort}


def synergy_weights(task: Task, muscles: tuple[str, ...]) -> Any:
    """Weights (synergies, muscles); SceneError for an unknown muscle, or none at all."""
    if not task.synergies:
        raise SceneError("actions by synergies need some", key="learning.synergies")
    weights = np.zeros((len(task.synergies), len(muscles)))
    for row, (name, parts) in enumerate(task.synergies.items()):
        for muscle, weight in parts.items():
            if muscle not in muscles:
                raise SceneError(
                    f"there is no simulated muscle {muscle!r}{near(muscle, muscles)}",
                    key=f"learning.synergies.{name}.{muscle}",
                )
            weights[row, muscles.index(muscle)] = weight
    return weights


def start_angles(rollout: Rollout) -> Any:
    """Where every speed of a joint has its coordinate at the start; of ball joints the rotation vector, rad."""
    names, angles = rollout.names, []
    start = start_of(rollout.numeric, names).coordinates[0]
    for body in range(1, len(names.bodies)):
        entry = joint_type(rollout.scene.character.joints[names.joints[body - 1]])
        values = start[names.joint_coordinates(body)]
        if len(entry.coordinates) != len(entry.speeds):  # a quaternion
            from scipy.spatial.transform import Rotation  # takes a quarter of a second

            values = Rotation.from_quat(values).as_rotvec()
        angles += list(values)
    return np.array(angles)


def gains(task: Task, rollout: Rollout) -> tuple[Any, Any]:
    """Stiffness, N m/rad, and damping, N m s/rad, of every speed of a joint: the controller's, or the task's."""
    controller = rollout.numeric.controller
    stiffness, damping = [], []
    for name in rollout.names.joints:
        joint = rollout.scene.character.joints[name]
        count = len(joint_type(joint).speeds)
        pd = None if controller is None else controller.pd.get(name)
        scale = np.ones(3) if pd is None else first_row(pd.scale)
        kp, kd = (task.stiffness, task.damping) if pd is None else (first_number(pd.kp), first_number(pd.kd))
        if count < 3:  # along the joint's axes
            scale = np.square(first_row(list(joint.axes))[:count]) @ scale if joint.axes else scale[:count]
        stiffness += list(kp * scale)
        damping += list(kd * scale)
    return np.array(stiffness), np.array(damping)
