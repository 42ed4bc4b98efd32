"""The driver of NVIDIA GPUs, started in the background while Python imports what uses it.

It takes 0.2 s to make a GPU ready, once for a process, whoever asks for it; imports take longer than that.
"""

from __future__ import annotations

import ctypes
import re
import sys
import threading

LIBRARY = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
SUCCESS = 0


def start_driver(device: str | None) -> threading.Thread | None:
    """Begin to make the first of the named GPUs ready; without a driver or for the CPU nothing happens.

    Args:
        device: as for `make_rollout`; without one it is the first GPU.

    Returns:
        The thread that does it, which nobody has to wait for.
    """
    ordinal = re.match(r"cuda(?::(\d+))?", (device or "cuda").strip())
    if ordinal is None:
        return None
    # No daemon: a process must not end while the driver starts.
    thread = threading.Thread(target=_start, args=(int(ordinal[1] or 0),), name="driver")
    thread.start()
    return thread


def _start(ordinal: int) -> None:
    """Make a GPU's context, of which a process has one; who finds no GPU afterwards says so."""
    try:
        driver = ctypes.CDLL(LIBRARY)
    except OSError:
        return
    device, context = ctypes.c_int(), ctypes.c_void_p()
    if driver.cuInit(0) == SUCCESS and driver.cuDeviceGet(ctypes.byref(device), ordinal) == SUCCESS:
        driver.cuDevicePrimaryCtxRetain(ctypes.byref(context), device)
