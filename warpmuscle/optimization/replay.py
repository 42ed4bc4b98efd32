"""Replays the best candidate of a search."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.objective_parts import Parts
from warpmuscle.simulation.rollout import Rollout

Replay = tuple[Recording, dict[str, Parts]]  # motion of a candidate, and what joints and muscles add to its cost


class Replayer:
    """Replays candidates of a scene one by one, with all of their motion."""

    def __init__(self, scene: Scene, device: str | None = None) -> None:
        """Nothing is made yet; see `make_rollout` for the device: of several it is the first one."""
        self._scene, self._device = scene, device
        self._made: Future[Rollout] | None = None

    def prepare(self) -> None:
        """On a GPU, begin to make ready what `replay` needs, while a search waits for the GPU.

        That takes as long as a small search, and compiling its kernel for the first time takes seconds.
        """
        if self._made is None and not find_devices(self._device)[0].is_cpu:
            pool = ThreadPoolExecutor(1, thread_name_prefix="replay")
            self._made = pool.submit(self._make)
            pool.shutdown(wait=False)

    def replay(self, values: Floats) -> Replay:
        """The scene with these parameter values, (P,).

        Alone, it is the same to the last bit as in a batch, but for what disturbs runs there.
        """
        rollout = self._make() if self._made is None else self._made.result()
        rollout.set_parameters(values)
        rollout.run()
        return rollout.recording(), rollout.parts()

    def _make(self) -> Rollout:
        rollout = Rollout(self._scene, 1, str(find_devices(self._device)[0]), record=[0], threads=1)
        rollout.load()
        return rollout
