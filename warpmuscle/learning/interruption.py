"""Ctrl-C while something must come to its end first."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruption_noticed() -> Iterator[Callable[[], bool]]:
    """Within, the first Ctrl-C is only noticed, and the second one interrupts; gives what tells of the first.

    In other threads than the main one, which never get it, nothing is noticed.
    """
    noticed = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield noticed.is_set
        return
    before = signal.getsignal(signal.SIGINT)

    def notice(number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before)
        noticed.set()

    signal.signal(signal.SIGINT, notice)
    try:
        yield noticed.is_set
    finally:
        signal.signal(signal.SIGINT, before)
