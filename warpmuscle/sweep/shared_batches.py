"""Optimisations side by side, whose candidates are simulated in batches that they share."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, Interrupted
from warpmuscle.core.interruption import interruption_noticed
from warpmuscle.core.status import Status
from warpmuscle.optimization.evaluation import BatchEvaluator, Generation
from warpmuscle.optimization.options import MakeBatches
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.sweep.pruning.scheduler import Verdict
from warpmuscle.sweep.union import MergedScene

Job = Callable[[MakeBatches], None]
Asked = tuple["Request", NDArray[np.intp]]  # and rows of its generation
Keep = Callable[[Sequence[Asked]], None]


def run_in_one_batch(
    scenes: Sequence[Scene],
    jobs: Sequence[Job],
    device: str | None,
    threads: int | None,
    tell: Callable[[Progress], None] | None = None,
) -> list[Error | None]:
    """Run optimisations of scenes of one group (see `union.groups`) side by side.

    Each is the same to the last bit as alone: what it asks for, and what becomes of it, depend on no other.

    Args:
        jobs: one a scene; does all its evaluations with what it is given, and raises KeyboardInterrupt if it was
            interrupted.
        device, threads: see `make_rollout`.
        tell: called several times a second of work.

    Returns:
        What each job raised, if anything.

    Raises:
        KeyboardInterrupt: after every job has been interrupted, too, and has finished.
    """
    if len(jobs) == 1:
        return [_alone(jobs[0], device, threads)]
    return SharedBatches(scenes, device, threads, tell).run(list(enumerate(jobs)))


def _alone(job: Job, device: str | None, threads: int | None) -> Error | None:
    """Run one optimisation, of any scene; what it raised, if anything."""
    try:
        job(lambda scene: BatchEvaluator(scene, device, threads))
    except Interrupted:
        raise KeyboardInterrupt from None
    except Error as error:
        return error
    return None


@dataclass
class Request:
    """What an optimisation wants evaluated; the members are those of `BatchEvaluator.evaluate`."""

    job: int  # number of the optimisation
    index: int  # of its scene
    free: tuple[str, ...]  # names of the parameters that it changes; the others of its scene stay as given
    generation: Generation
    limit: int
    tracker: Tracker
    enough: Callable[[], Any]


class _Worker(threading.Thread):
    """A thread with one optimisation. It runs only within `advance`, so that no two ever run at the same time.

    Attributes:
        request: what it waits for; None at its end. error: what it raised.
        device, largest, at_once, term_names: see `GenerationEvaluator`.
    """

    def __init__(self, job: Job, number: int, index: int, shared: SharedBatches) -> None:
        super().__init__(daemon=True)
        self.device, self.largest, self.term_names = shared.device, shared.largest, shared.term_names
        self.at_once = 0  # they fill a GPU together
        self.request: Request | None = None
        self.error: BaseException | None = None
        self._job, self._number, self._index = job, number, index
        self._free: tuple[str, ...] = ()
        self._go, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._raise: BaseException | None = None

    def advance(self, error: BaseException | None = None) -> None:
        """Let it run up to its next request or its end; the error is raised from its last request.

        An interruption waits until it is back: raised within the locks of `threading`, it would leave one held.
        """
        self._raise = error
        with interruption_noticed() as interrupted:
            if not self.is_alive():
                self.start()
            self._go.release()
            self._back.acquire()
        if interrupted():
            raise KeyboardInterrupt

    def run(self) -> None:
        """See `threading.Thread`."""
        self._go.acquire()
        try:
            self._job(self._evaluator)
        except BaseException as error:
            self.error = error
        finally:
            self.request = None
            self._back.release()

    def _evaluator(self, scene: Scene) -> _Worker:
        """What evaluates candidates of its scene, or of that scene with fewer free parameters."""
        self._free = tuple(parameter.name for parameter in free_parameters(scene))
        return self

    def evaluate(self, generation: Generation, limit: int, tracker: Tracker, enough: Callable[[], Any]) -> None:
        """See `GenerationEvaluator`."""
        self.request = Request(self._number, self._index, self._free, generation, limit, tracker, enough)
        self._back.release()
        self._go.acquire()
        self.request = None
        if self._raise is not None:
            raise self._raise

    def keep_motion(self, candidates: int) -> bool:
        """See `GenerationEvaluator`: batches of several optimisations are not recorded."""
        return False

    def motion(self, values: Floats) -> None:
        """See `GenerationEvaluator`."""


class SharedBatches:
    """Evaluates what several optimisations ask for in common batches.

    Attributes:
        union: their scenes as one. device, largest, term_names: see `GenerationEvaluator`.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        device: str | None,
        threads: int | None,
        tell: Callable[[Progress], None] | None,
        keep: Keep | None = None,
    ) -> None:
        """Prepare.

        Args:
            scenes: of one group, see `union.groups`. device, threads: see `make_rollout`.
            tell: called several times a second of work.
            keep: gets what was evaluated, before those who have asked for it.
        """
        self.union = MergedScene(scenes)
        self._batches = BatchEvaluator(self.union.scene, device, threads)
        self._tell, self._keep = tell, keep
        self.device, self.largest = self._batches.device, self._batches.largest
        self.term_names = self._batches.term_names
        self._names = [tuple(parameter.name for parameter in free_parameters(scene)) for scene in scenes]
        self._starts = [start_values(scene) for scene in scenes]

    def run(
        self, jobs: Sequence[tuple[int, Job]], judge: Callable[[Sequence[int]], Verdict] | None = None
    ) -> list[Error | None]:
        """Run optimisations side by side; see `run_in_one_batch`.

        Args:
            jobs: each with the number of its scene.
            judge: told the numbers of jobs that ask for candidates, says who gets them and who is to end; all get them
                without it.
        """
        workers = [_Worker(job, number, index, self) for number, (index, job) in enumerate(jobs)]
        try:
            for worker in workers:
                worker.advance()
            while waiting := [worker for worker in workers if worker.request is not None]:
                if judge is not None:
                    if any(isinstance(worker.error, KeyboardInterrupt) for worker in workers):
                        raise KeyboardInterrupt  # whose candidates are missing, when its rivals are compared with it
                    by_number = {worker.request.job: worker for worker in waiting if worker.request is not None}
                    verdict = judge(list(by_number))
                    for number in verdict.stop:
                        by_number[number].advance()  # with nothing evaluated, it ends
                    waiting = [by_number[number] for number in by_number if number in verdict.go]
                error: Error | None = None
                try:
                    self.evaluate([worker.request for worker in waiting if worker.request is not None])
                except Error as raised:
                    error = raised
                for worker in waiting:
                    worker.advance(error)
        except BaseException:
            for worker in workers:
                while worker.request is not None:
                    worker.advance(KeyboardInterrupt())
            raise
        errors: list[Error | None] = []
        for worker in workers:
            if worker.error is not None and not isinstance(worker.error, Error):
                raise worker.error
            errors.append(worker.error)
        return errors

    def evaluate(self, requests: Sequence[Request]) -> None:
        """Evaluate all that is asked for, in rounds of at most one batch of each, as each would have it alone."""
        rows = [request.generation.missing()[: max(request.limit, 0)] for request in requests]
        left = list(zip(requests, rows, strict=True))
        begin = 0
        while left := [(one, rows) for one, rows in left if begin < len(rows) and not one.enough()]:
            self._round([(one, rows[begin : begin + self.largest]) for one, rows in left])
            begin += self.largest

    def _round(self, parts: Sequence[Asked]) -> None:
        """Evaluate these rows of these generations."""
        values = [self.union.values(one.index, self._all_values(one, rows)) for one, rows in parts]
        count = sum(map(len, values))
        joint = Generation(0, np.zeros(count, dtype=np.int32), np.concatenate(values), self.term_names)
        try:
            self._batches.evaluate(joint, count, Tracker(count, None, self._tell), lambda: False)
        finally:
            first = 0
            for one, rows in parts:
                _give_back(one.generation, rows, joint, slice(first, first + len(rows)))
                first += len(rows)
            if self._keep is not None:
                self._keep(parts)
        for one, rows in parts:
            generation = one.generation
            one.tracker.counted(len(rows), float(generation.cost[rows].min()), float(generation.end_time[rows].sum()))

    def _all_values(self, one: Request, rows: NDArray[np.intp]) -> Floats:
        """Values of all free parameters of the scene of a request, (rows, P)."""
        names = self._names[one.index]
        if one.free == names:
            return one.generation.values[rows]
        values = np.tile(self._starts[one.index], (len(rows), 1))
        values[:, [names.index(name) for name in one.free]] = one.generation.values[rows]
        return values


def _give_back(generation: Generation, rows: NDArray[np.intp], joint: Generation, part: slice) -> None:
    """Put what has become of a part of a joint generation into the rows that it stands for."""
    ended = joint.status[part] != Status.RUNNING
    for name in ("cost", "end_time", "terms", "status"):
        getattr(generation, name)[rows[ended]] = getattr(joint, name)[part][ended]
