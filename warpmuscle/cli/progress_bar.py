"""Bars that show how far an optimisation or a sweep has come."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars

from warpmuscle.cli.console import log
from warpmuscle.core.plain_text import printable

if TYPE_CHECKING:
    from warpmuscle.optimization.progress import Progress


class Bar:
    """A bar between what is done and how it goes, with the time that it takes and has left; gone at the end."""

    def __init__(self, console: Console = log) -> None:
        self._bars = Bars(
            TextColumn("{task.fields[done]}", markup=False),
            BarColumn(),
            TextColumn("{task.fields[state]}", markup=False),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
        )
        self._task = self._bars.add_task("", total=1.0, done="", state="")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars.live.is_started:
            self._bars.stop()

    def show(self, part: float, done: str, state: str) -> None:
        """Show what is done, 0..1 and in words, and how it goes; the first call shows the bar."""
        self._bars.start()
        self._bars.update(self._task, completed=part, done=printable(done), state=printable(state))


class ProgressBar(Bar):
    """Progress of an optimisation: candidates done, alive, generation, costs, seconds simulated, time left.

    Attributes:
        recalled: candidates that were evaluated before.
        simulated: s of motion computed.
    """

    def __init__(self) -> None:
        super().__init__()
        self._begin = time.perf_counter()
        self.simulated, self.recalled = 0.0, 0

    @property
    def elapsed(self) -> float:
        """Wall time so far, s."""
        return time.perf_counter() - self._begin

    def update(self, progress: Progress) -> None:
        """Show this progress."""
        self.simulated, self.recalled = progress.simulated, progress.recalled
        of = f"/{progress.candidates}" if progress.limited else ""
        alive = "compiling, 0" if progress.compiling else progress.alive
        stage = f"stage {progress.stage + 1}/{progress.stages}, {progress.stage_name}, " if progress.stages else ""
        best = f"{progress.best:.5g}" if math.isfinite(progress.best) else "-"
        median = f", median {progress.median:.5g}" if progress.generation > 0 else ""
        costs = f"{stage}generation {progress.generation}, best {best}{median}"
        rate = f"{progress.simulated / self.elapsed:.0f} s/s"
        self.show(progress.fraction, f"{progress.done}{of}", f"{alive} alive, {costs}, {rate}")
