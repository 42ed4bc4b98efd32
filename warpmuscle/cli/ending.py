"""How a run of the program ends: exit codes, errors in a line, interruptions, readers that have gone."""

from __future__ import annotations

import atexit
import contextlib
import errno
import gc
import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any, NoReturn

from warpmuscle.cli.console import log, marked
from warpmuscle.cli.resource_errors import shortage, unwritable_output
from warpmuscle.cli.streams import output_refused, steady_streams
from warpmuscle.core.errors import Error, shortened
from warpmuscle.core.interruption import INTERRUPTED, end_as_by_ctrl_c, received, repeat_swallowed
from warpmuscle.core.plain_text import printable

READER_GONE = 141  # exit code of whoever prints to `head` after it has ended: 128 and SIGPIPE


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


def _came_of_an_interruption(error: BaseException) -> bool:
    """Whether an error was raised while an interruption was, such as by the release of a lock that it had broken."""
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return cause is not None


def _explain(error: Exception) -> NoReturn:
    """End with what an error in the command's own arguments says, or a full machine; raise any other again."""
    if not hasattr(error, "format_message"):
        why = shortage(error)
        if not why:
            raise error
        _refuse(shortened(why))
    why = error.format_message()
    if not why or "\n" in why:  # of none or several lines it is help
        error.show()  # type: ignore[attr-defined]
        sys.exit(2)
    why = printable(why).rstrip(".")  # which quotes what was typed
    context = getattr(error, "ctx", None)
    _refuse(f"{why[:1].lower()}{why[1:]}" + (f"; see {context.command_path} --help" if context else ""))


def run_to_end(work: Callable[[], Any]) -> NoReturn:
    """Do what the program is asked for, and end it; an error that a user can mend is one line and exit code 2.

    Args:
        work: returns the exit code, if it is not 0.
    """
    steady_streams()
    try:
        end_as_by_ctrl_c()
        repeat_swallowed()
        code = work() or 0
    except KeyboardInterrupt:  # before a command has begun
        code = INTERRUPTED
    except Error as error:
        _refuse(shortened(str(error)))
    except Exception as error:
        if not _came_of_an_interruption(error):
            _explain(error)
        code = INTERRUPTED
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


def run_script(command: Callable[..., Any]) -> NoReturn:
    """Run a script's function on what the command line says, and end as the program ends.

    Args:
        command: whose parameters are the arguments and options, as Typer reads them; returns the exit code or nothing.
    """
    import typer  # what answers at once waits for no command line

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)
    run_to_end(lambda: app(standalone_mode=False))


def end_process(ended: SystemExit) -> NoReturn:
    """End this process as Python does, threads and what is registered for its end included, but at once after that.

    To take apart all that has been imported takes a while. Where somebody looks on, such as a profiler, or asks for a
    prompt after the program, all is left to Python.
    """
    wait = getattr(threading, "_shutdown", None)  # of Python's own end: for all threads that are no daemons
    run_registered = getattr(atexit, "_run_exitfuncs", None)
    if wait is None or run_registered is None or not isinstance(ended.code, int) or _watched():
        raise ended
    wait()
    run_registered()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):  # of a stream that is gone, or closed
            stream.flush()
    os._exit(ended.code)


def _watched() -> bool:
    """Whether a debugger, a profiler or a measure of coverage follows this process, or a prompt is to come after it."""
    tools = getattr(sys, "monitoring", None)
    used = tools is not None and any(tools.get_tool(number) for number in range(6))
    return bool(used or sys.gettrace() or sys.getprofile() or sys.flags.inspect or os.environ.get("PYTHONINSPECT"))
