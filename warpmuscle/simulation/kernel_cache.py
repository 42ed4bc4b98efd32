"""Whether a kernel has been compiled before, and what is said while that, or other work, takes long.

Commands show what they do by statuses of their own. From Python a line on the terminal, or below the cell of a
notebook, says it; where neither is, such as in a job of a cluster, nothing is said.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import warp as wp

from warpmuscle.core.plain_text import printable
from warpmuscle.core.repeating import Repeating

P = TypeVar("P")  # how far some work has come
LONG = 1.0  # s, after which it is said what takes so long
EACH = 0.5  # s, between two times that the line is written
WIDEST = 100  # characters of it


def is_compiled(kernel: Any, device: Any, block_dim: int) -> bool:
    """Whether Warp has a kernel in its cache, for the CPU or for GPUs."""
    name = kernel.module.get_module_identifier(block_dim)
    folder = Path(wp.config.kernel_cache_dir) / name
    binaries = folder.glob(f"{name}*.o" if device.is_cpu else f"{name}.sm*")
    return (folder / f"{name}.meta").exists() and any(binaries)


_listeners: list[Callable[[str], Callable[[], None]]] = []
_compiled_now: list[str] = []
_ends: list[Callable[[], None]] = []  # of what listeners were told
_telling = threading.Lock()


def tell_of_compiling(listener: Callable[[str], Callable[[], None]]) -> None:
    """Have a function called with what is compiled, in words, and what it returns called once that is done.

    From then on no lines are written beside it.
    """
    if listener not in _listeners:
        _listeners.append(listener)


@contextmanager
def compiling_reported(what: str) -> Iterator[None]:
    """Tell all listeners while a kernel is compiled; without any, its user.

    Of several that are compiled side by side they hear of the first, until the last is done.
    """
    if not _listeners:
        with said(f"compiling {what}, once (usually 5 to 20 s)"):
            yield
        return
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


@contextmanager
def launched(kernel: Any, device: Any, what: str) -> Iterator[None]:
    """Tell, as `compiling_reported`, while a kernel is launched within that has to be compiled for that."""
    key = (kernel.key, kernel.module.name, str(device))
    if key in _launched or is_compiled(kernel, device, 1 if device.is_cpu else kernel.module.options["block_dim"]):
        yield
    else:
        with compiling_reported(what):
            yield
    _launched.add(key)


_launched: set[tuple[str, str, str]] = set()


class Line:
    """One line of a terminal or a notebook, written anew while work lasts, and empty after it."""

    def __init__(self, text: str) -> None:
        self.text, self._begin, self._width = text, time.monotonic(), 0
        self._repeating = Repeating(self._write, lambda: EACH if self._width else LONG)

    def end(self) -> None:
        """Leave the line empty, with the cursor at its begin."""
        self._repeating.end(self._clear)

    def _clear(self) -> None:
        if self._width:
            self._put("")
            self._put("")

    def _write(self) -> None:
        self._put(printable(f"{self.text}, {time.monotonic() - self._begin:.0f} s")[:WIDEST])

    def _put(self, words: str) -> None:
        try:
            print("\r" + words.ljust(self._width), end="", file=sys.stderr, flush=True)
        except (OSError, ValueError):  # a stream that is gone, or closed
            return
        self._width = len(words)


_lines: list[Line] = []  # the one that is written now


@contextmanager
def progress_said(
    progress: Callable[[P], None] | None, text: str, words: Callable[[P], str]
) -> Iterator[Callable[[P], None] | None]:
    """What is told how far work has come: what its user gave, or else a line, where somebody reads it."""
    if progress is not None:
        yield progress
        return
    with said(text) as line:

        def tell(now: P) -> None:
            if line is not None:
                line.text = words(now)

        yield None if line is None else tell


@contextmanager
def said(text: str) -> Iterator[Line | None]:
    """Say what is done within, from when it has taken a second; None where nobody reads it.

    What is a part of other work stands in the line of that, in place of its text.
    """
    if _lines:
        before, _lines[0].text = _lines[0].text, text
        try:
            yield _lines[0]
        finally:
            for line in _lines:
                line.text = before
        return
    if _listeners or not _read():
        yield None
        return
    _lines.append(line := Line(text))
    try:
        yield line
    finally:
        _lines.clear()
        line.end()


def _read() -> bool:
    """Whether somebody reads the error stream: on a terminal, or below the cell of a notebook."""
    stream = sys.stderr
    try:
        return stream is not None and (stream.isatty() or "ipykernel" in sys.modules)
    except ValueError:  # closed
        return False
