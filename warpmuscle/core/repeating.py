"""What is said now and then while work lasts, and never after it."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Repeating:
    """Calls a function now and then from a thread of its own, which a compiler lets run beside it.

    Between two calls it waits for as long as `pause` says, s, which is asked anew each time.
    """

    def __init__(self, say: Callable[[], None], pause: Callable[[], float]) -> None:
        self._say, self._pause = say, pause
        self._ended, self._saying = threading.Event(), threading.Lock()
        threading.Thread(target=self._repeat, name="says what goes on", daemon=True).start()

    def end(self, last: Callable[[], None] = lambda: None) -> None:
        """Call it no more: it has returned, and so has `last`, before this does. What is said next comes behind."""
        with self._saying:
            self._ended.set()
            last()

    def _repeat(self) -> None:
        while not self._ended.wait(self._pause()):
            with self._saying:
                if not self._ended.is_set():
                    self._say()
