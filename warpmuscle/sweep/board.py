"""How far a sweep has come: keeps count of all its runs, and tells its user."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.optimization.progress import Progress
from warpmuscle.sweep.folder import Folder, Manifest, RunState
from warpmuscle.sweep.task import Task

TELL_EVERY = 0.2  # s


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep has come."""

    runs: int
    ended: int  # of them
    candidates: int  # in all runs
    evaluated: int  # of them
    best: float  # least cost of all runs; infinite before there is one
    best_run: str
    alive: int  # still walking in the batch that runs now; 0 where that is not known
    gathered: int = 0  # runs that have been written into the output, once all have run
    training: TrainingProgress | None = None  # of the run `best_run`, where runs are trainings

    def in_words(self) -> str:
        """The same, short."""
        searched = f"{self.evaluated} of {number_of(self.candidates, 'candidate')}"
        return f"sweeping: {self.ended} of {number_of(self.runs, 'run')}, {searched}"


Tell = Callable[[SweepProgress], None]


class Board:
    """Keeps count of all runs of a sweep, and tells its user.

    Attributes:
        states: what the runs have come to by their files, in order, as of the last look.
    """

    def __init__(self, folder: Folder, manifest: Manifest, tell: Tell | None) -> None:
        self._folder, self._manifest, self._tell = folder, manifest, tell
        self.states = folder.states(manifest)
        self._place = {entry.name: number for number, entry in enumerate(manifest.runs)}
        self._done = np.array([state.evaluated for state in self.states], dtype=np.int64)
        self._best = np.array([state.best for state in self.states])
        self._asked = np.array([entry.candidates for entry in manifest.runs], dtype=np.int64)
        self._ended = np.array([bool(state.ended) for state in self.states], dtype=bool)
        self._alive, self._gathered = 0, 0
        self._last = 0.0
        self._report()

    def left(self, tasks: Sequence[Task]) -> list[Task]:
        """Those of the tasks that have not ended."""
        return [task for task in tasks if not self._ended[self._place[task.name]]]

    def report(self, name: str, progress: Progress) -> None:
        """One run has come so far; or, without a name, the batch that several of them share."""
        if name:
            row = self._place[name]
            if progress.done >= self._done[row]:  # a search that goes on begins by asking for what is known of it
                self._done[row], self._best[row] = progress.done, progress.best
            self._ended[row] |= progress.done >= self._asked[row]
        self._alive = progress.alive
        if time.monotonic() >= self._last + TELL_EVERY:
            self._report()

    def finished(self, state: RunState) -> None:
        """A run has ended, and has its file."""
        row = self._place[state.name]
        self.states[row] = state
        self._done[row], self._best[row], self._ended[row] = state.evaluated, state.best, True

    def gathering(self, count: int) -> None:
        """So many runs have been written into the output."""
        self._alive, self._gathered = 0, count
        if time.monotonic() >= self._last + TELL_EVERY:
            self._report()

    def look(self) -> None:
        """Look into the files of the runs that had not finished."""
        rows = [row for row, state in enumerate(self.states) if not state.ended]
        entries = [self._manifest.runs[row] for row in rows]
        for row, state in zip(rows, self._folder.states_of(entries), strict=True):
            self.states[row] = state
            self._done[row], self._best[row], self._ended[row] = state.evaluated, state.best, bool(state.ended)
        self._report()

    def _report(self) -> None:
        self._last = time.monotonic()
        if self._tell is None:
            return
        best = int(np.argmin(self._best))
        candidates = int(np.where(self._ended, self._done, self._asked).sum())
        self._tell(
            SweepProgress(
                len(self._done), int(self._ended.sum()), candidates, int(self._done.sum()), float(self._best[best]),
                self._manifest.runs[best].name, self._alive, self._gathered,
            )
        )  # fmt: skip
