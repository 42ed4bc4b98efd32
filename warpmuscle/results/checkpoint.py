"""Keeps what an optimisation has computed on disk: a result file that is always complete, and a journal beside it."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import os
import re
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from types import TracebackType

from warpmuscle.core.errors import OccupiedError, ResultError
from warpmuscle.results.brief import check_complete
from warpmuscle.results.journal import Journal, journal_path
from warpmuscle.results.records import Evaluations, Result
from warpmuscle.results.result import read, write

GROWTH = 1.25  # of the candidates, at which the file is written anew
INTERVAL = 60.0  # s, after which it is
SHARE = 0.05  # of the wall time at most goes into that
SPEED = 60.0e6  # bytes of candidates a second, that are compressed into it
SOONEST = 2.0  # s, before which it is not; the journal has it


class Checkpoint:
    """The files of one optimisation, which no other process writes meanwhile; a context manager.

    A generation is written beside the search, while the next one is computed; one that fails to be written is told of
    when the next one comes.
    """

    def __init__(self, path: Path, identity: str) -> None:
        """Open the journal of a result file that exists; raises ResultError."""
        self._path = path
        self._journal = Journal(journal_path(path), identity)
        self._written, self._count = time.monotonic(), 0
        self._duration = 0.0
        self._beside = ThreadPoolExecutor(1, thread_name_prefix="files")
        self._writing: Future[None] | None = None

    @classmethod
    def begin(cls, path: Path, start: Result) -> Checkpoint:
        """Write the file that a search begins with, and its journal.

        Raises:
            ResultError: a file cannot be written, or there is an interrupted search of that name.
        """
        journal = journal_path(path)
        if Journal.occupied(journal):
            raise OccupiedError(f"{path}: another process is at work on this search; write to another file")
        if journal.exists() and (path.exists() or Journal.look(journal)):
            raise ResultError(
                f"{path}: an interrupted search; continue it with --resume {path}, or remove {journal} to begin anew"
            )
        checkpoint = cls(path, identity_of(start))  # first, so that an older file stays where there is no room for it
        try:
            write(path, start)
        except BaseException as error:
            if isinstance(error, Exception | KeyboardInterrupt):  # nothing has been evaluated
                checkpoint._journal.remove()
            checkpoint.close()
            raise
        return checkpoint

    @classmethod
    def resume(cls, path: Path) -> tuple[Checkpoint, Result, dict[int, Evaluations]]:
        """Open the files of an earlier search: its result as last written, and all its generations by number.

        Raises:
            ResultError: a file cannot be read or written, holds no search, or is being written by another process.
        """
        first = read(path)
        if first.searched is None:
            raise ResultError(f"{path}: holds no search that could be resumed")
        try:
            check_complete(first, "it cannot go on")
        except ResultError as error:
            raise ResultError(f"{path}: {error}") from None
        checkpoint = cls(path, identity_of(first))
        try:
            result = read(path)  # as it is now that nobody else writes it
            assert result.evaluations is not None
            known = _by_generation(result.evaluations)
            _add(known, checkpoint._generations(result))
            checkpoint._count = len(result.evaluations)
            remove_leftovers(path)
        except BaseException:
            checkpoint.close()
            raise
        return checkpoint, result, known

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let other processes write the files, once all is on the disk."""
        self._beside.shutdown()
        self._journal.close()

    def put(self, generation: Evaluations, count: int, result: Callable[[], Result]) -> None:
        """Begin to put a generation on the disk, and if it is time for that to write the file anew.

        Args:
            generation: its candidates. count: of candidates in all.
            result: gives all that is to be in the file; called now if at all.

        Raises:
            ResultError: the generation before could not be written; with how to go on from what is on the disk.
        """
        self._wait()
        whole = result() if self._due(generation, count) else None
        self._writing = self._beside.submit(self._put, generation, whole)

    def _put(self, generation: Evaluations, whole: Result | None) -> None:
        with self._explained():
            self._journal.append(generation)
        if whole is not None:
            self._write_all(whole)

    def _wait(self) -> None:
        """Until what was begun is on the disk; raises what it raised, once."""
        if self._writing is not None:
            wait([self._writing])  # where an interruption leaves it
            writing, self._writing = self._writing, None
            writing.result()

    def _due(self, generation: Evaluations, count: int) -> bool:
        """Whether it is time to write a file of so many candidates anew, since when not too much time went into it."""
        since = time.monotonic() - self._written
        due = count >= self._count * GROWTH or since >= INTERVAL
        takes = max(self._duration, count * generation.params.shape[1] * generation.params.itemsize / SPEED)
        return due and since >= SOONEST and takes <= SHARE * since

    def write(self, result: Result) -> None:
        """Write the file now, so that the journal need not hold anything.

        Raises:
            ResultError: with how to go on from what is on the disk.
        """
        self._wait()
        self._write_all(result)

    def _write_all(self, result: Result) -> None:
        self._write(result)
        with self._explained():
            self._journal.clear()

    def finish(self, result: Result) -> None:
        """Write the file for the last time, and remove the journal.

        Raises:
            ResultError: with how to go on from what is on the disk, the journal included.
        """
        self._wait()
        self._write(result)
        self._journal.remove()
        remove_leftovers(self._path)

    def _generations(self, result: Result) -> list[Evaluations]:
        """What the journal has besides a result; raises ResultError if it is not of the same search."""
        found, own = self._journal.generations(), result.evaluations
        assert own is not None
        for part in found:
            if part.params.shape[1] != own.params.shape[1] or part.term_names != own.term_names:
                raise ResultError(
                    f"{journal_path(self._path)}: damaged journal: its candidates have other parameters or terms than "
                    "those of the result file; move it out of the way"
                )
        return found

    def _write(self, result: Result) -> None:
        begin = time.monotonic()
        with self._explained():
            write(self._path, result)
        _synchronise(self._path.resolve().parent)
        self._written = time.monotonic()
        self._duration = self._written - begin
        self._count = len(result.evaluations) if result.evaluations is not None else 0

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        """Add to an error how to go on."""
        try:
            yield
        except ResultError as error:
            raise ResultError(f"{error}; what was evaluated is kept: --resume {self._path} continues") from None


def identity_of(result: Result) -> str:
    """A digest of what makes a search what it is: all that it depends on except how long it goes on."""
    assert result.searched is not None
    o = result.searched.options
    numbers = (result.seed, o.searches, o.population or 0, o.sigma or 0)
    parts = (result.scene, o.strategy, o.restarts, *map(float, numbers))
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def _by_generation(evaluations: Evaluations) -> dict[int, Evaluations]:
    numbers = sorted(set(map(int, evaluations.generation)))
    return {number: evaluations.rows(evaluations.generation == number) for number in numbers}


def _add(known: dict[int, Evaluations], parts: list[Evaluations]) -> None:
    """Add what a journal has of generations to what the file has; of the same one the larger part counts."""
    for part in parts:
        number = int(part.generation[0])
        if number not in known or len(known[number]) <= len(part):
            known[number] = part


def remove_leftovers(path: Path) -> None:
    """Remove what a process that was killed while it wrote the file has left beside it (see `replace_file`)."""
    path = path.resolve()
    for other in path.parent.glob(f".{glob.escape(path.name)}.*"):
        if re.fullmatch(r"[0-9a-f]{8}", other.suffix[1:]):
            with contextlib.suppress(OSError):
                other.unlink()


def _synchronise(folder: Path) -> None:
    """Have the folder's new entry on the disk before the journal, which it makes superfluous, is cleared."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
