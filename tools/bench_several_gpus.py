"""How much faster several GPUs are than one, and whether they give the same bits.

    python tools/bench_several_gpus.py                           walk56 on cuda:0 and on all GPUs of this machine
    CUDA_VISIBLE_DEVICES=0,1 python tools/bench_several_gpus.py  on two of them
    python tools/bench_several_gpus.py --instances 5120 --scene fwalk

Every biped has parameters of its own, as in a search. Times are those of a run over some motion, the fastest of three,
without what comes before: the parameters' way to the devices takes about as long as half a second of motion.
"""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from fastest_run import fastest_run
from numpy.typing import NDArray

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.multi_device import make_rollout

SPREAD = 0.01  # of the parameters about their start
RUNS = 3
NOISE = 0.01  # m/s, of the root's velocity at the start


def spread(parameters: Any, count: int) -> NDArray[np.float64]:
    """Values of the parameters near their start, (count, P), within their intervals."""
    start, low, high = (np.array([getattr(p, key) for p in parameters]) for key in ("value", "min", "max"))
    factors = 1.0 + SPREAD * np.random.default_rng(0).normal(size=(count, len(start)))
    return np.clip(start * factors, low, high)


def measured(scene: Scene, count: int, device: str) -> tuple[float, int, NDArray[np.float64]]:
    """Time of the fastest of some runs, s, the steps that all bipeds make in one, and their costs."""
    batch = make_rollout(scene, count, device)
    batch.set_parameters(spread(batch.parameters, count))
    seconds = fastest_run(batch, RUNS, NOISE)
    steps = int(np.rint(batch.end_time() / scene.time_step).sum())
    return seconds, steps, batch.cost()


def main(
    scene: Annotated[str, typer.Option(help="Scene with free parameters.")] = "walk56",
    instances: Annotated[str, typer.Option(help="Batch sizes.")] = "16384,65536",
    seconds: Annotated[float, typer.Option(help="Motion of a run.")] = 1.0,
    devices: Annotated[str, typer.Option(help="Several, such as cuda:0,cuda:2; cpu for a trial.")] = "cuda:all",
) -> None:
    """Measure, and print how the bits compare."""
    wp.config.log_level = wp.LOG_WARNING
    found = find_devices(devices)
    short = msgspec.structs.replace(load(scene, ignored=[]), duration=seconds)
    for count in map(int, instances.split(",")):
        one, steps, costs = measured(short, count, str(found[0]))
        every, _, same = measured(short, count, devices)
        bits = "the same bits" if np.array_equal(costs, same) else "OTHER BITS"
        print(
            f"{count} x {seconds:g} s: {steps / one / 1e6:.1f} million steps/s on {found[0]}, "
            f"{steps / every / 1e6:.1f} on {len(found)}: {one / every:.2f} times as fast, "
            f"{one / every / len(found):.2f} of linear, {bits}",
            flush=True,
        )


if __name__ == "__main__":
    run_script(main)
