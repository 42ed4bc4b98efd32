"""Sessions of pytest that start in no time: a process has imported what no mutation changes, and forks for each.

To import pytest, Warp, MuJoCo and SciPy takes as long as many a test. The package and its tests are imported in the
session alone.

python -m mutations.sessions                        the process that forks: requests by standard input, a line each
"""

from __future__ import annotations

import json
import os
import runpy
import select
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

PRELOADED = (
    "pytest", "_pytest.main", "_pytest.terminal", "_pytest.assertion.rewrite", "xdist.plugin", "hypothesis",
    "numpy.random", "numpy.testing", "scipy.optimize", "scipy.interpolate", "scipy.spatial.transform", "scipy.stats",
    "scipy.signal", "scipy.integrate", "h5py", "msgspec", "mujoco", "matplotlib.pyplot", "typer.testing", "warp",
)  # fmt: skip


class Sessions:
    """Runs sessions of pytest one after another, in processes that a process of its own forks."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self.folder, self.environment = folder, environment
        self.server: subprocess.Popen[bytes] | None = None

    def run(self, arguments: list[str], output: Path, limit: float) -> tuple[int | None, float]:
        """Exit code of a session, None if it took longer than `limit` seconds, and its CPU seconds."""
        server = self._server()
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(json.dumps({"arguments": arguments, "output": str(output)}).encode() + b"\n")
        process = int(server.stdout.readline())
        ended = bool(select.select([server.stdout], [], [], max(limit, 1.0))[0])
        with suppress(ProcessLookupError):
            os.killpg(process, 9)  # also what tests have started and a crash has left
        code, cpu = json.loads(server.stdout.readline())
        return (code if ended else None), cpu

    def close(self) -> None:
        """End the process that forks."""
        if self.server is not None:
            assert self.server.stdin is not None
            self.server.stdin.close()
            self.server.wait()
            self.server = None

    def _server(self) -> subprocess.Popen[bytes]:
        if self.server is None or self.server.poll() is not None:
            command = [sys.executable, "-m", "mutations.sessions"]
            pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "bufsize": 0}
            self.server = subprocess.Popen(command, cwd=self.folder, env=self.environment, **pipes)
        return self.server


def _serve(requests: IO[str], answers: IO[str]) -> None:
    """Fork for each request; tell the process, and when it has ended its code and CPU seconds."""
    for name in PRELOADED:
        with suppress(ImportError):
            __import__(name)
    for line in iter(requests.readline, ""):
        request = json.loads(line)
        process = os.fork()
        if process == 0:
            _session(request["arguments"], request["output"])
        with suppress(ProcessLookupError, PermissionError):
            os.setpgid(process, process)  # as the child does, whichever comes first
        answers.write(f"{process}\n")
        answers.flush()
        _, status, used = os.wait4(process, 0)
        answers.write(json.dumps([os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime]) + "\n")
        answers.flush()


def _session(arguments: list[str], output: str) -> None:
    """Be `python -m pytest` with these arguments; never returns."""
    code = 1
    try:
        os.setpgid(0, 0)
        file, nothing = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), os.open(os.devnull, os.O_RDONLY)
        for old, new in ((nothing, 0), (file, 1), (file, 2)):
            os.dup2(old, new)
        sys.argv = ["pytest", *arguments]
        runpy.run_module("pytest", run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    _serve(sys.stdin, os.fdopen(os.dup(1), "w"))
