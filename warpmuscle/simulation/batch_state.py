"""Where the instances of a batch stand: their state on the device, how far they have come, and which still run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import arrays_of, named_arrays
from warpmuscle.core.status import Status
from warpmuscle.kernels import structs
from warpmuscle.kernels.memory.restart import put_rows
from warpmuscle.simulation.extensions import Extensions, words
from warpmuscle.simulation.perturbations import Perturbations

KEPT = ("push", "push_steps")  # of the state, that no restart changes


@dataclass(frozen=True)
class InitialValues:
    """What instances start from, n of them, float32; all else of their state starts at zero."""

    coordinates: Floats  # (n, coordinates)
    speeds: Floats  # (n, speeds)
    accelerations: Floats  # (1 or n, speeds)
    activation: Floats  # (1 or n, 1 or muscles)
    controller: Mapping[str, int]  # by place in the state, such as `simbicon.stance`


@dataclass(frozen=True)
class Snapshot:
    """Where all instances of a batch stand."""

    arrays: list[wp.array]
    steps_done: int
    begun: Integers
    running: Integers


class BatchState:
    """The state of n instances, and how far they have come.

    Attributes:
        state, extensions: on the device. steps: of a whole simulation.
        steps_done: since all of them last started. begun: (n,) what that was when an instance last started.
        running: numbers of those that still run.
    """

    def __init__(self, state: structs.State, extensions: Extensions, steps: int) -> None:
        """Take over states whose arrays are all zero."""
        self.state, self.extensions, self.steps = state, extensions, steps
        self.instances, self._device = len(state.step), state.step.device
        self.steps_done = 0
        self.begun: Integers = np.zeros(self.instances, dtype=np.int32)
        self.running: Integers = np.arange(self.instances, dtype=np.int32)
        self._rows: tuple[InitialValues | None, dict[str, wp.array]] = None, {}  # kept for the next restart from there

    def restart(self, initial: InitialValues) -> None:
        """Put every instance back to its start."""
        s, muscles = self.state, self.state.muscles
        for _, array in self._changed_by_restart():
            array.zero_()
        if initial.accelerations.any():
            s.accelerations.assign(np.broadcast_to(initial.accelerations, s.accelerations.shape))
        s.coordinates.assign(initial.coordinates)
        s.speeds.assign(initial.speeds)
        for place, number in initial.controller.items():
            attrgetter(place)(s).fill_(number)
        if initial.activation.size == 1:
            muscles.activation.fill_(float(initial.activation[0, 0]))
        else:
            muscles.activation.assign(np.broadcast_to(initial.activation, muscles.activation.shape))
        muscles.neural.assign(muscles.activation)
        self.extensions.restart()
        self.steps_done = 0
        self.begun = np.zeros(self.instances, dtype=np.int32)
        self.running = np.arange(self.instances, dtype=np.int32)

    def restart_some(self, mask: NDArray[np.bool_], initial: InitialValues) -> None:
        """Put the instances of a mask, (n,), back to their start; the others stay as they are."""
        if not mask.any():
            return
        chosen = wp.array(np.flatnonzero(mask).astype(np.int32), dtype=int, device=self._device)
        if self._rows[0] is not initial:
            self._rows = initial, self._rows_of(initial)
        rows = self._rows[1]
        for name, target in self._targets():
            dim = (len(chosen), *target.shape[1:])
            wp.launch(put_rows, dim, [chosen, rows.get(name, rows[""]), target], device=self._device)
        self.extensions.restart(chosen)
        self.begun[mask] = self.steps_done
        self.running = np.flatnonzero(np.isin(np.arange(self.instances), self.running) | mask).astype(np.int32)

    def _rows_of(self, initial: InitialValues) -> dict[str, wp.array]:
        """What the arrays of the state have at the start, in rows of words; under no name zeros for all others."""
        width = self.state.muscles.activation.shape[1]
        activation = np.broadcast_to(initial.activation, (len(initial.activation), width))
        floats = {
            "coordinates": initial.coordinates, "speeds": initial.speeds, "accelerations": initial.accelerations,
            "activation": activation, "neural": activation,
        }  # fmt: skip
        numbers = {place.rpartition(".")[2]: number for place, number in initial.controller.items()}
        rows = {name: np.ascontiguousarray(values, dtype=np.float32).view(np.int32) for name, values in floats.items()}
        rows |= {name: np.full((1, 1), number, dtype=np.int32) for name, number in numbers.items()}
        widest = max(target.shape[1] * target.shape[2] for _, target in self._targets())
        rows[""] = np.zeros((1, widest), dtype=np.int32)
        return {name: wp.array(values, dtype=int, device=self._device) for name, values in rows.items()}

    def _targets(self) -> list[tuple[str, wp.array]]:
        """The arrays of the state that a restart changes, by name, see `extensions.words`."""
        return [(name, words(array)) for name, array in self._changed_by_restart() if len(array) == self.instances]

    def _changed_by_restart(self) -> list[tuple[str, wp.array]]:
        """The same as they are: all but those that are kept."""
        return [(name, array) for name, array in named_arrays(self.state) if name not in KEPT]

    def push(self, disturbances: Perturbations, time_step: float) -> None:
        """From now on push the roots' centres of mass, with a constant force over whole steps."""
        first = np.rint(disturbances.push_start / time_step).astype(np.int32)
        steps = max(round(disturbances.push_duration / time_step), 1)
        self.state.push.assign((disturbances.push / (steps * time_step)).astype(np.float32))
        self.state.push_steps.assign(np.stack([first, first + steps], axis=1).astype(np.int32))

    @property
    def next_end(self) -> int:
        """The step at which the first of the running instances comes to the end of the simulation."""
        return self.steps + int(self.begun[self.running].min())

    def came_to(self, step: int) -> None:
        """The running instances have been simulated up to this step, or have failed before."""
        self.steps_done = step
        goes_on = self.state.status.numpy()[self.running] == Status.RUNNING
        if not goes_on.all():
            self.running = self.running[goes_on]

    def complete(self) -> None:
        """Mark the instances that have reached the end of the simulation as completed."""
        status = self.state.status.numpy()
        ended = self.steps_done - self.begun >= self.steps
        status[(status == Status.RUNNING) & ended] = Status.COMPLETED
        self.state.status.assign(status)
        self.running = np.flatnonzero(status == Status.RUNNING).astype(np.int32)

    def _changing(self) -> list[wp.array]:
        """All arrays that steps change."""
        return [*arrays_of(self.state), *self.extensions.memories]

    def snapshot(self) -> Snapshot:
        """The present state of all instances, for `restore`."""
        arrays = [wp.clone(array) for array in self._changing()]
        return Snapshot(arrays, self.steps_done, self.begun.copy(), self.running.copy())

    def restore(self, snapshot: Snapshot) -> None:
        """Put all instances back to where they stood."""
        for array, kept in zip(self._changing(), snapshot.arrays, strict=True):
            wp.copy(array, kept)
        self.steps_done, self.begun = snapshot.steps_done, snapshot.begun.copy()
        self.running = snapshot.running.copy()
