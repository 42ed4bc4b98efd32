"""Warp, started without words where there is nothing to say."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Iterator

import warp as wp

from warpmuscle.core.errors import RolloutError
from warpmuscle.core.files import unwritable

NO_DRIVER = b"Could not find or load the NVIDIA CUDA driver"  # what a machine without a GPU is told each time
FOLDERS = ("XDG_CACHE_HOME", "WARP_CACHE_PATH")  # that Warp's cache may lie in

_started = False


def start_warp() -> None:
    """Start Warp unless it runs, without its greeting and without its warning that a machine without a GPU has none.

    From then on Warp tells of warnings and errors only, unless `warp.config.log_level` was set to something else
    before, or is set later. What else its compiled code says at its start is passed on.

    Raises:
        RolloutError: its folder for compiled kernels cannot be made.
    """
    global _started
    if _started:
        return
    _started = True  # also where it fails: the next call for a device says why
    if wp.config.log_level == wp.LOG_INFO:
        wp.config.log_level = wp.LOG_WARNING
    try:
        with _without(NO_DRIVER), _absolute_folders():
            wp.init()
    except OSError as error:
        raise RolloutError(no_cache(error)) from None


@contextlib.contextmanager
def _absolute_folders() -> Iterator[None]:
    """Leave out of the environment, within, where kernels are to be cached, if it is empty or relative.

    Kernels would be compiled into, and loaded from, the current folder, which may be anyone's. The base directory
    specification says that such values are to be ignored.
    """
    kept = {name: os.environ[name] for name in FOLDERS if not os.path.isabs(os.environ.get(name, os.sep))}
    for name in kept:
        del os.environ[name]
    try:
        yield
    finally:
        os.environ.update(kept)


def no_cache(error: OSError) -> str:
    """What to say where compiled kernels cannot be put down."""
    return (
        f"{wp.config.kernel_cache_dir}: Warp's folder for compiled kernels {unwritable(error)}; "
        "set WARP_CACHE_PATH to the absolute path of another"
    )


@contextlib.contextmanager
def _without(words: bytes) -> Iterator[None]:
    """Leave lines with these words out of what is written to the process's error stream within."""
    try:
        kept = tempfile.TemporaryFile()  # noqa: SIM115 (what may fail is here, what may not within)
        errors = os.dup(2)
    except OSError:  # no room for a file, or no error stream
        yield
        return
    with kept:
        if sys.stderr is not None:
            sys.stderr.flush()
        os.dup2(kept.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(errors, 2)
            os.close(errors)
            kept.seek(0)
            for line in kept:
                if words not in line:
                    os.write(2, line)
