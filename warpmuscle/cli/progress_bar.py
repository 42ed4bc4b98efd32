"""The bar that shows how far an optimisation has come."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars

from warpmuscle.cli.common import UNLIMITED
from warpmuscle.cli.console import log

if TYPE_CHECKING:
    from warpmuscle.progress import Progress


class ProgressBar:
    """Progress of an optimisation: candidates done, alive, generation, costs, seconds simulated, time left.

    Attributes:
        recalled: candidates that were evaluated before.
        simulated: s of motion computed.
    """

    def __init__(self) -> None:
        self._bars = Bars(
            TextColumn("{task.fields[done]}{task.fields[of]}"),
            BarColumn(),
            TextColumn("{task.fields[alive]} alive, {task.fields[costs]}, {task.fields[rate]} s/s"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=log,
            transient=True,
        )
        self._task = self._bars.add_task("", total=1.0, done=0, of="", alive=0, costs="", rate="-")
        self._begin = time.perf_counter()
        self.simulated, self.recalled = 0.0, 0

    @property
    def elapsed(self) -> float:
        """Wall time so far, s."""
        return time.perf_counter() - self._begin

    def __enter__(self) -> ProgressBar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars.live.is_started:
            self._bars.stop()

    def update(self, progress: Progress) -> None:
        """Show this progress; the first one shows the bar."""
        self._bars.start()
        self.simulated, self.recalled = progress.simulated, progress.recalled
        median = f", median {progress.median:.5g}" if progress.generation > 0 else ""
        best = f"{progress.best:.5g}" if math.isfinite(progress.best) else "-"
        stage = f"stage {progress.stage + 1}/{progress.stages} {progress.stage_name}, " if progress.stages else ""
        self._bars.update(
            self._task,
            completed=progress.fraction,
            done=progress.done,
            of=f"/{progress.candidates}" if progress.candidates < UNLIMITED else "",
            alive="compiling, 0" if progress.compiling else progress.alive,
            costs=f"{stage}generation {progress.generation}, best {best}{median}",
            rate=f"{progress.simulated / self.elapsed:.0f}",
        )
