"""Runs of a sweep on a Ray cluster: a task is one or several runs on a GPU or on some CPU cores.

Workers that see the folder of the sweep write there, generation by generation, so that a task that is tried again after
its worker or its machine died goes on where it was. Others begin with what the folder had, and send back files.
"""

from __future__ import annotations

import contextlib
import io
import logging
import math
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.results.journal import journal_path
from warpmuscle.simulation.devices import is_several
from warpmuscle.sweep.folder import MANIFEST, Folder, Manifest
from warpmuscle.sweep.local import run_here
from warpmuscle.sweep.named_code import NamedCode, trusted_there
from warpmuscle.sweep.task import Task

RETRIES = 5  # of a task whose worker died
LOOK_EVERY = 1.0  # s
GRACE = 30.0  # s for workers to keep what they have after an interrupt
CONNECT_TIMEOUT = 10.0  # s for its machine to answer
PROBE_TIMEOUT = 60.0  # s to join a cluster
BARE = sys.prefix  # folder without modules: workers import from where Ray was started, and not from any such folder
_NOBODY, _REFUSED = 3, 4  # exit codes of the probe
_PROBE = f"""
import logging, sys, ray
try:
    ray.init(address=sys.argv[1], logging_level=logging.CRITICAL, log_to_driver=False)
except ConnectionError as error:
    print(error, file=sys.stderr)
    sys.exit({_NOBODY})
except Exception as error:
    print(error, file=sys.stderr)
    sys.exit({_REFUSED})
"""


@dataclass(frozen=True)
class _Outcome:
    """What became of a task."""

    failed: dict[str, str]  # why, by name of the run
    files: dict[str, bytes]  # of a worker that does not see the folder: result files by name of the run


class Cluster:
    """A connection to a Ray cluster; a context manager.

    Attributes:
        device_kind: what its tasks compute on, cpu or cuda.
    """

    def __init__(self, address: str, device: str | None, threads: int | None) -> None:
        """Connect.

        Raises:
            Error: Ray is not installed, there is no cluster at the address, it lacks the device, or several devices
                are asked for.
        """
        if is_several(device):
            raise Error(f"a task of a cluster gets one GPU, not '{device}'; leave the device out to use all of them")
        try:
            import ray
        except ImportError:
            raise Error('a cluster needs Ray: pip install "warpmuscle[cluster]"') from None
        self._ray = ray
        self._mine = not ray.is_initialized()
        if self._mine:
            _connect(ray, address)
        resources = ray.cluster_resources()
        self._gpus = int(resources.get("GPU", 0))
        self._cpus = int(resources.get("CPU", 0))
        gpu = self._gpus > 0 if device is None else device != "cpu"
        self.device_kind = "cuda" if gpu else "cpu"
        self._device = (device or "cuda:0") if gpu else "cpu"
        self._threads = threads or 1
        wanted = (1 if gpu else 0, 0 if gpu else self._threads)
        if wanted[0] > self._gpus or wanted[1] > self._cpus:
            self.__exit__(None, None, None)
            what = "GPU" if gpu else f"{self._threads} CPU cores for a task"
            raise Error(f"the cluster has no {what}: it has {self._cpus} CPU cores and {self._gpus} GPUs")

    def __enter__(self) -> Cluster:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._mine:
            self._ray.shutdown()

    def run(
        self, tasks: Sequence[Task], folder: Folder, manifest: Manifest, share: int | None, look: Callable[[], None],
        code: NamedCode,
    ) -> dict[str, str]:  # fmt: skip
        """Run what is left of a sweep.

        Args:
            code: that the scenes name.
            share: runs a task, see `run.sweep`.
            look: called every second.

        Returns:
            Why runs failed, by name.

        Raises:
            KeyboardInterrupt: after the workers have kept what they have.
        """
        size = share or (math.ceil(len(tasks) / self._gpus) if self.device_kind == "cuda" else 1)
        gpus, cpus = (1, 0) if self.device_kind == "cuda" else (0, self._threads)
        remote = self._ray.remote(num_gpus=gpus, num_cpus=cpus, max_retries=RETRIES)(_work)
        waiting: dict[Any, list[Task]] = {}
        for begin in range(0, len(tasks), max(size, 1)):
            part = list(tasks[begin : begin + size])
            known = {task.name: _files(folder.result(task.name)) for task in part}
            reference = remote.remote(
                part, str(folder.path.resolve()), str(Path.cwd()), manifest.token, known, code, self._device,
                self._threads,
            )  # fmt: skip
            waiting[reference] = part
        failed: dict[str, str] = {}
        try:
            while waiting:
                ready, _ = self._ray.wait(list(waiting), num_returns=len(waiting), timeout=LOOK_EVERY)
                for reference in ready:
                    failed |= self._taken(reference, waiting.pop(reference), folder)
                look()
        except KeyboardInterrupt:
            self._cancel(list(waiting))
            raise
        return failed

    def _taken(self, reference: Any, part: Sequence[Task], folder: Folder) -> dict[str, str]:
        """Take the outcome of a task; why its runs failed."""
        exceptions = self._ray.exceptions
        try:
            outcome = self._ray.get(reference)
        except (exceptions.WorkerCrashedError, exceptions.NodeDiedError, exceptions.OutOfMemoryError) as error:
            why = f"its worker died {RETRIES + 1} times ({type(error).__name__}); the same command goes on"
            return {task.name: why for task in part}
        except exceptions.RayError as error:
            lines = str(error).strip().splitlines() or [type(error).__name__]
            return {task.name: lines[-1].strip() for task in part}
        for name, content in outcome.files.items():
            try:
                replace_file(folder.result(name), content)
            except SceneError as error:
                outcome.failed[name] = str(error)
        return dict(outcome.failed)

    def _cancel(self, references: list[Any]) -> None:
        """Interrupt all tasks, and wait until they have kept what they have, or for the time of grace."""
        for reference in references:
            with contextlib.suppress(Exception):
                self._ray.cancel(reference)
        with contextlib.suppress(Exception, KeyboardInterrupt):
            self._ray.wait(references, num_returns=len(references), timeout=GRACE)


def _connect(ray: Any, address: str) -> None:
    """Join a cluster; with `auto` start one on this machine if none runs. Raises Error."""
    silent = {"logging_level": logging.CRITICAL, "log_to_driver": False, "configure_logging": False}
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # else Ray warns of what a later version does
    _check_reachable(address)
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-c", _PROBE, address], capture_output=True, text=True, timeout=PROBE_TIMEOUT,
            check=False, cwd=BARE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise Error(f"no Ray cluster answers at {address!r} within {PROBE_TIMEOUT:.0f} s") from None
    if done.returncode == _NOBODY and address == "auto":
        nowhere = io.StringIO()
        with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere), contextlib.chdir(BARE):
            ray.init(include_dashboard=False, **silent)
        return
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or ["it cannot be reached"]
        raise Error(f"no Ray cluster can be joined at {address!r}: {said[-1]}")
    try:
        with contextlib.chdir(BARE):
            ray.init(address=address, **silent)
    except Exception as error:
        raise Error(f"no Ray cluster can be joined at {address!r}: {' '.join(str(error).split())}") from None


def _check_reachable(address: str) -> None:
    """Raise Error if nobody listens at host:port; Ray itself goes on trying for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host or not port.isdigit():
        return
    try:
        socket.create_connection((host, int(port)), CONNECT_TIMEOUT).close()
    except (OSError, OverflowError) as error:
        raise Error(f"no Ray cluster answers at {address!r}: {getattr(error, 'strerror', None) or error}") from None


def _work(
    tasks: list[Task], folder: str, here: str, token: str, known: dict[str, dict[str, bytes]], code: NamedCode,
    device: str, threads: int,
) -> _Outcome:  # fmt: skip
    """A task: the runs of a worker; `here` is the current folder of who asks, for files that scenes name."""
    with contextlib.suppress(OSError):
        os.chdir(here)
    with _place(Path(folder), token, known) as (place, is_shared), trusted_there(code):
        failed = run_here(tasks, place, device, threads)
        files = {} if is_shared else {task.name: (place / f"{task.name}.h5") for task in tasks}
        return _Outcome(failed, {name: path.read_bytes() for name, path in files.items() if path.exists()})


@contextlib.contextmanager
def _place(folder: Path, token: str, known: dict[str, dict[str, bytes]]) -> Iterator[tuple[Path, bool]]:
    """Where a worker keeps its files: the folder of the sweep if it sees it, or else one of its own."""
    if _sees(folder, token):
        yield folder, True
        return
    with tempfile.TemporaryDirectory(prefix="warpmuscle-sweep-") as own:
        for files in known.values():
            for name, content in files.items():
                (Path(own) / name).write_bytes(content)
        yield Path(own), False


def _sees(folder: Path, token: str) -> bool:
    """Whether this machine has the folder of that sweep, and not another one of its name."""
    try:
        return token.encode() in (folder / MANIFEST).read_bytes()
    except OSError:
        return False


def _files(result: Path) -> dict[str, bytes]:
    """The files of a run that has begun, by name, for workers that do not see them."""
    paths = (result, journal_path(result))
    return {path.name: path.read_bytes() for path in paths if path.exists()}
