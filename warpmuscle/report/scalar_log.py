"""How a search, a sweep or a training goes, as files that TensorBoard draws; nothing leaves the machine."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from os import PathLike
from typing import Any, Protocol

from warpmuscle.core.arguments import as_path
from warpmuscle.core.errors import Error
from warpmuscle.core.extras import need
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.optimization.progress import Progress


class SweepProgress(Protocol):
    """What is drawn of how far a sweep has come, see `sweep.board`."""

    @property
    def ended(self) -> int:
        """Runs that have."""

    @property
    def evaluated(self) -> int:
        """Candidates of all runs."""

    @property
    def best(self) -> float:
        """Least cost of all runs."""

    @property
    def best_run(self) -> str:
        """Its name."""

    @property
    def training(self) -> TrainingProgress | None:
        """That of the run `best_run`, where runs are trainings."""


AnyProgress = Progress | TrainingProgress | SweepProgress


class TensorBoard:
    """What `progress` of `optimize`, `sweep` and `learn` may be given: it writes what it is told into a folder.

    `tensorboard --logdir FOLDER` draws it, while the work goes on and later. A search has a point a generation over the
    candidates evaluated, a training one an iteration over the decisions made, a sweep one whenever a run has ended.

    Example:
        with TensorBoard("runs/first") as board:
            warpmuscle.optimize("fwalk", candidates=1000, progress=board)
    """

    def __init__(self, folder: str | PathLike[str]) -> None:
        """Begin a file in a folder, which is made.

        Raises:
            Error: TensorBoard is not installed, or the file cannot be written.
        """
        place = as_path(folder, "folder")
        need("tensorboard", "files of TensorBoard need")
        from tensorboard.summary.writer.event_file_writer import EventFileWriter

        try:
            place.mkdir(parents=True, exist_ok=True)
            self._writer = EventFileWriter(str(place))
        except OSError as error:
            raise Error(f"{place}: cannot be written: {error.strerror}") from None
        self._mark: Any = None
        self._kept: tuple[int, Mapping[str, float]] | None = None

    def __call__(self, progress: AnyProgress) -> None:
        """Write how far the work has come, where it has come a generation, an iteration or a run further."""
        mark, step, values = points(progress)
        if mark is None:
            return
        if self._kept is not None and mark != self._mark:
            self._write(*self._kept)
        self._mark, self._kept = mark, (step, values)

    def close(self) -> None:
        """Write the last point, and end the file."""
        if self._kept is not None:
            self._write(*self._kept)
        self._kept = None
        self._writer.close()

    def __enter__(self) -> TensorBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write(self, step: int, values: Mapping[str, float]) -> None:
        from tensorboard.compat.proto.event_pb2 import Event
        from tensorboard.compat.proto.summary_pb2 import Summary

        drawn = [Summary.Value(tag=name, simple_value=one) for name, one in values.items() if math.isfinite(one)]
        self._writer.add_event(Event(wall_time=time.time(), step=step, summary=Summary(value=drawn)))
        self._writer.flush()


def points(progress: AnyProgress) -> tuple[Any, int, dict[str, float]]:
    """What tells one point from the next, None for nothing to draw; where it is drawn; and its values by name."""
    if isinstance(progress, Progress):
        stage = f"{progress.stage_name}/" if progress.stages else ""
        if not progress.done:
            return None, 0, {}
        return (progress.stage, progress.generation), progress.done, {
            f"{stage}least cost": progress.best, f"{stage}median cost": progress.median,
            "simulated seconds": progress.simulated,
        }  # fmt: skip
    if isinstance(progress, TrainingProgress):
        if not progress.iterations or progress.compiling:
            return None, 0, {}
        return progress.iterations, progress.decisions, {
            "return": progress.gain, "upright, s": progress.upright, "completed": progress.completed,
            "speed, m per s": progress.speed, "disturbances": progress.hardness, "pushes": progress.pushed,
            "decisions a second": progress.rate,
        }  # fmt: skip
    if progress.training is not None:
        mark, step, values = points(progress.training)
        return (
            mark and (progress.best_run, mark),
            step,
            {f"{progress.best_run}/{name}": v for name, v in values.items()},
        )
    if not progress.evaluated:
        return None, 0, {}
    return progress.ended, progress.evaluated, {"least cost": progress.best, "runs ended": float(progress.ended)}
