"""How far an optimisation has come, as its user sees it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.plain_text import number_of
from warpmuscle.results.records import ANY_NUMBER
from warpmuscle.simulation.candidates import CandidateBatch

INTERVAL = 0.05  # s at least between two reports of a batch
TELLING = 0.01  # of the time, that may go into finding out what to tell


@dataclass(frozen=True)
class Progress:
    """How far an optimisation has come."""

    candidates: int  # to be evaluated in all
    done: int  # of them fully evaluated
    alive: int  # still walking in the batch that runs now
    best: float  # least cost so far; infinite before the first candidate has ended
    simulated: float  # s of motion computed so far by this process, summed over instances
    fraction: float  # of all the work, or of the time for it, counting a failed candidate as done, 0..1
    generation: int  # that runs now
    median: float  # cost in the last complete generation; infinite before there is one
    recalled: int  # of those done, evaluated before this process began
    stage: int = 0  # number of the stage that runs now; best and median are of its candidates
    stages: int = 0  # how many there are
    stage_name: str = ""
    compiling: bool = False  # the kernel, for some seconds
    computed: float = 0.0  # part of the time so far in which batches ran, 0..1

    @property
    def limited(self) -> bool:
        """Whether the number of candidates ends it."""
        return self.candidates < ANY_NUMBER

    def in_words(self) -> str:
        """The same, short."""
        of = f"{self.done} of {number_of(self.candidates, 'candidate')}"
        done = of if self.limited else number_of(self.done, "candidate")
        stage = f"stage {self.stage + 1} of {self.stages}, " if self.stages else ""
        best = f", best {self.best:.5g}" if np.isfinite(self.best) else ""
        return f"searching: {stage}{done}{best}"


class Tracker:
    """Keeps count of an optimisation, and tells its user several times a second.

    Attributes:
        meanwhile: called before the kernel is compiled, and again and again while batches run, if there is anything to
            do besides.
        stopped: why the optimisation is to end before its next batch; empty to go on.
        interrupted: whether an interruption has been noticed, which `heed` and `running` raise.
    """

    def __init__(self, candidates: int, until: float | None, tell: Callable[[Progress], None] | None) -> None:
        """Begin at nothing; candidates and until (s of wall time) are what the optimisation ends at."""
        self.done, self.best = 0, np.inf
        self.meanwhile: Callable[[], None] | None = None
        self.stopped = ""
        self.interrupted: Callable[[], bool] = lambda: False
        self._candidates, self._until, self._tell = candidates, until, tell
        self._begin, self._begun = time.monotonic(), False
        self._quiet_until = 0.0
        self._simulated, self._generation, self._median, self._recalled = 0.0, 0, np.inf, 0
        self._computed = 0.0  # s
        self._stage, self._stages, self._stage_name = 0, 0, ""

    @property
    def elapsed(self) -> float:
        """Wall time since the first batch was about to begin, s."""
        return time.monotonic() - self._begin

    def is_late(self, until: float | None) -> bool:
        """Whether this wall time, s, is over; on the slowest machine something has been evaluated by then."""
        return until is not None and self.done > self._recalled and self.elapsed >= until

    def begun(self) -> None:
        """Tell before the first batch, also of a stage."""
        if not self._begun:
            self._begin, self._begun = time.monotonic(), True  # the time for a search is not for preparing it
        self._report(self._now(self.done, 0, self.best, self._simulated, 0.0))

    def compiling(self) -> None:
        """Tell that the kernel is compiled before the batch runs."""
        if self.meanwhile is not None:
            self.meanwhile()
        self._report(replace(self._now(self.done, 0, self.best, self._simulated, 0.0), compiling=True))

    def next_stage(self, stage: int, stages: int, name: str, generation: int) -> None:
        """A stage begins with this generation, and with costs of its own."""
        self._stage, self._stages, self._stage_name, self._generation = stage, stages, name, generation
        self.best = self._median = np.inf

    def recalled(self, count: int, best: float) -> None:
        """So many candidates were evaluated earlier, with this least cost."""
        self.done += count
        self._recalled += count
        self.best = min(self.best, best)

    def counted(self, count: int, best: float, simulated: float) -> None:
        """So many candidates were evaluated, in s of motion, with this least cost."""
        self.done += count
        self.best = min(self.best, best)
        self._simulated += simulated
        self._report(self._now(self.done, 0, self.best, self._simulated, 0.0))

    @contextmanager
    def computing(self) -> Iterator[None]:
        """While the device computes: its share of the time is told."""
        begin = time.monotonic()
        try:
            yield
        finally:
            self._computed += time.monotonic() - begin

    def running(self, trials: CandidateBatch) -> None:
        """Tell of a batch that runs, more rarely where it takes long to find out how far a large one has come.

        Raises:
            KeyboardInterrupt: see `heed`.
        """
        self.heed()
        if self.meanwhile is not None:
            self.meanwhile()
        begin = time.monotonic()
        if self._tell is None or begin < self._quiet_until:
            return
        self._report(self._with(trials))
        took = time.monotonic() - begin
        self._computed -= took  # in which the device waited
        self._quiet_until = begin + max(INTERVAL, took / TELLING)

    def heed(self) -> None:
        """Raise KeyboardInterrupt if an interruption has been noticed."""
        if self.interrupted():
            raise KeyboardInterrupt

    def next_generation(self, median: float) -> None:
        """A generation is complete, with this median cost."""
        self._generation += 1
        self._median = median

    def _with(self, trials: CandidateBatch) -> Progress:
        """Progress with a batch as far as it has come."""
        ended, batch = trials.ended(), trials.batch
        alive = int(np.count_nonzero(~ended))
        costs = trials.cost()[ended]
        part = trials.candidates - alive + alive * batch.time / batch.scene.duration
        best = min(self.best, float(costs.min())) if len(costs) else self.best
        simulated = self._simulated + float(batch.end_time().sum())
        done = min(self.done + trials.candidates - alive, self._candidates)  # a few of a batch may stand for nobody
        return self._now(done, alive, best, simulated, part)

    def _now(self, done: int, alive: int, best: float, simulated: float, part: float) -> Progress:
        """Progress; `part` is what the batch that runs now has done of its candidates."""
        return Progress(
            candidates=self._candidates,
            done=done,
            alive=alive,
            best=best,
            simulated=simulated,
            fraction=self._fraction(part),
            generation=self._generation,
            median=self._median,
            recalled=self._recalled,
            stage=self._stage,
            stages=self._stages,
            stage_name=self._stage_name,
            computed=self._computed / max(self.elapsed, 1e-9),
        )

    def _fraction(self, part: float) -> float:
        fraction = (self.done + part) / self._candidates
        return min(max(fraction, self.elapsed / self._until) if self._until else fraction, 1.0)

    def _report(self, progress: Progress) -> None:
        if self._tell is not None:
            self._tell(progress)
