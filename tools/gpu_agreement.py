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
from typing import Annotated

import msgspec
import numpy as np
import typer
import warp as wp
from agreement import LAST_BITS, NOISE, Floats, apart, candidates, moved, same_bits
from scipy.stats import ks_2samp

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

SHORT = 0.1  # s
RUNS = 256  # over this time


def rounding(scene: Scene, device: str, count: int, cpu: Floats, other: Floats) -> None:
    """Print the difference between CPU and GPU over a short time; `other` is the CPU with a disturbance."""
    gpu = moved(scene, device, count)
    for what, values in (("GPU", gpu), ("CPU, starting speeds changed in their last bits", other)):
        off = apart(values, cpu)
        print(f"{SHORT:g} s, {count} runs: {what} against CPU: median {np.median(off):.1e}, largest {off.max():.1e}")


def falls(scene: Scene, device: str, count: int, spread: float) -> Floats:
    """Times at which random candidates end, s."""
    rollout = Rollout(scene, count, device)
    rollout.set_parameters(candidates(scene, count, spread))
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
        known = {"moved": moved(short, "cpu", RUNS), "other": moved(short, "cpu", RUNS, NOISE * LAST_BITS)}
        known["falls"] = falls(long, "cpu", count, spread)
        if cpu is not None:
            np.savez(cpu, **known)
    if not wp.get_cuda_devices():
        return print("no GPU to compare with")
    rounding(short, device, RUNS, known["moved"], known["other"])
    distribution(long, device, count, spread, known["falls"])
    shared = msgspec.structs.replace(loaded, duration=0.3)
    for way, same in same_bits(shared, device, candidates(shared, 600, 0.3), 0.03).items():
        print(f"{way}: {'the same bits' if same else 'DIFFERENT'}")


if __name__ == "__main__":
    run_script(main)
