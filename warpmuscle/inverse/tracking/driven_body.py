"""Bodies of a model that are simulated under excitations, recorded loads and told forces, many at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.status import Status
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.tracking.timed_forces import without_timed
from warpmuscle.kernels.force.loads import JointLoad, Load, PointLoad
from warpmuscle.scene import Force
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.objective import never_failing
from warpmuscle.simulation.rollout import Rollout

ROOT, PLATE, JOINT = "told root", "told load", "told effort"  # names of forces; the model's own have others
AXES = ("x", "y", "z")


class DrivenBody:
    """A rollout of n instances of a model, window by window.

    Attributes:
        rollout: the simulation. window_steps: steps of a window. window: s, how long they take.
        muscle_names: simulated muscles. muscles: their numbers among all of the model.
    """

    def __init__(
        self, body: BodyModel, instances: int, window: float, loads: Sequence[int], duration: float, *,
        recorded: bool = False,
    ) -> None:  # fmt: skip
        """Prepare.

        Args:
            window: s, rounded to whole steps. loads: (L,) numbers of the bodies that loads act on.
            duration: s, longest simulated time. recorded: whether all instances are, 100 times a second.
        """
        self.body, self._loaded = body, list(loads)
        scene = body.scene
        self.window_steps = max(round(window / scene.time_step), 1)
        self.window = self.window_steps * scene.time_step
        self._names = body.topology
        self._joints = [name for name in self._names.joints if joint_type(scene.character.joints[name]).moves]
        self._first = [self._names.speeds_of(self._names.body_of_joint(name)) for name in self._joints]
        self._rows = instances
        forces = without_timed(scene.forces) | self._forces()
        self._scene = msgspec.structs.replace(
            scene, forces=forces, failure=never_failing(scene.failure), duration=duration + self.window,
            controller=None, motion={},
        )  # fmt: skip
        record = range(instances) if recorded else ()
        self.rollout = Rollout(self._scene, instances, str(body.device), record=record)
        self.muscle_names = self.rollout.structure.actuation.muscles
        self.muscles = [body.muscles.index(name) for name in self.muscle_names]

    def _forces(self) -> dict[str, Force]:
        """Forces that are told, all of nothing."""
        bodies = self._names.bodies
        found = {}
        if self.body.map.roots:
            found[ROOT] = Force("load", body=bodies[0], parameters=nothing(Load))
        for k, number in enumerate(self._loaded):
            found[f"{PLATE} {k}"] = Force("point_load", body=bodies[number], parameters=nothing(PointLoad))
        for name in self._joints:
            found[f"{JOINT} {name}"] = Force("joint_load", joint=name, parameters=nothing(JointLoad))
        return found

    def start(self, states: States, activation: Floats) -> None:
        """Put all instances to states (n, ...) and activations (n, M)."""
        self.rollout.set_initial(states.coordinates, states.speeds, activation)

    def tell(self, effort: Floats, loads: BodyLoads | None = None, later: BodyLoads | None = None) -> None:
        """Say what acts over the next window.

        Args:
            effort: (n, S) N and N m along speeds. loads, later: at the window's start and end.
        """
        applied = dict(self._scene.forces)
        if ROOT in applied:
            root = root_type(self.body.scene.character)
            parts = nothing(Load) | {
                f"force_{AXES[axis]}": effort[:, k].copy() for k, axis in enumerate(root.moving)
            } | {
                f"moment_{AXES[axis]}": effort[:, len(root.moving) + k].copy() for k, axis in enumerate(root.turning)
            }  # fmt: skip
            applied[ROOT] = msgspec.structs.replace(applied[ROOT], parameters=parts)
        for name, speeds in zip(self._joints, self._first, strict=True):
            parts = nothing(JointLoad) | {
                f"effort_{k}": effort[:, speed].copy() for k, speed in enumerate(range(speeds.start, speeds.stop))
            }
            applied[f"{JOINT} {name}"] = msgspec.structs.replace(applied[f"{JOINT} {name}"], parameters=parts)
        if loads is not None and later is not None:
            applied |= self._plates(loads, later)
        self._scene = msgspec.structs.replace(self._scene, forces=applied)
        self.rollout.change_forces(self._scene)

    def _plates(self, loads: BodyLoads, later: BodyLoads) -> dict[str, Force]:
        """Loads that change evenly over the next window."""
        since = self.rollout.steps_done * self.body.scene.time_step
        found = {}
        for k, number in enumerate(self._loaded):
            parts: dict[str, Any] = {"since": since}
            for word in ("force", "point", "moment"):
                now, then = getattr(loads, word)[:, k], getattr(later, word)[:, k]
                for a, axis in enumerate(AXES):
                    parts[f"{word}_{axis}"] = now[:, a].copy()
                    parts[f"{word}_rate_{axis}"] = (then[:, a] - now[:, a]) / self.window
            found[f"{PLATE} {k}"] = Force("point_load", body=self._names.bodies[number], parameters=parts)
        return found

    def run(self, excitation: Floats) -> None:
        """Simulate a window under excitations (n, M), in the order of the model's muscles."""
        self.rollout.step(self.window_steps, excitations=np.ascontiguousarray(excitation, np.float32))

    def state(self) -> tuple[Floats, Floats]:
        """Coordinates (n, C) and speeds (n, S) of the state."""
        state = self.rollout.state
        return state.coordinates.numpy().astype(np.float64), state.speeds.numpy().astype(np.float64)

    def runs(self) -> NDArray[np.bool_]:
        """Which instances (n,) have not diverged."""
        return np.asarray(self.rollout.status() == Status.RUNNING) & np.isfinite(self.state()[0]).all(axis=1)

    def force(self) -> Floats:
        """Forces (n, M) of all muscles in the last step, N."""
        return self.of_muscles(self.rollout.state.muscles.force)

    def activation(self) -> Floats:
        """Activations (n, M)."""
        return self.of_muscles(self.rollout.state.muscles.activation)

    def of_muscles(self, array: Any) -> Floats:
        """Numbers of the simulated muscles on the device as those of all (n, M)."""
        found = np.zeros((self._rows, len(self.body.muscles)))
        found[:, self.muscles] = array.numpy()[:, : len(self.muscles)]
        return found


def nothing(parameters: Any) -> dict[str, Any]:
    """Values of a structure of parameters with which a force does nothing."""
    return dict.fromkeys(parameters.vars, 0.0)
