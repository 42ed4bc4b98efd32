"""Iterations of a learner until there is a reason to end, with what is told and kept meanwhile."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.interruption import interruption_noticed
from warpmuscle.learning.learner import Learner
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.results.learned import CURVE, Learned

SHARE, TRYING = 0.05, 0.25  # of the wall time, that may go into checkpoints, and into trying if the target is met
HOPE = 0.05  # that a policy does better without the noise of its actions
RECENT = 20  # iterations, whose rate is told

Tell = Callable[[TrainingProgress], None]


@dataclass(frozen=True)
class Ends:
    """What a training ends at."""

    iterations: int | None = None  # in all
    until: float | None = None  # s of wall time, of this process
    target: float | None = None  # share of the instances that must last their whole time at the speed wanted


class TrainingLoop:
    """A training that goes on.

    Attributes:
        rows: of the learning curve. elapsed: s of wall time before this process. ended: why; empty while it goes on.
    """

    def __init__(self, learner: Learner, ends: Ends, interval: float, tell: Tell | None) -> None:
        """Prepare.

        Args:
            interval: s of wall time between two checkpoints.
        """
        self.learner, self.ends = learner, ends
        self.rows: list[dict[str, float]] = []
        self.elapsed, self.ended = 0.0, ""
        self._interval, self._tell = interval, tell
        self._begin = self._kept = time.monotonic()
        self._keeping, self._trying, self._tried = 0.0, 0.0, -np.inf
        self._progress: TrainingProgress | None = None
        self._recent: deque[tuple[float, float]] = deque(maxlen=RECENT)

    def run(self, keep: Callable[[], None], meets_target: Callable[[], bool]) -> None:
        """Go on until an end.

        Args:
            keep: puts all on the disk. meets_target: tries whether the policy is as good as is wanted.
        """
        self.ended = self._all_done()  # of what goes on after a kill
        with interruption_noticed() as interrupted:
            while not self.ended:
                row = self.learner.iterate()
                self.rows.append({**row, "wall_time": self.elapsed + self.passed})
                self._report(row)
                self.ended = "interrupted" if interrupted() else self._reason(row, meets_target)
                if not self.ended and self._due():
                    self._keep(keep)

    @property
    def passed(self) -> float:
        """Wall time of this process, s."""
        return time.monotonic() - self._begin

    def curve(self) -> dict[str, np.ndarray]:
        """The learning curve so far, by the names of `CURVE`."""
        return {name: np.array([row[name] for row in self.rows], dtype=np.float64) for name in CURVE}

    def go_on(self, learned: Learned) -> None:
        """Take over the curve of what came before."""
        curve = learned.curve
        count = int(np.searchsorted(curve["iteration"], self.learner.iterations, side="right"))
        self.rows = [{name: float(curve[name][k]) for name in CURVE} for k in range(count)]
        self.elapsed = self.rows[-1]["wall_time"] if self.rows else 0.0

    def _reason(self, row: dict[str, float], meets_target: Callable[[], bool]) -> str:
        """Why it is to end now; empty if it is not."""
        ends = self.ends
        if ends.target is not None and self._may_meet(row, ends.target) and meets_target():
            return "the target is met"
        if ends.until is not None and self.passed >= ends.until:
            return "the time is up"
        return self._all_done()

    def _all_done(self) -> str:
        done = self.ends.iterations is not None and self.learner.iterations >= self.ends.iterations
        return "all iterations are done" if done else ""

    def _may_meet(self, row: dict[str, float], target: float) -> bool:
        """Whether it is worth trying whether the target is met, as often as time allows."""
        return row["completed"] >= target - HOPE and self.passed - self._tried >= self._trying / TRYING

    def tried(self, took: float) -> None:
        """It took so long, s, to find out that the target is not met."""
        self._trying, self._tried = took, self.passed

    def _due(self) -> bool:
        since = time.monotonic() - self._kept
        return since >= self._interval and since * SHARE >= self._keeping

    def _keep(self, keep: Callable[[], None]) -> None:
        begin = time.monotonic()
        keep()
        self._kept = time.monotonic()
        self._keeping = self._kept - begin

    def _report(self, row: dict[str, float]) -> None:
        self._recent.append((self.passed, row["decisions"]))
        if self._tell is None:
            return
        (t0, d0), (t1, d1) = self._recent[0], self._recent[-1]
        done, ends = self.learner.iterations, self.ends
        parts = [done / ends.iterations if ends.iterations else 0.0, self.passed / ends.until if ends.until else 0.0]
        rate = (d1 - d0) / max(t1 - t0, 1e-9)
        self._progress = TrainingProgress(
            done, int(row["decisions"]), min(max(parts), 1.0), rate, row["upright"], row["completed"], row["speed"],
            row["gain"], row["hardness"], row["push_hardness"],
        )  # fmt: skip
        self._tell(self._progress)

    def tell_trying(self) -> None:
        """Tell that it is being tried how good the policy is."""
        if self._tell is not None and self._progress is not None:
            self._tell(replace(self._progress, trying=True))
