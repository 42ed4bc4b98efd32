"""Bars that show how far an optimisation or a sweep has come."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, Task, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.table import Column
from rich.text import Text

from warpmuscle.cli.console import between_lines, log
from warpmuscle.core.plain_text import printable
from warpmuscle.core.repeating import Repeating

if TYPE_CHECKING:
    from warpmuscle.optimization.progress import Progress


BAR = 10  # columns of a terminal
SHORTEST = 0.05  # s, between two looks at whether a line is due


class _Yielding(TextColumn):
    """The text that is cut where a terminal is narrow, in favour of all others."""

    def render(self, task: Task) -> Text:
        """See `TextColumn.render`."""
        text = super().render(task)
        text.no_wrap, text.overflow = True, "ellipsis"
        return text


class Bar:
    """A bar between what is done and how it goes, with the time that it takes and has left; gone at the end.

    Where there is no terminal it is a line now and then, the same one again where there is nothing new.
    """

    def __init__(self, console: Console = log) -> None:
        self._console, self._line, self._text = console, time.monotonic(), "getting ready"
        self._repeating: Repeating | None = None
        self._bars = Bars(
            TextColumn("{task.fields[done]}", markup=False),
            BarColumn(bar_width=BAR, table_column=Column(no_wrap=True)),
            _Yielding("{task.fields[state]}", markup=False, table_column=Column()),
            TimeElapsedColumn(table_column=Column(no_wrap=True)),
            TextColumn("left"),
            TimeRemainingColumn(table_column=Column(no_wrap=True)),
            console=console,
            transient=True,
        )
        self._task = self._bars.add_task("", total=1.0, done="", state="")

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self.show(0.0, "", "getting ready")
        else:
            self._repeating = Repeating(self._say_again, self._pause)
        return self

    def _pause(self) -> float:
        return max(between_lines() - (time.monotonic() - self._line), SHORTEST)

    def _say_again(self) -> None:
        if time.monotonic() - self._line > between_lines():
            self._line = time.monotonic()
            self._console.print(self._text)

    def __exit__(self, *_: object) -> None:
        if self._repeating is not None:
            self._repeating.end()
        if self._bars.live.is_started:
            self._bars.stop()

    def show(self, part: float, done: str, state: str, at_once: bool = False) -> None:
        """Show what is done, 0..1 and in words, and how it goes; the first call shows the bar.

        Args:
            at_once: where there is no terminal, do not wait until it is time for another line.
        """
        if not self._console.is_terminal:
            self._text = f"{done}: {state}" if state else done
            if at_once or time.monotonic() - self._line > between_lines():
                self._line = time.monotonic()
                self._console.print(self._text)
            return
        self._bars.start()
        self._bars.update(self._task, completed=part, done=printable(done), state=printable(state))


class ProgressBar(Bar):
    """Progress of an optimisation: candidates done, alive, generation, costs, seconds simulated, time left.

    Attributes:
        recalled: candidates that were evaluated before.
        simulated: s of motion computed.
        computed: part of the time in which batches ran, 0..1.
    """

    def __init__(self) -> None:
        super().__init__()
        self._begin = time.perf_counter()
        self.simulated, self.recalled, self.computed = 0.0, 0, 0.0

    @property
    def elapsed(self) -> float:
        """Wall time so far, s."""
        return time.perf_counter() - self._begin

    def update(self, progress: Progress) -> None:
        """Show this progress."""
        self.simulated, self.recalled, self.computed = progress.simulated, progress.recalled, progress.computed
        of = f"/{progress.candidates}" if progress.limited else ""
        alive = "compiling, 0" if progress.compiling else progress.alive
        stage = f"stage {progress.stage + 1}/{progress.stages}, {progress.stage_name}, " if progress.stages else ""
        best = f"{progress.best:.5g}" if math.isfinite(progress.best) else "-"
        median = f", median {progress.median:.5g}" if progress.generation > 0 else ""
        rate = f"{progress.simulated / self.elapsed:.0f} s/s"
        state = f"best {best}, {stage}generation {progress.generation}, {alive} alive{median}, {rate}"
        self.show(progress.fraction, f"{progress.done}{of}", state)
