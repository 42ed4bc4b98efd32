"""The command line within the process of a test: a process of its own imports, and builds kernels, for seconds."""

import contextlib
import gc
import io
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import patch

import warpmuscle
from warpmuscle.cli.program import main
from warpmuscle.core import interruption
from warpmuscle.scene import trusted_code
from warpmuscle.simulation import kernel_cache

HANDLED = (signal.SIGINT, *interruption.ENDING)


def run(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """What `warpmuscle` with these arguments prints in a folder, and its exit code, as of a process that has ended."""
    words = ["warpmuscle", *map(str, arguments)]
    shown, errors = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))
    code: object = 0
    with as_in_a_process(words, folder), patch("sys.stdout", shown), patch("sys.stderr", errors):
        try:
            main()
        except SystemExit as end:
            code = end.code
    texts = [stream.buffer.getvalue().decode() for stream in (shown, errors)]  # type: ignore[attr-defined]
    return subprocess.CompletedProcess(words, code if isinstance(code, int) else int(code is not None), *texts)


@contextlib.contextmanager
def as_in_a_process(words: list[str], folder: Path) -> Iterator[None]:
    """What a command finds within, and what it leaves there for good, end as a process does."""
    handlers = {number: signal.getsignal(number) for number in HANDLED}
    threshold, before = gc.get_threshold(), os.getcwd()
    os.chdir(folder)
    try:
        with contextlib.ExitStack() as kept:
            kept.enter_context(patch("sys.argv", words))
            kept.enter_context(patch("sys.path", list(sys.path)))
            kept.enter_context(patch("sys.unraisablehook", sys.unraisablehook))
            kept.enter_context(patch.object(trusted_code, "_trusted", set()))
            kept.enter_context(patch.object(trusted_code, "_folders", []))
            kept.enter_context(patch.object(trusted_code, "_everything", False))
            kept.enter_context(patch.object(kernel_cache, "_listeners", []))
            kept.enter_context(patch.object(gc, "freeze"))  # what tests have frozen stays so, and nothing else
            kept.enter_context(warnings.catch_warnings())
            warnings.resetwarnings()
            yield
    finally:
        os.chdir(before)
        gc.set_threshold(*threshold)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for name in [name for name, module in sys.modules.items() if _is_of(folder, module)]:
            del sys.modules[name]


def _is_of(folder: Path, module: object) -> bool:
    """Whether a module was imported from a folder of a test, in which another test's may have its name."""
    file = getattr(module, "__file__", None)
    return bool(file) and Path(file).is_relative_to(folder) and not folder.is_relative_to(_PACKAGE)


_PACKAGE = Path(warpmuscle.__file__).parent
