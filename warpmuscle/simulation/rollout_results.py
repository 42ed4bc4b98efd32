"""What a batch on one device has come to: its state, how its instances ended, costs, recordings, memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial

import numpy as np
import warp as wp

from warpmuscle.core.arguments import as_integer, as_number, as_text
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels import structs
from warpmuscle.model.objective import counted_terms
from warpmuscle.model.structure import Structure
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import substitute
from warpmuscle.simulation.batch import Batch
from warpmuscle.simulation.extensions import Extensions
from warpmuscle.simulation.inputs import Inputs
from warpmuscle.simulation.memory import InstanceBytes, instance_bytes, struct_bytes
from warpmuscle.simulation.objective_parts import Parts
from warpmuscle.simulation.outcome import Outcome
from warpmuscle.simulation.recorder import Recorder, frame_bytes

OBSERVED = ("coordinates", "speeds", "foot_force", "step", "status")


class RolloutResults(Batch):
    """What can be asked of a `Rollout`, which has these parts."""

    structure: Structure
    numeric: Scene
    _paths_apart: bool  # whether a kernel of their own finds paths of muscles
    _few: Scene  # the same with a row for several instances that have equal numbers
    state: structs.State
    model: structs.Model
    _extensions: Extensions
    _inputs: Inputs
    _recorder: Recorder
    _values: Floats
    _commands: Mapping[str, Floats]

    @cached_property
    def instance_bytes(self) -> InstanceBytes:
        """Bytes of device memory per additional instance."""
        return instance_bytes(self.scene, self.structure, self._paths_apart)

    @property
    def held_bytes(self) -> int:
        return struct_bytes(self.state, self.model, self._extensions.struct)

    @property
    def recording_bytes(self) -> int:
        return frame_bytes(self.structure) * -(-self.steps // self._recorder.every)

    @property
    def recorded_instances(self) -> tuple[int, ...]:
        return tuple(self._recorder.chosen)

    def observation(self) -> dict[str, wp.array]:
        """State that controllers may observe, by name, as Warp arrays on the rollout's device, without a copy.

        They are the state itself, which steps change in place: `wp.to_torch`, `wp.to_jax` or `np.from_dlpack` make
        other libraries see it. Do not write to them. They need not be contiguous.

        Returns:
            coordinates, speeds: (instances, ...), as in `coordinate_names` and `speed_names`.
            phase, stance, machine_state: (instances,), only of scenes with a SIMBICON controller.
            foot_force: (instances, 2, 3) N, left and right foot, of the step before.
            activation, muscle_force: (instances, simulated muscles), N.
            step, status: (instances,) steps since its start, and `Status`.
        """
        muscles = self.state.muscles
        arrays = {name: getattr(self.state, name) for name in OBSERVED}
        if self.scene.simbicon is not None:
            arrays |= {name: getattr(self.state.simbicon, name) for name in ("phase", "stance", "machine_state")}
        return arrays | {"activation": muscles.activation, "muscle_force": muscles.force}

    @cached_property
    def _counted(self) -> tuple[str, ...]:
        """Names of the terms; not of the numbers: a free weight may be 0 in all instances."""
        return counted_terms(self.scene.objective)

    @property
    def _outcome(self) -> Outcome:
        return Outcome(self._counted, self._few, self.structure, self.state, self._inputs.start.coordinates)

    def status(self) -> Integers:
        return self._outcome.status()

    def causes(self) -> tuple[str, ...]:
        return self._outcome.causes()

    def end_time(self) -> Floats:
        return self._outcome.end_time()

    def terms(self) -> dict[str, Floats]:
        return self._outcome.terms()

    def cost(self) -> Floats:
        return self._outcome.cost()

    def parts(self, instance: int = 0) -> dict[str, Parts]:
        return self._outcome.parts(as_integer(instance, "instance", 0, self.instances - 1, error=RolloutError))

    def recording(self, instance: int | None = None, start: float = 0.0) -> Recording:
        start = as_number(start, "start", error=RolloutError)
        number = self._recorder.instance(instance)
        found = self._recorder.recording(self.numeric, number, int(self.state.step.numpy()[number]), start)
        return self._made(found, number)

    def recordings(self, instances: Sequence[int] | None = None) -> list[Recording]:
        """Recordings of several instances, by default of all that were recorded, faster than one by one."""
        asked = self._recorder.chosen if instances is None else instances
        numbers = [self._recorder.instance(instance) for instance in asked]
        steps = self.state.step.numpy()[numbers].tolist()
        found = self._recorder.recordings(self.numeric, numbers, steps)
        return [self._made(motion, number) for motion, number in zip(found, numbers, strict=True)]

    def _made(self, found: Recording, number: int) -> Recording:
        """A motion that knows what made it."""
        values = self._values if self._values.ndim == 1 else self._values[number]
        commands = {name: value[number] if value.ndim else value for name, value in self._commands.items()}
        return found.made_by(partial(substitute, self.scene, values, commands))

    def recorded(self, quantity: str) -> Floats:
        as_text(quantity, "quantity", error=RolloutError)
        return self._recorder.values_until(quantity, min(self.steps_done, self.steps), self.state.step.numpy())

    @property
    def controller_state(self) -> Floats:
        """Memory of the scene's declared controller, (instances, floats); (instances, 0) if it has none."""
        floats = self.structure.controller.custom.memory(len(self.names.bodies))
        memory = self._extensions.struct.first.memory if floats else None
        return np.zeros((self.instances, 0)) if memory is None else np.asarray(memory.numpy()[:, 0])
