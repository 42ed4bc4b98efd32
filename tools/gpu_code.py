"""Compiles the steps of scenes for a GPU, on a machine that need not have one.

What the compiler refuses, or what has no room in shared memory, shows here; whether results are right shows only on a
GPU (`pytest -m gpu`). Each scene takes 5 to 20 s.

python tools/gpu_code.py                        the steps of all shipped scenes
python tools/gpu_code.py walk56 bwalk_stairs    of these; also TOML files
python tools/gpu_code.py walk56 --arch 80       for a GPU of compute capability 8.0
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import warp as wp

from warpmuscle.core.shipped import shipped_scenes
from warpmuscle.formats import load
from warpmuscle.kernels.recording.record import NOTHING
from warpmuscle.kernels.step import step_kernel
from warpmuscle.simulation.launcher import kernel_config
from warpmuscle.simulation.rollout import Rollout

INSTANCES = 5120


class Gpu(NamedTuple):
    """What the choice of a kernel asks of a device."""

    sm_count: int = 132  # of an H100
    is_cpu: bool = False


def main(words: Sequence[str] | None = None) -> int:
    """Compile, print a line a scene, and return how many failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="names or TOML files; by default all shipped scenes")
    parser.add_argument("--arch", type=int, default=90, help="compute capability times 10")
    options = parser.parse_args(words)
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in options.scenes or shipped_scenes():
            begin = time.monotonic()
            try:
                made = compile_step(name, options.arch, Path(folder))
            except Exception as error:
                failed += 1
                print(f"{name}: {type(error).__name__}: {str(error).strip().splitlines()[0]}", flush=True)
            else:
                size = sum(file.stat().st_size for file in made)
                print(f"{name}: {size / 1e3:.0f} kB, {time.monotonic() - begin:.1f} s", flush=True)
    print(f"{failed} failed")
    return failed


def compile_step(scene: str, arch: int, folder: Path) -> list[Path]:
    """Compile the fused step of a scene, as many instances of it as fill a GPU launch it; the binaries."""
    rollout = Rollout(load(scene), instances=1, device="cpu")
    config = kernel_config(rollout.numeric, rollout.structure, INSTANCES, Gpu(), None, NOTHING)
    own = folder / Path(scene).stem
    wp.compile_aot_module(step_kernel(*config).module, module_dir=str(own), arch=arch, use_ptx=False)
    return sorted(own.glob("*.cubin"))


if __name__ == "__main__":
    raise SystemExit(min(main(), 1))
