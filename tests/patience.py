"""Waiting for what must come, however slow or busy the machine is; `test_patience.py` holds all tests to it."""

import itertools
import threading
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

PATIENCE = 600.0  # s, after which what must come will never come
MOMENT = 0.1  # s, in which what must not come has a chance to


def until(condition: Callable[[], object], process: Any = None) -> None:
    """Wait until a condition holds; what a process is to bring about must come while that runs."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if process is not None and process.poll() is not None:
            assert condition(), f"the process has ended before, with {process.poll()}"
            return
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.02)


def for_a_moment(seconds: float = MOMENT) -> None:
    """Give what must not happen a chance to, or let any moment come; what must happen is waited for by `until`."""
    time.sleep(seconds)


def ticking(seconds: float) -> Any:
    """A clock, in place of a module's `time`, that goes on by so much whenever one looks at it."""
    looks = itertools.count()
    return SimpleNamespace(monotonic=lambda: seconds * next(looks))


def ended(name: str) -> None:
    """Wait until no thread of this name runs."""
    until(lambda: all(thread.name != name for thread in threading.enumerate()))
