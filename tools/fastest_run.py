"""The time that a run of a batch takes on a machine that others use too."""

from __future__ import annotations

import time

import warp as wp

from warpmuscle.simulation.batch import Batch


def fastest_run(rollout: Batch, repeats: int, noise: float) -> float:
    """Time of the fastest of several runs from starts with noise, m/s, after one that does not count; s."""
    times = []
    for _ in range(1 + repeats):  # the first one compiles
        rollout.reset(noise, seed=1)
        wp.synchronize()
        begin = time.perf_counter()
        rollout.run()
        wp.synchronize()
        times.append(time.perf_counter() - begin)
    return min(times[1:])
