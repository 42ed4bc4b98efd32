"""What a sweep has come to, while it runs and after a kill."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.sweep.folder import RunState, folder_of
from warpmuscle.sweep.trainings import training_state


@dataclass(frozen=True)
class SweepStatus:
    """What a sweep has come to."""

    name: str
    busy: bool  # whether a process is at work on it
    runs: tuple[RunState, ...]
    trains: bool = False  # whether runs are trainings

    @property
    def evaluated(self) -> int:
        """Candidates in all runs."""
        return sum(run.evaluated for run in self.runs)

    @property
    def ended(self) -> int:
        """How many runs have finished."""
        return sum(bool(run.ended) for run in self.runs)

    @property
    def best(self) -> RunState | None:
        """The run with the least cost, if any has one."""
        best = min(self.runs, key=lambda run: run.best, default=None)
        return best if best is not None and np.isfinite(best.best) else None

    def word(self, run: RunState) -> str:
        """A run's state in a word, or why it is done."""
        if run.ended:
            return f"done: {run.ended}"
        if not run.begun:
            return "waiting"
        return "running" if self.busy else "stopped; the same command goes on"


def sweep_status(file: str | Path) -> SweepStatus:
    """What a sweep has come to, by its sweep file, its output or its folder; disturbs nobody who works on it.

    Raises:
        Error: no sweep of that file has begun.
    """
    folder = folder_of(Path(file))
    manifest = folder.manifest()
    if manifest.trains:
        states = [training_state(folder.result(entry.name), entry) for entry in manifest.runs]
    else:
        states = folder.states(manifest)
    return SweepStatus(manifest.name, folder.busy(), tuple(states), manifest.trains)
