"""Whether a kernel has been compiled before."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import warp as wp


def is_compiled(kernel: Any, device: Any, block_dim: int) -> bool:
    """Whether Warp has a kernel in its cache, for the CPU or for GPUs."""
    name = kernel.module.get_module_identifier(block_dim)
    folder = Path(wp.config.kernel_cache_dir) / name
    binaries = folder.glob(f"{name}*.o" if device.is_cpu else f"{name}.sm*")
    return (folder / f"{name}.meta").exists() and any(binaries)
