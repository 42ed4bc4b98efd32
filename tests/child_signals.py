"""Programs that tests start hear signals as those of a terminal do, whatever the tests were told to ignore."""

from __future__ import annotations

import signal


def hear_signals() -> None:
    """As `preexec_fn` of a program: undo what `nohup` and the background of a shell do, which children inherit."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
