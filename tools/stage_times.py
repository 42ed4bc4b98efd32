"""Where the time of the fused step goes: the clock is read as each of its stages ends, by the lane that leads."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.kernels.memory.scratch import NEAR
from warpmuscle.kernels.step import STAGES, step_kernel
from warpmuscle.kernels.structs import Record
from warpmuscle.simulation.rollout import Rollout


@cache
def lap_of(instances_per_block: int, floats: int, on_gpu: int = 0) -> Any:
    """A Warp function that adds the ticks since the stage before to those of a stage, see `step.no_mark`.

    Ticks of an instance are a row of the buffer, behind working sets of so many floats: on a CPU those of one instance,
    and on a GPU what all keep outside of shared memory, `on_gpu`.
    """
    snippet = f"""
#if defined(__CUDA_ARCH__)
__shared__ unsigned long long* ticks;
__shared__ long long before[{instances_per_block}];
const int place = instance % {instances_per_block};
if (lane == 0) {{
    if (stage < 0)
        ticks = reinterpret_cast<unsigned long long*>(buffer + {4 * on_gpu});
    else
        ticks[instance * {len(STAGES)} + stage] += clock64() - before[place];
    before[place] = clock64();
}}
#else
static unsigned long long* ticks;
static unsigned long long before;
if (stage < 0)
    ticks = reinterpret_cast<unsigned long long*>(buffer + {4 * floats});
else
    ticks[instance * {len(STAGES)} + stage] += __builtin_readcyclecounter() - before;
before = __builtin_readcyclecounter();
#endif
"""

    @wp.func_native(snippet=snippet)
    def mark(instance: int, lane: int, stage: int, buffer: wp.uint64): ...

    return mark


class StageTimes:
    """The kernel of a rollout, as it is and with a clock, on the state of the rollout."""

    def __init__(self, rollout: Rollout, noise: float) -> None:
        """Args: noise: of the starting velocities, m/s."""
        self.rollout, self.noise = rollout, noise
        fused = rollout._launcher.kernel()
        self.fused, self.config, self.plain = fused, fused.config, fused.kernel
        floats = self.config.work_floats // 2 * 2
        on_gpu = self.config.buffer_floats(rollout.instances) if self.config.kind.skeleton.main > NEAR else 0
        on_gpu += on_gpu % 2
        self.kernel = step_kernel(*self.config, mark=lap_of(self.config.instances_a_block, floats, on_gpu))
        self.floats = floats if rollout.device.is_cpu else on_gpu
        self.running = wp.array(np.arange(rollout.instances), dtype=int, device=rollout.device)
        ticks = rollout.instances * len(STAGES)
        self.buffer = wp.zeros(self.floats // 2 + ticks, dtype=wp.uint64, device=rollout.device)

    @property
    def ticks(self) -> np.ndarray:
        """Those of each stage, of all instances together."""
        first = self.floats // 2
        rows = self.buffer.numpy()[first : first + self.rollout.instances * len(STAGES)]
        return rows.reshape(-1, len(STAGES)).sum(axis=0).astype(float)

    def run(self, steps: int, kernel: Any) -> float:
        """Time of some steps from the start, s."""
        rollout, config = self.rollout, self.config
        rollout.reset(self.noise, seed=1)
        self.buffer.zero_()
        inputs = [
            1 if config.paths_apart else steps, self.running, rollout.model, rollout.state, Record(),
            wp.uint64(self.buffer.ptr), rollout._extensions.struct,
        ]  # fmt: skip
        dim, device = (config.rows(rollout.instances), config.lanes), rollout.device
        own = wp.launch(kernel, dim, inputs, device=device, block_dim=config.block_dim, record_cmd=True)
        before = self.before()
        wp.synchronize()
        begin = time.perf_counter()
        for _ in range(steps if before else 1):
            for command in (*before, own):
                command.launch()
        wp.synchronize()
        return time.perf_counter() - begin

    def before(self) -> list[wp.Launch]:
        """What finds paths before a step, if they have kernels of their own."""
        model, state, extensions = self.rollout.model, self.rollout.state, self.rollout._extensions.struct
        return self.fused.commands(1, self.running, self.buffer, model, state, Record(), extensions)[:-1]

    def of_paths(self, steps: int) -> float:
        """Time in which their own kernels find the paths of one step, microseconds; 0 if they have none."""
        self.run(steps, self.plain)
        before = self.before()
        wp.synchronize()
        begin = time.perf_counter()
        for _ in range(steps):
            for command in before:
                command.launch()
        wp.synchronize()
        return 1e6 / steps * (time.perf_counter() - begin) if before else 0.0

    def split(self, steps: int, repeats: int) -> dict[str, float]:
        """Time of a step of the whole batch, microseconds: in all, the fastest of `repeats` runs, and by stage.

        Paths that kernels of their own find are a stage besides, the first one.
        """
        self.run(steps, self.plain)  # compiles and warms up
        whole = 1e6 / steps * min(self.run(steps, self.plain) for _ in range(repeats))
        self.run(steps, self.kernel)
        runs = []
        for _ in range(repeats):
            self.run(steps, self.kernel)
            runs.append(self.ticks)
        ticks = min(runs, key=np.sum)  # of the run that was disturbed least
        paths = min(self.of_paths(steps) for _ in range(repeats))
        own = (whole - paths) * ticks / ticks.sum()
        apart = {"paths": paths} if self.config.paths_apart else {}
        return {"all": whole, **apart} | dict(zip(STAGES, own.tolist(), strict=True))
