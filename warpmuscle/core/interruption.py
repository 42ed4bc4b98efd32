"""What ends a program from outside: Ctrl-C, a request to end, a terminal that goes away."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

# The last three are how schedulers of clusters say that a job's time is nearly over.
_NAMES = ("SIGTERM", "SIGHUP", "SIGUSR1", "SIGUSR2", "SIGXCPU")
ENDING = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))
AGAIN = 0.01  # s, after which an interruption that Python has swallowed comes again
INTERRUPTED = 130  # exit code after Ctrl-C where there is nothing to keep: 128 and SIGINT
_received: list[int] = []


def received() -> int:
    """The signal other than Ctrl-C that asked this process to end; 0 if none did."""
    return _received[0] if _received else 0


def end_at_once_by_ctrl_c() -> None:
    """Have Ctrl-C end this process without more ado, until `end_as_by_ctrl_c`: while there is no work to keep.

    A KeyboardInterrupt would not do: raised while modules are imported, it is printed, swallowed or taken for another
    error, depending on the line. What ignores Ctrl-C goes on to do so. To be called in the main thread.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end_at_once)


def _end_at_once(number: int, frame: FrameType | None) -> None:
    try:
        os.write(2, b"interrupted\n")
    finally:
        os._exit(INTERRUPTED)


def end_as_by_ctrl_c() -> None:
    """Have a request to end and a hangup interrupt what runs, as Ctrl-C does, so that work is kept.

    What is ignored, as by `nohup`, stays so. Of several such signals only the first counts: a shell repeats the hangup
    of its terminal. To be called in the main thread.
    """
    if signal.getsignal(signal.SIGINT) is _end_at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _interrupt)


def repeat_swallowed() -> None:
    """Have a KeyboardInterrupt come again that was raised where Python raises nothing, and so was lost.

    So it is where an object is deleted, garbage is looked for, or C calls back: Python prints the error and goes on.
    """
    if not isinstance(sys.unraisablehook, _Repeated):
        sys.unraisablehook = _Repeated(sys.unraisablehook)


class _Repeated:
    """What is called with errors that cannot be raised; those that are no interruptions are left to another one."""

    def __init__(self, other: Callable[[sys.UnraisableHookArgs], Any]) -> None:
        self._other = other

    def __call__(self, lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):
            _thread.start_new_thread(_interrupt_again, ())  # which takes no lock that may be held here
        else:
            self._other(lost)


def _interrupt_again() -> None:
    time.sleep(AGAIN)  # until the main thread is out of what swallows it; else it comes once more
    _thread.interrupt_main()


def _interrupt(number: int, frame: FrameType | None) -> None:
    if not _received:
        _received.append(number)
        raise KeyboardInterrupt


@contextmanager
def interruption_noticed() -> Iterator[Callable[[], bool]]:
    """Within, the first Ctrl-C, or what else ends, is only noticed; the second Ctrl-C interrupts. Gives what tells.

    In other threads than the main one, which never get it, nothing is noticed.
    """
    noticed = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield noticed.is_set
        return
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, *ENDING)}
    before = {number: handler for number, handler in handlers.items() if callable(handler)}

    def notice(number: int, frame: FrameType | None) -> None:
        restore()
        if number in ENDING and not _received:
            _received.append(number)
        noticed.set()

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    for number in before:
        signal.signal(number, notice)
    try:
        yield noticed.is_set
    finally:
        restore()
