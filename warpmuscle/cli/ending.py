"""How a run of the program ends: exit codes, errors in a line, interruptions, readers that have gone."""

from __future__ import annotations

import errno
import gc
import signal
import sys
from collections.abc import Callable
from typing import Any, NoReturn

from warpmuscle.cli.console import log, marked
from warpmuscle.cli.shortage import shortage, unwritable_output
from warpmuscle.cli.streams import output_refused, steady_streams
from warpmuscle.core.errors import Error, shortened
from warpmuscle.core.interruption import INTERRUPTED, end_as_by_ctrl_c, received
from warpmuscle.core.plain_text import printable

READER_GONE = 141  # exit code of whoever prints to `head` after it has ended: 128 and SIGPIPE
GARBAGE = 50_000  # objects, at which Python looks for what it can free: starting makes many, all of which stay


def _refuse(why: str) -> NoReturn:
    """End with one line and the exit code of errors that a user can mend."""
    log.print(marked("error:", "bold red", f" {why}"))
    _end(2)


def _end(code: int) -> NoReturn:
    """End with this code, or with that of the signal that has ended the work."""
    if ended_by := received():
        log.print(f"ended by {signal.Signals(ended_by).name}, as by Ctrl-C")
        code = 128 + ended_by
    sys.exit(code)


def run_to_end(work: Callable[[], Any]) -> NoReturn:
    """Do what the program is asked for, and end it; an error that a user can mend is one line and exit code 2.

    Args:
        work: returns the exit code, if it is not 0.
    """
    gc.set_threshold(GARBAGE)
    steady_streams()
    try:
        end_as_by_ctrl_c()
        code = work() or 0
    except KeyboardInterrupt:  # before a command has begun
        code = INTERRUPTED
    except Error as error:
        _refuse(shortened(str(error)))
    except Exception as error:
        usage = getattr(error, "show", None)  # an error in the command's own arguments
        if usage is None:
            why = shortage(error)
            if not why:
                raise
            _refuse(shortened(why))
        if "\n" not in getattr(error, "message", "\n"):  # which quotes what was typed; of several lines it is help
            error.message = printable(error.message)  # type: ignore[attr-defined]
        usage()
        sys.exit(2)
    finally:
        gc.freeze()  # what is left goes with the process; to look for garbage in it takes 0.15 s
    if code == INTERRUPTED and not received():
        log.print("interrupted")
    refused = output_refused()
    if refused is not None and not received():
        if refused.errno != errno.EPIPE:
            _refuse(unwritable_output(refused))
        code = code or READER_GONE
    _end(code)
