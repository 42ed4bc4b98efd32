"""What a compiled kernel takes of a GPU, as the CUDA driver says: registers, local and shared memory, occupancy."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from typing import Any

import warp as wp

ATTRIBUTES = {"shared_bytes_a_block": 1, "stack_bytes_a_thread": 3, "registers": 4}  # CUfunction_attribute


def binary_of(kernel: Any) -> Path:
    """The newest compiled module of a kernel in Warp's cache, a cubin or else PTX; the kernel has been loaded."""
    folders = Path(wp.config.kernel_cache_dir).glob(f"wp_{kernel.module.name}_*")
    found = [path for folder in folders for path in folder.iterdir() if path.suffix in (".cubin", ".ptx")]
    return max(found, key=lambda path: (path.suffix == ".cubin", path.stat().st_mtime))


def resources(kernel: Any, device: Any, block_dim: int, lanes: int) -> dict[str, int]:
    """Registers and stack of a thread, shared memory of a block, and how many instances a multiprocessor holds.

    Raises:
        RuntimeError: the CUDA driver refuses. OSError: there is none.
    """
    driver = ctypes.CDLL("libcuda.so.1")

    def call(function: str, *arguments: Any) -> None:
        error = getattr(driver, function)(*arguments)
        if error != 0:
            raise RuntimeError(f"{function} failed with CUDA error {error}")

    path = binary_of(kernel)
    name = re.search(rb"\w+_cuda_kernel_forward", path.read_bytes())
    assert name is not None, f"{path} has no kernel"
    with wp.ScopedDevice(device):
        module, function, value = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_int()
        call("cuModuleLoad", ctypes.byref(module), str(path).encode())
        try:
            call("cuModuleGetFunction", ctypes.byref(function), module, name.group())
            figures = {}
            for attribute, number in ATTRIBUTES.items():
                call("cuFuncGetAttribute", ctypes.byref(value), ctypes.c_int(number), function)
                figures[attribute] = value.value
            blocks = "cuOccupancyMaxActiveBlocksPerMultiprocessor"
            call(blocks, ctypes.byref(value), function, ctypes.c_int(block_dim), ctypes.c_size_t(0))
        finally:
            call("cuModuleUnload", module)
    figures["shared_bytes_an_instance"] = figures["shared_bytes_a_block"] * lanes // block_dim
    figures["instances_a_multiprocessor"] = value.value * block_dim // lanes
    figures["instances_on_the_device"] = figures["instances_a_multiprocessor"] * device.sm_count
    return figures
