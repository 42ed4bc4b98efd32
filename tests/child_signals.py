"""Programs that tests start hear signals as those of a terminal do, whatever the tests were told to ignore."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import Any

# The command line in a process of its own, with arguments after it, which looks for garbage late, as `warpmuscle` does.
PROGRAM = [
    *(sys.executable, "-c"),
    "import warpmuscle.__main__ as begin; begin.collect_late(); from warpmuscle.cli.program import main; main()",
]


def hear_signals() -> None:
    """As `preexec_fn` of a program: undo what `nohup` and the background of a shell do, which children inherit."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)


@contextlib.contextmanager
def running(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[Any]]:
    """A process of such a program, which is gone afterwards, also where a test has failed."""
    with subprocess.Popen(command, preexec_fn=hear_signals, **options) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()
