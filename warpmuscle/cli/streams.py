"""Standard streams that never end the work: one that is closed, full or gone takes what it can.

And the first line of a program that starts slowly: a fresh installation is compiled when Python imports it first.
"""

from __future__ import annotations

import io
import os
import select
import sys
import threading
import time
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

# Commands that work for a while, and say on the error stream what they do.
WORKING = frozenset({
    "adaptation", "compile", "fit-muscles", "fit-paths", "gait", "inverse", "judge", "learn", "optimize", "patient",
    "report", "robustness", "simulate", "study", "sweep", "throw", "video", "view",
})  # fmt: skip
FIRST, AGAIN = 0.7, 1.4  # s, until it is said that the program starts, and until it is said again
SLOW = 1.8  # s, until it is said of another command
started = threading.Event()  # whether a command has printed something itself


class _Steady(io.FileIO):
    """A stream that goes on without what it refuses to take.

    Attributes:
        refused: why it takes nothing more.
    """

    refused: OSError | None = None

    def write(self, data: ReadableBuffer, /) -> int:
        """See `io.FileIO.write`."""
        try:
            while self.refused is None:
                count: int | None = super().write(data)
                if count is not None:
                    return count
                select.select([], [self], [])  # another program has made the terminal that both share non-blocking
        except OSError as error:
            self.refused = error
        return memoryview(data).nbytes


def steady_streams() -> None:
    """Let standard output and error stream of this process be such streams, but for those that somebody captures."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:  # closed: lest a file gets this number, and what libraries print is written into it
            os.dup2(nowhere := os.open(os.devnull, os.O_RDWR), number)
            if nowhere > 2:
                os.close(nowhere)
        stream: IO[str] | None = getattr(sys, name)
        if number > 0 and stream is getattr(sys, f"__{name}__"):
            setattr(sys, name, _steady(number, stream))
        elif number > 0 and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _steady(number: int, stream: IO[str] | None) -> io.TextIOWrapper:
    """For what was written to this stream, if there was one; what a terminal cannot show, it shows as codes."""
    by_line, encoding = True, "utf-8"
    if isinstance(stream, io.TextIOWrapper):
        stream.flush()
        by_line, encoding = stream.line_buffering or stream.write_through, stream.encoding
    raw = _Steady(number, "w", closefd=False)
    return io.TextIOWrapper(io.BufferedWriter(raw), encoding, "backslashreplace", line_buffering=by_line)


def output_refused() -> OSError | None:
    """Why a part of what was printed could not be put out; None if all was."""
    sys.stdout.flush()
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    return raw.refused if isinstance(raw, _Steady) else None


def tell_of_start() -> None:
    """Say that a command is being imported, if that takes long, until it prints something.

    It is said by a thread of its own, and only where `optimize` or the like is called, or `plot` on a slow machine.
    """
    command = "".join(sys.argv[1:2])
    if not command or command.startswith("-"):
        return
    begin = time.monotonic()

    def tell() -> None:
        pause = FIRST if command in WORKING else SLOW
        while not started.wait(pause):
            try:
                os.write(2, f"starting warpmuscle, {time.monotonic() - begin:.0f} s\n".encode())
            except OSError:  # such as of a stream that nobody reads any more
                return
            pause = AGAIN

    threading.Thread(target=tell, name="starting", daemon=True).start()
