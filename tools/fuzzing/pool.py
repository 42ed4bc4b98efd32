"""Worker processes that stay alive over many cases, since to start Python and Warp takes a second."""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from fuzzing.judge import COMPILING, HANG, SECRET, NotCompiled, Verdict, crowding, judged
from fuzzing.kinds import Setting, make

MEMORY = 12 * 2**30  # bytes of addresses that a worker may have
LARGEST = 3 * 2**30  # bytes in use, beyond which a worker is followed by a fresh one
Case = tuple[str, int]


@dataclass(frozen=True)
class Settings:
    """What all cases have in common."""

    seed: int
    seeds: Path
    work: Path  # where the folders of cases are made
    reference: Path | None
    compiling: bool  # whether kernels may be compiled for a case


def run_case(case: Case, settings: Settings, keep: bool = False) -> Verdict:
    """Make a case in a folder of its own, run it, and remove the folder unless it is to be kept."""
    kind, number = case
    around = settings.work / f"{kind}-{number}"
    shutil.rmtree(around, ignore_errors=True)
    folder = around / "outer" / "case"
    folder.mkdir(parents=True)
    secret = folder.parent / "secret.h5"
    _write_secret(secret)
    commands = make(kind, number, settings.seed, Setting(folder, settings.seeds, secret, settings.reference))
    os.environ["TMPDIR"] = tempfile.tempdir = str(settings.work)
    verdict = judged(commands, folder, around, COMPILING if settings.compiling else HANG)
    if not keep:
        shutil.rmtree(around, ignore_errors=True)
    return verdict


def run_all(cases: Sequence[Case], settings: Settings, processes: int) -> Iterator[tuple[Case, Verdict]]:
    """Run cases in several processes; a process that dies or hangs is a complaint, and another takes its place."""
    waiting = list(reversed(cases))
    workers = [_Worker(settings) for _ in range(min(processes, len(cases)))]
    try:
        while waiting or any(worker.case for worker in workers):
            for worker in workers:
                if worker.case is None and waiting:
                    worker.give(waiting.pop())
            wait([worker.connection for worker in workers if worker.case], timeout=1.0)
            for index, worker in enumerate(workers):
                if worker.case is None or (verdict := worker.look()) is None:
                    continue
                yield worker.case, verdict
                worker.case = None
                if not worker.alive:
                    worker.end()
                    workers[index] = _Worker(settings)
    finally:
        for worker in workers:
            worker.end()


class _Worker:
    """A process that runs one case after another."""

    def __init__(self, settings: Settings) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, other = context.Pipe()
        self._stacks = settings.work / f"stacks-{time.monotonic_ns()}"
        self._process = context.Process(target=_serve, args=(other, settings, self._stacks), daemon=True)
        self._process.start()
        other.close()
        self._patience = 120.0 if settings.compiling else 40.0  # the first case also waits for imports
        self.alive, self.case = True, None  # type: bool, Case | None
        self._given = 0.0

    def give(self, case: Case) -> None:
        """Let it run a case."""
        self.case, self._given = case, time.monotonic()
        self.connection.send(case)

    def look(self) -> Verdict | None:
        """The verdict on the case; None while it goes on."""
        seconds = time.monotonic() - self._given
        if self.connection.poll():
            with suppress(EOFError, ConnectionError):
                verdict, self.alive = self.connection.recv()
                return verdict
            self.alive = False
            self._process.join(5.0)
            return Verdict([f"the process ended with {self._process.exitcode}:\n{self._stack()}"], seconds=seconds)
        if seconds < self._patience * crowding():
            return None
        self.alive = False
        return Verdict([f"still busy after {seconds:.0f} s:\n{self._stack()}"], seconds=seconds)

    def _stack(self) -> str:
        """Where its threads were when it hung or crashed, if it could say so."""
        return self._stacks.read_text() if self._stacks.exists() else ""

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()
        self.connection.close()


def _serve(connection: Connection, settings: Settings, stacks: Path) -> None:
    """Run cases until the other end is closed."""
    prepare(settings)
    with stacks.open("w") as file:
        faulthandler.enable(file)
        while True:
            try:
                case = connection.recv()
            except EOFError:
                return
            file.seek(0)
            file.truncate()
            faulthandler.dump_traceback_later(HANG * crowding(), file=file)
            verdict = run_case(case, settings)
            faulthandler.cancel_dump_traceback_later()
            used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
            goes_on = used < LARGEST
            connection.send((verdict, goes_on))
            _tidy()


def prepare(settings: Settings) -> None:
    """Make a process fit for cases: little memory, no pictures on screens, no kernel that is not there."""
    from warpmuscle.cli.common import start_warp

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    os.environ |= {"MPLBACKEND": "agg", "NO_COLOR": "1", "COLUMNS": "200", "CUDA_VISIBLE_DEVICES": ""}
    start_warp()
    if settings.compiling:
        import warp as wp

        wp.config.optimization_level = 0
    else:
        _forbid_compiling()


def _forbid_compiling() -> None:
    from warp._src import build

    from warpmuscle.simulation.fused_kernel import FusedKernel

    load = FusedKernel.load

    def refuse(*_: object, **__: object) -> None:
        raise NotCompiled

    def careful(self: Any) -> None:
        if not self._loaded and self.compiles:
            raise NotCompiled
        load(self)

    FusedKernel.load = careful  # type: ignore[method-assign]
    build.build_cpu = refuse  # of single stages, such as those that `info` launches


def _tidy() -> None:
    """Undo what the command line does for a process that ends soon."""
    import gc

    gc.unfreeze()  # not collected each time: that takes as long as many cases
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


def _write_secret(path: Path) -> None:
    import h5py
    import numpy as np

    with h5py.File(path, "w") as file:
        file["secret"] = np.full(10, 1234.5)
        file["text"] = SECRET
        file.attrs["text"] = SECRET
