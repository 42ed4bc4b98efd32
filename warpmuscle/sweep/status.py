"""What a sweep has come to, while it runs and after a kill."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.sweep.folder import Folder, Manifest, RunState, folder_of
from warpmuscle.sweep.part import part_folders
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

    Where parts of it have begun beside it, and nothing else has, it is what they have come to.

    Raises:
        Error: no sweep of that file has begun.
    """
    try:
        folders = [folder_of(Path(file))]
    except Error:
        parts = part_folders(Path(file))
        folders = list((parts or part_folders(Path(Path(file).name))).values())
        if not folders:
            raise
    manifests = [folder.manifest() for folder in folders]
    states = [
        state for folder, manifest in zip(folders, manifests, strict=True) for state in states_of(folder, manifest)
    ]
    busy = any(folder.busy() for folder in folders)
    return SweepStatus(manifests[0].name, busy, tuple(states), manifests[0].trains)


def states_of(folder: Folder, manifest: Manifest) -> list[RunState]:
    """What the runs of a folder have come to."""
    if manifest.trains:
        return [training_state(folder.result(entry.name), entry) for entry in manifest.runs]
    return folder.states(manifest)
