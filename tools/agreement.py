"""What a batch computes, by device and by who shares the work; for `gpu_agreement.py` and `tests/gpu`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.scene import Scene
from warpmuscle.scene.objects.motion import object_motion
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.rollout import Rollout

NOISE = 0.1  # m/s, of starting speeds
LAST_BITS = 1.0 + 3.0e-7  # times that
Floats = NDArray[np.float64]


def candidates(scene: Scene, count: int, spread: float, **options: Any) -> Floats:
    """Random values of the free parameters within a part of their intervals about the start, (count, P)."""
    parameters = Rollout(scene, 1, "cpu", **options).parameters
    low, high, start = (np.array([getattr(p, key) for p in parameters]) for key in ("min", "max", "value"))
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (count, len(start)))
    return np.clip(start + spread * 0.5 * (high - low) * drawn, low, high)


def moved(
    scene: Scene, device: str, count: int, noise: float = NOISE, until: float | None = None, **options: Any
) -> Floats:
    """Coordinates (count, numbers) after the time of the scene, or some of it, s, and places of objects.

    Starts have noise, m/s.
    """
    rollout = Rollout(scene, count, device, record=range(count) if scene.objects else (), **options)
    rollout.reset(noise, seed=1)
    rollout.run(until)
    moved = np.asarray(rollout.state.coordinates.numpy(), dtype=np.float64)
    return np.concatenate([moved, *places_of_objects(rollout, scene, count)], axis=1)


def places_of_objects(rollout: Any, scene: Scene, count: int) -> list[Floats]:
    """Where each object is in the last frame, and how it has turned, (count, 7)."""
    if not scene.objects:
        return []
    recordings = [rollout.recording(instance) for instance in range(count)]
    return [
        np.array([np.concatenate([motion.position[-1], motion.orientation[-1]]) for motion in motions], np.float64)
        for motions in ([object_motion(one, name) for one in recordings] for name in scene.objects)
    ]


def apart(a: Floats, b: Floats) -> Floats:
    """Largest difference of each instance, (count,)."""
    return np.asarray(np.abs(a - b).max(axis=1))


def results(scene: Scene, device: str, values: Floats, chunk: float | None = None, **options: Any) -> Floats:
    """Cost, end, all terms of candidates, and places of objects, (count, numbers), in chunks of time or in one."""
    if scene.objects:
        options.setdefault("record", range(len(values)))
    rollout = make_rollout(scene, len(values), device, **options)
    rollout.set_parameters(values)
    for _ in range(1 if chunk is None else round(scene.duration / chunk)):
        rollout.run(chunk)
    valued = np.stack([rollout.cost(), rollout.end_time(), *rollout.terms().values()], axis=1)
    return np.concatenate([valued, *places_of_objects(rollout, scene, len(values))], axis=1)


def other_ways(scene: Scene, device: str, values: Floats, chunk: float, **options: Any) -> Iterator[tuple[str, Floats]]:
    """The results of candidates by other ways of sharing out their work, each with its name."""
    batches = np.array_split(values[: len(values) // 8 + 2], max(len(values) // 60, 2))

    def got(given: Floats = values, where: str = device, **others: Any) -> Floats:
        return results(scene, where, given, **options, **others)

    if device == "cpu":
        yield "2 threads", got(threads=2)
    else:
        for lanes in (4, 8, 16, 32):
            yield f"{lanes} lanes", got(lanes=lanes)
    yield f"chunks of {chunk:g} s", got(chunk=chunk)
    yield f"in batches of {len(batches[0])}", np.concatenate([got(part) for part in batches])
    yield "in reverse order", got(values[::-1])[::-1]
    yield "with all motion recorded", got(record=range(len(values)))
    if device != "cpu" and len(wp.get_cuda_devices()) > 1:
        yield f"{len(wp.get_cuda_devices())} GPUs", got(where="cuda:all")


def same_bits(scene: Scene, device: str, values: Floats, chunk: float, **options: Any) -> dict[str, bool]:
    """By the name of other ways of sharing out the work, whether the results have the same bits as usually."""
    usual = results(scene, device, values, **options)
    ways = other_ways(scene, device, values, chunk, **options)
    return {way: np.array_equal(got, usual[: len(got)], equal_nan=True) for way, got in ways}
