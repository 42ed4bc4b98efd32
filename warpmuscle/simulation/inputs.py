"""What a batch is told beside parameters: excitations, motions, perturbations, and where its instances start."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array, as_kind
from warpmuscle.core.array_interop import rows_of
from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.kernels import structs
from warpmuscle.model.build import Fields, ModelInputs, Start, motion_of, start_of
from warpmuscle.model.prescribed_motion import (
    Moved,
    check_knots,
    coordinate_numbers,
    given_curves,
    moved,
    speed_numbers,
)
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.simulation.batch_input import in_silence
from warpmuscle.simulation.batch_state import InitialValues
from warpmuscle.simulation.perturbations import Perturbations, none


class Inputs:
    """What n instances of a scene are told beside parameters, checked; what they are not told stays with the scene.

    Attributes:
        of_model: what of it the model shows. disturbances: of all instances.
        start: where the scene lets them start, as of the last `use`.
    """

    start: Start

    def __init__(self, scene: Scene, structure: Structure, instances: int, device: Any) -> None:
        """Nothing is told yet; `use` must come before `initial_values`."""
        self._scene, self._structure, self._instances, self._device = scene, structure, instances, device
        self.of_model = ModelInputs()
        self.disturbances = none(instances)
        self._start: dict[str, Floats] = {}  # coordinates, speeds and activation to start from, (1 or n, ...)
        self._prescribed: Moved | None = None  # where the prescribed motion starts
        self._initial: InitialValues | None = None  # without noise, until something changes

    @property
    def muscle_names(self) -> tuple[str, ...]:
        """Muscles in the order of excitations: all of the scene."""
        return tuple(self._scene.character.muscles)

    @property
    def torque_names(self) -> tuple[str, ...]:
        """Speeds of the joints, in the order of torques."""
        return tuple(name for name in self._structure.speed_names if not name.startswith("root."))

    @cached_property
    def _simulated(self) -> list[int]:
        """Numbers of the simulated muscles among all."""
        every = self.muscle_names
        return [every.index(name) for name in self._structure.actuation.muscles]

    def use(self, numeric: Scene) -> None:
        """Take start and motion, where nothing else was told, from a scene of numbers (see `parameters.substitute`)."""
        self.start, self._initial = start_of(numeric, self._structure.names), None
        if self._structure.kinematic.names:
            self._prescribed = moved(self._structure.kinematic, motion_of(numeric, self._structure, self.of_model), 0.0)

    def set_excitations(self, time: ArrayLike, values: ArrayLike) -> None:
        """Take excitations over time; see `Batch.set_excitations`."""
        arrays = excitation_arrays(time, values, len(self.muscle_names), self._simulated, self._instances, self._device)
        self.of_model = replace(self.of_model, excitations=arrays)

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None, end: float) -> None:
        """Take a motion of the kinematic coordinates until the `end`, s; see `Batch.set_motion`."""
        curves = given_curves(self._structure.kinematic, time, values, of, self._instances, end)
        self._prescribed, self._initial = moved(self._structure.kinematic, curves, 0.0), None
        self.of_model = replace(self.of_model, motion=curves)

    def set_initial(
        self, coordinates: ArrayLike | None, speeds: ArrayLike | None, activation: ArrayLike | None
    ) -> None:
        """Take a state to start from; see `Batch.set_initial`."""
        names = self._structure.names
        sizes = {"coordinates": names.coordinates, "speeds": names.speeds, "activations": len(self.muscle_names)}
        checked = {
            name: self._state(values, sizes[name], f"initial {name}")
            for name, values in zip(sizes, (coordinates, speeds, activation), strict=True)
            if values is not None
        }
        if "activations" in checked:
            values = checked.pop("activations")
            self._start.pop("activation", None)
            if self._simulated:
                self._start["activation"] = values[:, self._simulated]
        self._start |= checked
        self._initial = None

    def _state(self, values: ArrayLike, count: int, what: str) -> Floats:
        """Values to start from, (1 or n, count), finite."""
        array = as_array(values, what, error=RolloutError).astype(np.float64)
        if array.shape not in ((1, count), (self._instances, count)):
            raise RolloutError(f"{what} have shape {array.shape}; this rollout takes (1 or {self._instances}, {count})")
        if not np.isfinite(array).all():
            raise RolloutError(f"a number of the {what} is not finite")
        return array

    def set_disturbances(self, disturbances: Perturbations) -> None:
        """Take disturbances; RolloutError if they are those of another number of instances."""
        self.disturbances = checked_disturbances(disturbances, self._instances)
        character = self._scene.character
        for name, count in (("mass", len(character.bodies)), ("strength", len(character.muscles))):
            factors = getattr(disturbances, name)
            if factors is not None and factors.shape != (self._instances, count):
                raise RolloutError(
                    f"factors of {name} have shape {factors.shape}; this rollout takes ({self._instances}, {count})"
                )
        self.of_model, self._initial = replace(self.of_model, slope=disturbances.slope), None

    def initial_values(self, root_velocity: Floats) -> InitialValues:
        """What all instances start from; the same object until something changes, unless there is noise.

        Args:
            root_velocity: (1 or n, 3 or less) m/s, noise that is added to the root's linear speeds.
        """
        if root_velocity.any():
            return self._initial_values(root_velocity)
        if self._initial is None:
            self._initial = self._initial_values(root_velocity)
        return self._initial

    @in_silence
    def _initial_values(self, root_velocity: Floats) -> InitialValues:
        n, names, start = self._instances, self._structure.names, self.start
        coordinates = self._start.get("coordinates", start.coordinates)
        speeds = self._start.get("speeds", start.speeds)
        every = start.activation if start.activation.shape[1] == 1 else start.activation[:, self._simulated]
        activation = self._start.get("activation", every)
        coordinates = np.broadcast_to(coordinates, (n, names.coordinates)).astype(np.float32)
        speeds = np.broadcast_to(speeds, (n, names.speeds)).astype(np.float32)
        accelerations = np.zeros((1, names.speeds), dtype=np.float32)
        linear = len(root_type(self._scene.character).moving)
        speeds[:, :linear] += root_velocity
        speeds[:, :linear] += self.disturbances.velocity[:, 3 - linear :]
        if self._prescribed is not None:
            accelerations = self._put_prescribed(self._prescribed, coordinates, speeds)
        return InitialValues(coordinates, speeds, accelerations, activation.astype(np.float32), start.controller)

    def _put_prescribed(self, start: Moved, coordinates: Floats, speeds: Floats) -> Floats:
        """Put the kinematic coordinates and their speeds to where their motion starts; all accelerations there."""
        kinematic, motion = self._structure.kinematic, self.of_model.motion
        row = slice(None) if motion is None or motion.row is None else motion.row
        numbers = speed_numbers(kinematic)
        accelerations = np.zeros(speeds.shape, dtype=np.float32)
        coordinates[:, coordinate_numbers(kinematic)] = start.coordinates[row]
        speeds[:, numbers] = start.speeds[row]
        accelerations[:, numbers] = start.accelerations[row]
        return accelerations

    def from_outside(self, excitations: Any, torques: Any) -> Fields:
        """What the model has while steps are driven from outside; see `Batch.step`."""
        fields: Fields = {}
        if excitations is not None:
            if not self._simulated:
                raise RolloutError("there are no muscles to excite: they drive no joint of this scene")
            count = len(self.muscle_names)
            # On a GPU nobody looks at them here: an instance with what is no number diverges, see `causes.py`.
            values = rows_of(excitations, count, self._instances, self._device, "excitations", numbers=True)
            fields |= self._one_knot | {"muscles.knot_value": values}
        if torques is not None:
            count = len(self.torque_names)
            fields["actuation.effort"] = rows_of(torques, count, self._instances, self._device, "torques")
        return fields

    @cached_property
    def _one_knot(self) -> Fields:
        """Excitations of one knot a muscle, which stands in the muscle's column of what comes from outside."""
        first = np.array([self._simulated])
        spans = structs_to_device(structs.TimedExcitation, {"first_knot": first, "end_knot": first + 1}, self._device)
        time = wp.zeros((1, len(self.muscle_names)), dtype=float, device=self._device)
        return {"muscles.timed": spans, "muscles.knot_time": time}


def checked_disturbances(disturbances: Perturbations, instances: int) -> Perturbations:
    """Disturbances of so many instances; RolloutError if they are no such."""
    as_kind(Perturbations, disturbances, "disturbances", error=RolloutError)
    if len(disturbances) != instances:
        raise RolloutError(f"{number_of(len(disturbances), 'disturbance')} for {number_of(instances, 'instance')}")
    return disturbances


def excitation_arrays(
    time: ArrayLike, values: ArrayLike, muscles: int, simulated: list[int], instances: int, device: Any
) -> dict[str, wp.array]:
    """Excitations over time, straight between knots, by field of `kernels.structs.Muscles`.

    Args:
        time: (K,) s. values: (1 or instances, muscles, K). simulated: numbers of the muscles that are simulated.

    Raises:
        RolloutError: wrong shapes, numbers that are not finite, or times that do not increase.
    """
    t = as_array(time, "time", error=RolloutError).astype(np.float64)
    v = as_array(values, "values", error=RolloutError)
    if t.ndim != 1 or not len(t) or v.shape not in ((1, muscles, len(t)), (instances, muscles, len(t))):
        raise RolloutError(
            f"excitations of {number_of(muscles, 'muscle')} take times (K,) and values (1 or {instances}, "
            f"{muscles}, K), "
            f"not {t.shape} and {v.shape}"
        )
    check_knots(t, v, "excitations")
    of_simulated = np.clip(v if simulated == list(range(muscles)) else v[:, simulated], 0.0, 1.0)
    count = len(simulated)
    first = np.arange(count)[None] * len(t)
    return {
        "timed": structs_to_device(structs.TimedExcitation, {"first_knot": first, "end_knot": first + len(t)}, device),
        "knot_time": to_device(np.tile(t, count)[None], float, device),
        "knot_value": to_device(of_simulated.reshape(len(v), -1), float, device),
    }
