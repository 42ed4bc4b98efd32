"""A batch shared out over several devices, used as if it were on one."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array, as_integer, as_text, as_texts, check_function
from warpmuscle.core.array_interop import host_array
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.results.recording import Recording
from warpmuscle.simulation.batch import Batch
from warpmuscle.simulation.batch_input import (
    checked_values,
    chosen,
    chunk_steps,
    end_step,
    named_values,
    noise_and_mask,
    positive,
)
from warpmuscle.simulation.commands import checked_commands
from warpmuscle.simulation.devices import devices_name, find_devices, is_several
from warpmuscle.simulation.inputs import checked_disturbances
from warpmuscle.simulation.memory import InstanceBytes
from warpmuscle.simulation.objective_parts import Parts
from warpmuscle.simulation.perturbations import Perturbations
from warpmuscle.simulation.rollout import Rollout, advance_by

Progress = Callable[["MultiDeviceRollout"], None]
Result = TypeVar("Result")
TELLING = 0.2  # s of wall time between two times that progress is called, at least


def make_rollout(
    scene: SceneLike,
    instances: int = 1,
    device: str | None = None,
    *,
    record: Sequence[int] = (),
    record_rate: float = 100.0,
    quantities: Sequence[str] | None = None,
    threads: int | None = None,
    lanes: int | None = None,
    trust: bool = False,
) -> Batch:
    """Make a batch on one device or split over several; both have the same interface and give the same bits.

    Args:
        device: as for `Rollout`, or "cuda:all", or several such as "cuda:0,cuda:2".
        scene, instances, record, record_rate, quantities, threads, lanes, trust: see `Rollout`.

    Raises:
        SceneError, RolloutError: as `Rollout`.
    """
    if not is_several(device):
        return Rollout(
            scene, instances, device, record=record, record_rate=record_rate, quantities=quantities, threads=threads,
            lanes=lanes, trust=trust,
        )  # fmt: skip
    names = [str(single) for single in find_devices(device)]
    return MultiDeviceRollout(
        scene, instances, names, devices_name(device), record=record, record_rate=record_rate, quantities=quantities,
        threads=threads, lanes=lanes, trust=trust,
    )  # fmt: skip


class MultiDeviceRollout(Batch):
    """A batch split evenly over several devices of one kind, in the order of its instances.

    It gives the same bits as a `Rollout`. Arrays on the device are those of its shares.

    Attributes:
        rollouts: on the devices. shares: the instances of each. device: name of all devices.
    """

    def __init__(
        self,
        scene: SceneLike,
        instances: int,
        devices: Sequence[str],
        name: str = "",
        *,
        record: Sequence[int] = (),
        record_rate: float = 100.0,
        quantities: Sequence[str] | None = None,
        threads: int | None = None,
        lanes: int | None = None,
        trust: bool = False,
    ) -> None:
        """Prepare a batch at the scene's initial state and parameter values.

        Args:
            devices: names of single devices, of which as many are used as there are instances.
            name: of all of them; by default their names.
            scene, instances, record, record_rate, quantities, threads, lanes, trust: see `Rollout`; threads are
                those of each device.

        Raises:
            SceneError, RolloutError: as `Rollout`.
        """
        self.scene, self.instances = scene_of(scene, trust=trust), positive(instances, "instances")
        scene, devices = self.scene, as_texts(devices, "devices", error=RolloutError)
        if not devices:
            raise RolloutError("devices must name at least one")
        self.device = as_text(name, "name", error=RolloutError) or ",".join(devices)
        self._devices = len(devices)
        count = min(self._devices, self.instances)
        bounds = [self.instances * k // count for k in range(count + 1)]
        self.shares = [slice(bounds[k], bounds[k + 1]) for k in range(count)]
        self._recorded = chosen(record, self.instances)
        self.rollouts = [
            Rollout(
                scene, share.stop - share.start, device, record_rate=record_rate, quantities=quantities,
                threads=threads, lanes=lanes,
                record=[i - share.start for i in self._recorded if share.start <= i < share.stop],
            )
            for device, share in zip(devices, self.shares, strict=False)
        ]  # fmt: skip
        first = self.rollouts[0]
        self.parameters, self.names, self.steps, self.lanes = first.parameters, first.names, first.steps, first.lanes

    @property
    def devices(self) -> list[Any]:
        return [rollout.device for rollout in self.rollouts]

    def set_parameters(self, values: ArrayLike | Mapping[str, ArrayLike]) -> None:
        if isinstance(values, Mapping):
            named_values(values, self.parameters, np.zeros(len(self.parameters)), self.instances)  # or an error of all
            given = {name: np.asarray(value, dtype=np.float64).reshape(-1) for name, value in values.items()}

            def of(share: slice) -> dict[str, Any]:
                return {name: value if len(value) == 1 else value[share] for name, value in given.items()}

            self._each(lambda rollout, share: rollout.set_parameters(of(share)))
            return
        array = checked_values(values, self.instances, len(self.parameters))
        self._each(lambda rollout, share: rollout.set_parameters(array if array.ndim == 1 else array[share]))

    def set_commands(self, commands: Mapping[str, ArrayLike], *, restart: bool = True) -> None:
        checked = checked_commands(commands, self.scene, self.instances)

        def of(share: slice) -> dict[str, Any]:
            return {name: values[share] if values.ndim else values for name, values in checked.items()}

        self._each(lambda rollout, share: rollout.set_commands(of(share), restart=restart))

    def set_excitations(self, time: ArrayLike, values: ArrayLike, *, restart: bool = True) -> None:
        of = self._shares_of(values, "values")
        self._each(lambda rollout, share: rollout.set_excitations(time, of(share), restart=restart))

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None = None) -> None:
        if of is None:
            motions = self._shares_of(values, "values")
            self._each(lambda rollout, share: rollout.set_motion(time, motions(share)))
        else:
            array, rows = as_array(values, "values", error=RolloutError), self._shares_of(of, "of")
            self._each(lambda rollout, share: rollout.set_motion(time, array, rows(share)))

    def set_initial(
        self, coordinates: ArrayLike | None = None, speeds: ArrayLike | None = None, activation: ArrayLike | None = None
    ) -> None:
        named = {"coordinates": coordinates, "speeds": speeds, "activation": activation}
        starts = {name: self._shares_of(values, name) for name, values in named.items() if values is not None}
        self._each(lambda rollout, share: rollout.set_initial(**{name: of(share) for name, of in starts.items()}))

    def disturb(self, disturbances: Perturbations) -> None:
        checked_disturbances(disturbances, self.instances)
        self._each(lambda rollout, share: rollout.disturb(disturbances.part(share)))

    def reset(self, velocity_noise: Any = 0.0, seed: int = 0, mask: Any = None) -> None:
        noise, chosen = noise_and_mask(self.scene, self.instances, velocity_noise, seed, mask)  # of the whole batch
        self._each(
            lambda rollout, share: rollout.restart(
                noise if len(noise) == 1 else noise[share], None if chosen is None else chosen[share]
            )
        )

    def step(self, k: int = 1, excitations: Any = None, torques: Any = None) -> None:
        arrays = [None if values is None else host_array(values, "input") for values in (excitations, torques)]
        for rollout in self.rollouts:  # one after the other, since threads must not meet in the compiler
            rollout.load_step(*(values is not None for values in arrays))

        def step(rollout: Rollout, share: slice) -> None:
            rollout.step(k, *(None if values is None else self._share(values, share) for values in arrays))

        self._each(step)

    def _shares_of(self, values: ArrayLike, name: str) -> Callable[[slice], Any]:
        """What the instances of a share have of an array with a row an instance, or one row for all."""
        array = as_array(values, name, error=RolloutError)
        return lambda share: self._share(array, share)

    def _share(self, values: Any, share: slice) -> Any:
        """The rows of some instances, or what all of them share; rollouts refuse what has another number of rows."""
        return values[share] if values.ndim and len(values) == self.instances else values

    def run(self, duration: float | None = None, progress: Progress | None = None) -> None:
        end, steps = end_step(self, duration), chunk_steps(self.scene)
        check_function(progress, "progress", error=RolloutError)
        chunks = [steps] * len(self.rollouts)
        self.load()
        while self.steps_done < end and self.running:
            target, begin = min(self.steps_done + steps, end), time.monotonic()
            chunks = self._each(partial(_in_chunks, target, dict(zip(self.rollouts, chunks, strict=True))))
            if progress is not None:
                progress(self)
            if time.monotonic() - begin < TELLING:
                steps *= 2  # since devices wait for one another here, though no longer than Ctrl-C should
        if self.steps_done >= self.steps:
            for rollout in self.rollouts:
                rollout.complete()

    def load(self) -> None:
        for rollout in self.rollouts:  # one after the other, since threads must not meet in the compiler
            rollout.load()

    @property
    def compiles(self) -> bool:
        return self.rollouts[0].compiles

    @property
    def at_once(self) -> int:
        return self._devices * self.rollouts[0].at_once

    @property
    def instance_bytes(self) -> InstanceBytes:
        return self.rollouts[0].instance_bytes

    @property
    def held_bytes(self) -> int:
        return self.rollouts[0].held_bytes

    @property
    def recording_bytes(self) -> int:
        return self.rollouts[0].recording_bytes

    @property
    def running(self) -> bool:
        return any(rollout.running for rollout in self.rollouts)

    @property
    def steps_done(self) -> int:
        """Steps done so far; a device whose instances have all failed goes no further."""
        running = [rollout.steps_done for rollout in self.rollouts if rollout.running]
        return min(running) if running else max(rollout.steps_done for rollout in self.rollouts)

    def status(self) -> Integers:
        return np.concatenate(self._each(lambda rollout, _: rollout.status()))

    def causes(self) -> tuple[str, ...]:
        return tuple(cause for causes in self._each(lambda rollout, _: rollout.causes()) for cause in causes)

    def end_time(self) -> Floats:
        return np.concatenate(self._each(lambda rollout, _: rollout.end_time()))

    def cost(self) -> Floats:
        return np.concatenate(self._each(lambda rollout, _: rollout.cost()))

    def terms(self) -> dict[str, Floats]:
        every = self._each(lambda rollout, _: rollout.terms())
        return {name: np.concatenate([terms[name] for terms in every]) for name in every[0]}

    def parts(self, instance: int = 0) -> dict[str, Parts]:
        instance = as_integer(instance, "instance", 0, self.instances - 1, error=RolloutError)
        rollout, number = self._place(instance)
        return rollout.parts(number)

    @property
    def recorded_instances(self) -> tuple[int, ...]:
        return tuple(self._recorded)

    def recording(self, instance: int | None = None, start: float = 0.0) -> Recording:
        if instance is None and self._recorded:
            instance = self._recorded[0]
        if instance is not None:
            instance = as_integer(instance, "instance", 0, error=RolloutError)
        if instance is None or instance not in self._recorded:
            which = "nothing was" if instance is None else f"instance {instance} was not"
            raise RolloutError(f"{which} recorded: name it in record=[{instance or 0}]")
        rollout, number = self._place(instance)
        return rollout.recording(number, start)

    def recorded(self, quantity: str) -> Floats:
        as_text(quantity, "quantity", error=RolloutError)
        order = [i for share in self.shares for i in self._recorded if share.start <= i < share.stop]
        if not order:
            return self.rollouts[0].recorded(quantity)  # which says that none was
        holding = {id(self._place(i)[0]): self._place(i)[0] for i in order}
        values = [rollout.recorded(quantity) for rollout in holding.values()]
        return np.concatenate(values)[[order.index(i) for i in self._recorded]]

    def _place(self, instance: int) -> tuple[Rollout, int]:
        """The rollout that has an instance, and the instance's number there."""
        which = next(k for k, share in enumerate(self.shares) if instance < share.stop)
        return self.rollouts[which], instance - self.shares[which].start

    def _each(self, work: Callable[[Rollout, slice], Result]) -> list[Result]:
        """What `work` gives of every rollout and its share, all at the same time.

        Waiting for a device, copies and NumPy's work on large arrays let other threads go on.
        """
        if len(self.rollouts) == 1:
            return [work(self.rollouts[0], self.shares[0])]
        before = wp.get_device()
        try:
            with ThreadPoolExecutor(len(self.rollouts)) as pool:
                return list(pool.map(work, self.rollouts, self.shares))
        finally:
            wp.set_device(before)  # copies change Warp's default device for a moment, that of all threads


def _in_chunks(target: int, chunks: Mapping[Rollout, int], rollout: Rollout, share: slice) -> int:
    """Bring a rollout to this step, in chunks that begin as long as this; how long its next one is to be."""
    chunk = chunks[rollout]
    while rollout.running and rollout.steps_done < target:
        chunk = advance_by(rollout, chunk, target)
    return chunk
