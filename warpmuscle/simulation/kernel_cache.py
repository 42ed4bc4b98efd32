"""Whether a kernel has been compiled before, and who is told when one is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Any

import warp as wp


def is_compiled(kernel: Any, device: Any, block_dim: int) -> bool:
    """Whether Warp has a kernel in its cache, for the CPU or for GPUs."""
    name = kernel.module.get_module_identifier(block_dim)
    folder = Path(wp.config.kernel_cache_dir) / name
    binaries = folder.glob(f"{name}*.o" if device.is_cpu else f"{name}.sm*")
    return (folder / f"{name}.meta").exists() and any(binaries)


_listeners: list[Callable[[str], Callable[[], None]]] = []
_compiled_now: list[str] = []
_ends: list[Callable[[], None]] = []  # of what listeners were told
_telling = Lock()


def tell_of_compiling(listener: Callable[[str], Callable[[], None]]) -> None:
    """Have a function called with what is compiled, in words, and what it returns called once that is done."""
    if listener not in _listeners:
        _listeners.append(listener)


@contextmanager
def compiling_reported(what: str) -> Iterator[None]:
    """Tell all listeners while a kernel is compiled; of several side by side, of the first until the last is done."""
    with _telling:
        if not _compiled_now:
            _ends[:] = [listener(what) for listener in _listeners]
        _compiled_now.append(what)
    try:
        yield
    finally:
        with _telling:
            _compiled_now.remove(what)
            for end in _ends if not _compiled_now else ():
                end()
