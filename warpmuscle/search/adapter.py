"""Turns a function that calls back for values into an object that is asked and told them."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from queue import SimpleQueue

from warpmuscle.core.array_types import Floats
from warpmuscle.search.search import frozen

Evaluate = Callable[[Floats], Floats]  # values (n,) of points (n, P)
Body = Callable[[Evaluate], str]

PATIENCE = 5.0  # s to wait for a thread that was told to end


class Abandoned(Exception):
    """Raised within the function when nobody wants its result any more."""


class AskTellAdapter:
    """A function in a thread of its own that waits whenever it needs values.

    Only one of the two ever runs: the function until it needs values or ends, or the caller until it tells them. The
    function must not refer to this object: when that is dropped, or when the program exits, the function's next or
    pending call for values raises `Abandoned`, and the thread ends.
    """

    def __init__(self, body: Body, name: str) -> None:
        """Run the function, which is given what to call for values, until it needs the first ones.

        Raises:
            Exception: what the function raised.
        """
        talk = _Talk()
        self.result: str | None = None  # of the function, once it has ended
        self.wanted: Floats | None = None  # points (n, P) whose values it needs
        self._talk = talk
        self._thread = threading.Thread(target=_run, args=(body, talk), name=name, daemon=True)
        self._thread.start()
        weakref.finalize(self, _abandon, talk, self._thread)
        self._listen()

    def tell(self, values: Floats) -> None:
        """Go on with the values (n,) of the points wanted, until the next ones are or the function has ended.

        Raises:
            Exception: what the function raised.
        """
        self._talk.values.put(values)
        self._listen()

    def _listen(self) -> None:
        self.wanted = self.result = None
        heard = self._talk.points.get()
        if isinstance(heard, Exception):
            self.result = "error"
            raise heard
        if isinstance(heard, str):
            self.result = heard
        else:
            self.wanted = heard


class _Talk:
    """What the two sides share."""

    def __init__(self) -> None:
        self.points: SimpleQueue[Floats | str | Exception] = SimpleQueue()  # wanted, or the end
        self.values: SimpleQueue[Floats | None] = SimpleQueue()  # None: give up
        self.abandoned = False

    def evaluate(self, points: Floats) -> Floats:
        """Values (n,) of points (n, P), as soon as they are told."""
        if self.abandoned:  # some functions call again after they were told to stop
            raise Abandoned
        self.points.put(frozen(points))
        values = self.values.get()
        if values is None:
            raise Abandoned
        return values


def _run(body: Body, talk: _Talk) -> None:
    try:
        talk.points.put(body(talk.evaluate))
    except Abandoned:
        pass
    except Exception as error:
        talk.points.put(error)


def _abandon(talk: _Talk, thread: threading.Thread) -> None:
    talk.abandoned = True
    talk.values.put(None)
    if thread is not threading.current_thread():  # the garbage collector runs in any thread
        thread.join(PATIENCE)
