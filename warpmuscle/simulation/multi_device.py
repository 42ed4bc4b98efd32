"""A batch shared out over several devices, used as if it were on one."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array, as_kind, as_text, as_texts, as_whole, check_function
from warpmuscle.core.array_interop import host_array, is_array, mask_of
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.status import counted, words
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.results.recording import Recording
from warpmuscle.simulation.batch_input import checked_values, chosen, chunk_steps, end_step, positive, root_noise
from warpmuscle.simulation.devices import devices_name, find_devices, is_several
from warpmuscle.simulation.memory import InstanceBytes
from warpmuscle.simulation.perturbations import Disturbances
from warpmuscle.simulation.rollout import Rollout

Progress = Callable[["MultiDeviceRollout"], None]
Given = TypeVar("Given")
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
) -> Rollout | MultiDeviceRollout:
    """A batch on one device, or shared out over several; both are used alike and give the same bits.

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
    names = [str(found) for found in find_devices(device)]
    return MultiDeviceRollout(
        scene, instances, names, devices_name(device), record=record, record_rate=record_rate, quantities=quantities,
        threads=threads, lanes=lanes, trust=trust,
    )  # fmt: skip


class MultiDeviceRollout:
    """A batch over several devices of one kind, each of which has an even share of the instances, one behind the other.

    It has the methods of `Rollout` but for the arrays on the device, which its parts have, and gives the same bits.

    Attributes:
        parts: the rollouts on the devices. shares: the instances of each.
        device: name of all devices.
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
        count = min(len(devices), self.instances)
        bounds = [self.instances * k // count for k in range(count + 1)]
        self.shares = [slice(bounds[k], bounds[k + 1]) for k in range(count)]
        self._recorded = chosen(record, self.instances)
        self.parts = [
            Rollout(
                scene, share.stop - share.start, device, record_rate=record_rate, quantities=quantities,
                threads=threads, lanes=lanes,
                record=[i - share.start for i in self._recorded if share.start <= i < share.stop],
            )
            for device, share in zip(devices, self.shares, strict=False)
        ]  # fmt: skip
        first = self.parts[0]
        self.parameters, self.names, self.steps = first.parameters, first.names, first.steps

    def set_parameters(self, values: ArrayLike) -> None:
        """See `Rollout.set_parameters`."""
        array = checked_values(values, self.instances, len(self.parameters))
        self._each(lambda part, share: part.set_parameters(array if array.ndim == 1 else array[share]))

    def set_excitations(self, time: ArrayLike, values: ArrayLike, *, restart: bool = True) -> None:
        """See `Rollout.set_excitations`."""
        given = as_array(values, "values", error=RolloutError)
        self._each(lambda part, share: part.set_excitations(time, self._shared(given, share), restart=restart))

    def set_motion(self, time: ArrayLike, values: ArrayLike, of: ArrayLike | None = None) -> None:
        """See `Rollout.set_motion`."""
        given = as_array(values, "values", error=RolloutError)
        if of is None:
            self._each(lambda part, share: part.set_motion(time, self._shared(given, share)))
        else:
            rows = as_array(of, "of", error=RolloutError)
            self._each(lambda part, share: part.set_motion(time, given, self._shared(rows, share)))

    def set_initial(
        self,
        coordinates: ArrayLike | None = None,
        speeds: ArrayLike | None = None,
        activation: ArrayLike | None = None,
    ) -> None:
        """See `Rollout.set_initial`."""
        named = {"coordinates": coordinates, "speeds": speeds, "activation": activation}
        given = [
            None if values is None else as_array(values, name, error=RolloutError) for name, values in named.items()
        ]

        def of(share: slice) -> list[Any]:
            return [None if values is None else self._shared(values, share) for values in given]

        self._each(lambda part, share: part.set_initial(*of(share)))

    def _shared(self, values: Any, share: slice) -> Any:
        """The rows of some instances, or what all of them share; parts refuse what has another number of rows."""
        return values[share] if values.ndim and len(values) == self.instances else values

    def reset(self, velocity_noise: Any = 0.0, seed: int = 0, mask: Any = None) -> None:
        """See `Rollout.reset`; the noise is that of the whole batch."""
        if is_array(velocity_noise):
            velocity_noise, mask = 0.0, velocity_noise
        noise = root_noise(self.scene, self.instances, velocity_noise, seed)
        chosen = None if mask is None else mask_of(mask, self.instances)

        def put_back(part: Rollout, share: slice) -> None:
            own = noise if len(noise) == 1 else noise[share]
            if chosen is None:
                part.restart(own)
            else:
                part.restart_some(chosen[share], own)

        self._each(put_back)

    def step(self, k: int = 1, excitations: Any = None, torques: Any = None) -> None:
        """See `Rollout.step`; arrays are shared out, each part to its device."""
        given = [None if values is None else host_array(values, "input") for values in (excitations, torques)]
        for part in self.parts:  # one after the other, since threads must not meet in the compiler
            part.load_step(*(values is not None for values in given))

        def step(part: Rollout, share: slice) -> None:
            part.step(k, *(None if values is None else self._shared(values, share) for values in given))

        self._each(step)

    def disturb(self, disturbances: Disturbances) -> None:
        """See `Rollout.disturb`."""
        as_kind(Disturbances, disturbances, "disturbances", error=RolloutError)
        if len(disturbances) != self.instances:
            raise RolloutError(f"{len(disturbances)} disturbances for {self.instances} instances")
        self._each(lambda part, share: part.disturb(disturbances.part(share)))

    def run(self, duration: float | None = None, progress: Progress | None = None) -> None:
        """See `Rollout.run`; progress is called when all devices have come equally far, a few times a second."""
        end, chunk = end_step(self, duration), chunk_steps(self.scene)
        check_function(progress, "progress", error=RolloutError)
        steps = chunk
        self.load()
        while self.steps_done < end and any(part.running for part in self.parts):
            target, begin = min(self.steps_done + steps, end), time.monotonic()
            self._each(lambda part, share, target=target: _in_chunks(part, target, chunk))  # type: ignore[misc]
            if progress is not None:
                progress(self)
            if time.monotonic() - begin < TELLING:
                steps *= 2  # since devices wait for one another here, though no longer than Ctrl-C should
        if self.steps_done >= self.steps:
            for part in self.parts:
                part.complete()

    def load(self) -> None:
        """See `Rollout.load`; one device after the other, since threads must not meet in the compiler."""
        for part in self.parts:
            part.load()

    @property
    def compiles(self) -> bool:
        """See `Rollout.compiles`."""
        return self.parts[0].compiles

    @property
    def instance_bytes(self) -> InstanceBytes:
        """See `Rollout.instance_bytes`."""
        return self.parts[0].instance_bytes

    @property
    def steps_done(self) -> int:
        """Steps that the batch has come to; a part whose instances have all failed goes no further."""
        running = [part.steps_done for part in self.parts if part.running]
        return min(running) if running else max(part.steps_done for part in self.parts)

    @property
    def time(self) -> float:
        """Simulated time that the batch has come to, s."""
        return self.steps_done * self.scene.time_step

    @property
    def alive(self) -> int:
        """Number of instances that have not failed."""
        return sum(part.alive for part in self.parts)

    def status(self) -> Integers:
        """See `Rollout.status`."""
        return np.concatenate(self._each(lambda part, share: part.status()))

    def status_names(self) -> tuple[str, ...]:
        """See `Rollout.status_names`."""
        return words(self.status())

    def __repr__(self) -> str:
        where = f"{self.scene.name!r}, {self.instances} on {self.device}"
        return f"MultiDeviceRollout({where}, {self.time:.4g} of {self.scene.duration:.4g} s: {counted(self.status())})"

    def end_time(self) -> Floats:
        """See `Rollout.end_time`."""
        return np.concatenate(self._each(lambda part, share: part.end_time()))

    def cost(self) -> Floats:
        """See `Rollout.cost`."""
        return np.concatenate(self._each(lambda part, share: part.cost()))

    def terms(self) -> dict[str, Floats]:
        """See `Rollout.terms`."""
        every = self._each(lambda part, share: part.terms())
        return {name: np.concatenate([terms[name] for terms in every]) for name in every[0]}

    def recording(self, instance: int | None = None) -> Recording:
        """See `Rollout.recording`."""
        if instance is None and self._recorded:
            instance = self._recorded[0]
        if instance is not None:
            instance = as_whole(instance, "instance", 0, error=RolloutError)
        for part, share in zip(self.parts, self.shares, strict=True):
            if instance in self._recorded and instance is not None and share.start <= instance < share.stop:
                return part.recording(instance - share.start)
        raise RolloutError(f"instance {instance} was not recorded: name it in record=[...]")

    def recorded(self, quantity: str) -> Floats:
        """See `Rollout.recorded`."""
        as_text(quantity, "quantity", error=RolloutError)
        whole = [
            part.recorded(quantity)
            for part, share in zip(self.parts, self.shares, strict=True)
            if any(share.start <= i < share.stop for i in self._recorded)
        ]
        if not whole:
            return self.parts[0].recorded(quantity)  # which says that none was
        order = [i for share in self.shares for i in self._recorded if share.start <= i < share.stop]
        return np.concatenate(whole)[[order.index(i) for i in self._recorded]]

    def _each(self, work: Callable[[Rollout, slice], Given]) -> list[Given]:
        """What `work` gives of every part and its share, all at the same time.

        Waiting for a device, copies and NumPy's work on large arrays let other threads go on.
        """
        if len(self.parts) == 1:
            return [work(self.parts[0], self.shares[0])]
        before = wp.get_device()
        try:
            with ThreadPoolExecutor(len(self.parts)) as pool:
                return list(pool.map(work, self.parts, self.shares))
        finally:
            wp.set_device(before)  # copies change Warp's default device for a moment, that of all threads


def _in_chunks(part: Rollout, target: int, chunk: int) -> None:
    """Bring a part to this step."""
    while part.running and part.steps_done < target:
        part.advance(min(part.steps_done + chunk, target))
