"""Whether a GPU computes what the CPU does, and the same bits however the work is shared out.

    python tools/gpu_agreement.py                            walk56 on cuda:0, and on all GPUs if there are several
    python tools/gpu_agreement.py --scene fwalk --seconds 5
    python tools/gpu_agreement.py --cpu cpu.npz              the CPU's part alone without a GPU, or from that file

- Over 0.1 s, coordinates on the GPU differ from those on the CPU by rounding: beside it stands by how much they differ
  on the CPU itself if the starting speeds are changed in their last bits.
- Over the whole time the motions part, as such motions do, but the times at which random candidates fall have the same
  distribution (two-sample Kolmogorov-Smirnov test).
- Bits are the same for all lanes, batch sizes, places in a batch, chunks of steps, and numbers of GPUs, with motion
  recorded or not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from numpy.typing import NDArray
from scipy.stats import ks_2samp

from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.rollout import Rollout

SHORT = 0.1  # s
RUNS = 256  # over this time
Floats = NDArray[np.float64]


def candidates(rollout: Any, count: int, spread: float) -> Floats:
    """Random values of the free parameters within a part of their intervals about the start, (count, P)."""
    low, high, start = (np.array([getattr(p, key) for p in rollout.parameters]) for key in ("min", "max", "value"))
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (count, len(start)))
    return np.clip(start + spread * 0.5 * (high - low) * drawn, low, high)


def moved(scene: Scene, device: str, count: int, noise: float, **options: Any) -> Floats:
    """Coordinates after a short time from starts with noise."""
    rollout = Rollout(scene, count, device, **options)
    rollout.reset(noise, seed=1)
    rollout.run(SHORT)
    return np.asarray(rollout.state.coordinates.numpy(), dtype=np.float64)


def rounding(scene: Scene, device: str, count: int, cpu: Floats, other: Floats) -> None:
    """Print the difference between CPU and GPU over a short time; `other` is the CPU with a disturbance."""
    gpu = moved(scene, device, count, 0.1)
    for what, values in (("GPU", gpu), ("CPU, starting speeds changed in their last bits", other)):
        apart = np.abs(values - cpu).max(axis=1)
        print(
            f"{SHORT:g} s, {count} runs: {what} against CPU: median {np.median(apart):.1e}, largest {apart.max():.1e}"
        )


def falls(scene: Scene, device: str, count: int, spread: float) -> Floats:
    """Times at which random candidates end, s."""
    rollout = Rollout(scene, count, device)
    rollout.set_parameters(candidates(rollout, count, spread))
    rollout.run()
    return np.asarray(rollout.end_time(), dtype=np.float64)


def distribution(scene: Scene, device: str, count: int, spread: float, cpu: Floats) -> None:
    """Print whether candidates fall alike."""
    gpu = falls(scene, device, count, spread)
    test = ks_2samp(cpu, gpu)
    upright = [int((times >= scene.duration - 1e-6).sum()) for times in (cpu, gpu)]
    print(
        f"{scene.duration:g} s, {count} random candidates: median end {np.median(cpu):.3f} s on the CPU, "
        f"{np.median(gpu):.3f} s on the GPU, upright {upright[0]} and {upright[1]}; KS statistic {test.statistic:.4f}, "
        f"p = {test.pvalue:.2f}"
    )


def same_bits(scene: Scene, device: str) -> None:
    """Print for which ways of sharing out the work the results differ, or that none do."""
    given = candidates(Rollout(scene, 1, device), 600, 0.3)

    def results(values: Floats, chunk: float | None = None, where: str = device, **options: Any) -> Floats:
        rollout = make_rollout(scene, len(values), where, **options)
        rollout.set_parameters(values)
        for _ in range(1 if chunk is None else round(scene.duration / chunk)):
            rollout.run(chunk)
        return np.stack([rollout.cost(), rollout.end_time()], axis=1)

    usual = results(given)
    ways = {f"{lanes} lanes": results(given, lanes=lanes) for lanes in (4, 8, 16, 32)}
    ways["chunks of 0.03 s"] = results(given, chunk=0.03)
    ways["in batches of 7"] = np.concatenate([results(part) for part in np.array_split(given[:70], 10)])
    ways["in reverse order"] = results(given[::-1])[::-1]
    ways["with all motion recorded"] = results(given, record=range(len(given)))
    if len(wp.get_cuda_devices()) > 1:
        ways[f"{len(wp.get_cuda_devices())} GPUs"] = results(given, where="cuda:all")
    for way, got in ways.items():
        same = np.array_equal(got, usual[: len(got)])
        print(f"{way}: {'the same bits' if same else 'DIFFERENT'}")


def main(
    scene: Annotated[str, typer.Option(help="Scene.")] = "walk56",
    device: Annotated[str, typer.Option(help="GPU.")] = "cuda:0",
    seconds: Annotated[float, typer.Option(help="Time of the random candidates.")] = 10.0,
    count: Annotated[int, typer.Option(help="Random candidates.")] = 2000,
    spread: Annotated[float, typer.Option(help="Of the candidates, as a part of their intervals.")] = 0.6,
    cpu: Annotated[Path | None, typer.Option(help="File of the CPU's part.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    loaded = load(scene, ignored=[])
    short, long = (msgspec.structs.replace(loaded, duration=time) for time in (SHORT, seconds))
    if cpu is not None and cpu.exists():
        known = dict(np.load(cpu))
    else:
        known = {"moved": moved(short, "cpu", RUNS, 0.1), "other": moved(short, "cpu", RUNS, 0.1 * (1.0 + 3e-7))}
        known["falls"] = falls(long, "cpu", count, spread)
        if cpu is not None:
            np.savez(cpu, **known)
    if not wp.get_cuda_devices():
        return print("no GPU to compare with")
    rounding(short, device, RUNS, known["moved"], known["other"])
    distribution(long, device, count, spread, known["falls"])
    same_bits(msgspec.structs.replace(loaded, duration=0.3), device)


if __name__ == "__main__":
    typer.run(main)
