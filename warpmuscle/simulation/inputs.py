"""What instances of a batch are given beside parameters: excitations, motions, disturbances, and where they start."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array, as_kind, as_truth
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import arrays_of, structs_to_device, to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels import structs
from warpmuscle.model.build import NO_INPUTS, ModelInputs, update_model
from warpmuscle.model.muscles import ActuationMap
from warpmuscle.model.prescribed_motion import (
    Kinematic,
    Moved,
    check_knots,
    coordinate_numbers,
    given_curves,
    moved,
    speed_numbers,
)
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import Topology
from warpmuscle.simulation.extensions import Extensions
from warpmuscle.simulation.perturbations import Disturbances


@dataclass
class Inputs:
    """What a batch has been given in place of what its scene says; None where the scene counts."""

    of_model: ModelInputs = NO_INPUTS
    coordinates: Floats | None = None  # (1 or instances, coordinates)
    speeds: Floats | None = None  # (1 or instances, speeds)
    activation: Floats | None = None  # (1 or instances, simulated muscles)


def excitation_arrays(
    time: ArrayLike, values: ArrayLike, muscles: int, chosen: list[int], instances: int, device: Any
) -> dict[str, wp.array]:
    """Excitations over time, straight between knots, by field of `kernels.structs.Muscles`.

    Args:
        time: (K,) s. values: (1 or instances, muscles, K). chosen: numbers of the muscles that are simulated.

    Raises:
        RolloutError: wrong shapes, numbers that are not finite, or times that do not increase.
    """
    t = as_array(time, "time", error=RolloutError).astype(np.float64)
    v = as_array(values, "values", error=RolloutError)
    if t.ndim != 1 or not len(t) or v.shape not in ((1, muscles, len(t)), (instances, muscles, len(t))):
        raise RolloutError(
            f"excitations of {muscles} muscles take times (K,) and values (1 or {instances}, {muscles}, K), "
            f"not {t.shape} and {v.shape}"
        )
    check_knots(t, v, "excitations")
    own = np.clip(v if chosen == list(range(muscles)) else v[:, chosen], 0.0, 1.0)
    count = len(chosen)
    first = np.arange(count)[None] * len(t)
    return {
        "own": structs_to_device(structs.OwnExcitation, {"first_knot": first, "end_knot": first + len(t)}, device),
        "knot_time": to_device(np.tile(t, count)[None], float, device),
        "knot_value": to_device(own.reshape(len(v), -1), float, device),
    }


def checked_state(values: ArrayLike, count: int, instances: int, what: str) -> Floats:
    """Values to start from, (1 or instances, count).

    Raises:
        RolloutError: another shape, or a number that is not finite.
    """
    array = as_array(values, what, error=RolloutError).astype(np.float64)
    if array.shape not in ((1, count), (instances, count)):
        raise RolloutError(f"{what} have shape {array.shape}; this rollout takes (1 or {instances}, {count})")
    if not np.isfinite(array).all():
        raise RolloutError(f"a number of the {what} is not finite")
    return array


@dataclass(frozen=True)
class Snapshot:
    """Where all instances of a batch stand."""

    arrays: list[wp.array]
    steps_done: int
    begun: Integers
    running: Integers


class Given(ABC):
    """A batch that can be given more than parameters."""

    scene: Scene
    names: Topology
    structure: Structure
    instances: int
    steps: int
    steps_done: int
    device: Any
    _driven: ActuationMap
    _kinematic: Kinematic
    _inputs: Inputs
    _disturbances: Disturbances
    _numeric: Scene
    _moved: Moved
    _model: structs.Model
    _state: structs.State
    _extensions: Extensions
    _begun: Integers  # (instances,) what `steps_done` was when an instance was last put back to its start
    _running: Integers

    @abstractmethod
    def reset(self, velocity_noise: Any = 0.0, seed: int = 0, mask: Any = None) -> None:
        """Put instances back to their start."""

    def _put_moved(self, coordinates: Any, speeds: Any) -> Any:
        """Put the kinematic coordinates and their speeds to where their motion starts; all accelerations there."""
        motion = self._inputs.of_model.motion
        start, row = self._moved, None if motion is None else motion.row
        chosen = slice(None) if row is None else row
        numbers = speed_numbers(self._kinematic)
        accelerations = np.zeros(speeds.shape, dtype=np.float32)
        coordinates[:, coordinate_numbers(self._kinematic)] = start.coordinates[chosen]
        speeds[:, numbers] = start.speeds[chosen]
        accelerations[:, numbers] = start.accelerations[chosen]
        return accelerations

    @property
    def muscle_names(self) -> tuple[str, ...]:
        """Muscles in the order of `set_excitations`: all of the scene."""
        return tuple(self.scene.character.muscles)

    @property
    def motion_names(self) -> tuple[str, ...]:
        """Kinematic coordinates in the order of `set_motion`, a part of `coordinate_names`; see `prescribed_motion`."""
        return self._kinematic.names

    def set_excitations(self, time: ArrayLike, values: ArrayLike, *, restart: bool = True) -> None:
        """Excite all muscles over time in place of a controller and of the scene's excitations, and start again.

        It stays so, also with other parameters. Values beyond 0..1 count as 0 or 1.

        Args:
            time: (K,) s, increasing; excitations are straight between these knots and constant beyond them.
            values: (1 or instances, muscles, K), muscles as in `muscle_names`.
            restart: False to go on from where the batch stands.

        Raises:
            RolloutError: wrong shapes, numbers that are not finite, or times that do not increase.
        """
        as_truth(restart, "restart", error=RolloutError)
        every = self.muscle_names
        chosen = [every.index(name) for name in self._driven.muscles]
        arrays = excitation_arrays(time, values, len(every), chosen, self.instances, self.device)
        self._take("excitations", excitations=arrays)
        if restart:
            self.reset()

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None = None) -> None:
        """Let the kinematic coordinates move in place of what the scene says, and start again. It stays so.

        Args:
            time: (K,) s, increasing, over the whole simulated time; between knots motions are splines of fifth degree.
            values: (1 or instances, coordinates, K), rad and m, coordinates as in `motion_names`; quaternions of any
                length but zero.
            of: (instances,) number of the row of `values`, which then may have any number of them, that an instance
                follows.

        Raises:
            RolloutError: no kinematic coordinates, wrong shapes, numbers that are not finite, times that do not
                increase or do not reach over the simulated time.
        """
        end = self.steps * self.scene.time_step
        curves = given_curves(self._kinematic, time, values, of, self.instances, end)
        self._moved = moved(self._kinematic, curves, 0.0)
        self._take("motion", motion=curves)
        self.reset()

    def set_initial(
        self,
        coordinates: ArrayLike | None = None,
        speeds: ArrayLike | None = None,
        activation: ArrayLike | None = None,
    ) -> None:
        """Start from other states than the scene's, where given, and start again. It stays so.

        Kinematic coordinates start where their motion does, whatever is given here.

        Args:
            coordinates: (1 or instances, coordinates) rad, m, and quaternions of unit length, as in `coordinate_names`.
            speeds: (1 or instances, speeds) rad/s and m/s, as in `speed_names`.
            activation: (1 or instances, muscles), as in `muscle_names`.

        Raises:
            RolloutError: wrong shapes, or numbers that are not finite.
        """
        every = self.muscle_names
        wanted = (coordinates, self.names.coordinates), (speeds, self.names.speeds), (activation, len(every))
        found = [
            None if values is None else checked_state(values, count, self.instances, f"initial {name}")
            for name, (values, count) in zip(("coordinates", "speeds", "activations"), wanted, strict=True)
        ]
        given = self._inputs
        if found[0] is not None:
            given.coordinates = found[0]
        if found[1] is not None:
            given.speeds = found[1]
        if found[2] is not None:
            chosen = [every.index(name) for name in self._driven.muscles]
            given.activation = found[2][:, chosen] if chosen else None
        self.reset()

    def disturb(self, disturbances: Disturbances) -> None:
        """Push instances, start them at other velocities, or tilt their ground, from now on; and start again.

        Raises:
            RolloutError: another number of instances.
        """
        as_kind(Disturbances, disturbances, "disturbances", error=RolloutError)
        if len(disturbances) != self.instances:
            raise RolloutError(f"{len(disturbances)} disturbances for {self.instances} instances")
        self._disturbances = d = disturbances
        h, s = self.scene.time_step, self._state
        first = np.rint(d.push_start / h).astype(np.int32)
        steps = max(round(d.push_duration / h), 1)
        s.push.assign((d.push / (steps * h)).astype(np.float32))
        s.push_steps.assign(np.stack([first, first + steps], axis=1).astype(np.int32))
        self._take("slope", slope=d.slope)
        self.reset()

    def _take(self, part: str, **values: Any) -> None:
        """Take some inputs of the model from now on, which one of its parts shows."""
        self._inputs.of_model = replace(self._inputs.of_model, **values)
        update_model(self._model, [part], self._numeric, self.structure, self.device, self._inputs.of_model)

    def _changing(self) -> list[wp.array]:
        """All arrays that steps change."""
        return [*arrays_of(self._state), *self._extensions.memories]

    def snapshot(self) -> Snapshot:
        """Where all instances stand now, for `restore`."""
        arrays = [wp.clone(array) for array in self._changing()]
        return Snapshot(arrays, self.steps_done, self._begun.copy(), self._running.copy())

    def restore(self, snapshot: Snapshot) -> None:
        """Put all instances back to where they stood; what they have been given stays as it is now."""
        as_kind(Snapshot, snapshot, "snapshot", error=RolloutError)
        for array, kept in zip(self._changing(), snapshot.arrays, strict=True):
            wp.copy(array, kept)
        self.steps_done, self._begun = snapshot.steps_done, snapshot.begun.copy()
        self._running = snapshot.running.copy()
