"""The devices that a batch runs on, and the memory that they have left."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import warp as wp

from warpmuscle.core.arguments import as_text
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.warp_start import start_warp

ALL_GPUS = "cuda:all"


def find_devices(name: str | None) -> list[Any]:
    """The Warp devices of a name such as `cpu`, `cuda:1`, `cuda:all` or `cuda:0,cuda:2`.

    Without a name it is the first GPU, or the CPU if there is none.

    Raises:
        RolloutError: there is no such device, or several are named that cannot share a batch.
    """
    start_warp()
    if name is None:
        return [wp.get_preferred_device()]
    if isinstance(name, wp.Device):
        return [name]
    as_text(name, "device", error=RolloutError)
    if name.strip() == ALL_GPUS:
        gpus = list(wp.get_cuda_devices())
        if not gpus:
            raise RolloutError(f"there is no GPU here, of which '{ALL_GPUS}' takes all; known: {_known()}")
        return gpus
    devices = [_device(part.strip(), name) for part in name.split(",")]
    if len(devices) > 1 and any(device.is_cpu for device in devices):
        raise RolloutError(f"'{name}' names the CPU as one of several devices; only GPUs share a batch")
    if len({device.alias for device in devices}) < len(devices):
        raise RolloutError(f"'{name}' names a device twice")
    return devices


def find_device(name: str | None) -> Any:
    """The one Warp device of a name; see `find_devices`.

    Raises:
        RolloutError: also where it names several.
    """
    if is_several(name):
        raise RolloutError(f"'{name}' may be several devices, and this takes one; see warpmuscle.make_rollout")
    return find_devices(name)[0]


def is_several(name: str | None) -> bool:
    """Whether a name may stand for more than one device."""
    return isinstance(name, str) and (name.strip() == ALL_GPUS or "," in name)


def devices_name(name: str | None) -> str:
    """The name under which a result keeps its devices; raises as `find_devices`."""
    devices = find_devices(name)
    return ALL_GPUS if isinstance(name, str) and name.strip() == ALL_GPUS else ",".join(map(str, devices))


def free_memory(device: Any) -> int | None:
    """Bytes that can be allocated on a device; None where the system does not tell."""
    if not device.is_cpu:
        wp.synchronize_device(device)  # gives what was freed back
        return int(device.free_memory)
    return _available_memory()


def _available_memory() -> int | None:
    """Bytes of the machine's memory that programs can have without swapping."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    except (OSError, ValueError):
        pass
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def _device(part: str, name: str) -> Any:
    try:
        if part.startswith("cuda") and not wp.is_cuda_available():  # which Warp would say in lines of its own
            raise ValueError(part)
        return wp.get_device(part)
    except (ValueError, RuntimeError) as error:
        of = f", which '{name}' names," if part != name else ""
        raise RolloutError(f"there is no device '{part}'{of} here; known: {_known()}") from error


def _known() -> str:
    return ", ".join(device.alias for device in wp.get_devices())
