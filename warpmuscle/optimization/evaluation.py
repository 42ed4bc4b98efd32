"""One generation of candidates: asked for by searches, evaluated in batches, some of it perhaps known from before."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error, UserPartWarning
from warpmuscle.core.status import Status
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.replay import Replay
from warpmuscle.results.records import Evaluations
from warpmuscle.scene import Scene
from warpmuscle.simulation.candidates import CandidateBatch
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.memory import instances_that_fit

CPU_BATCH = 500  # small enough that finished candidates come in all along
GPU_BATCH = 65536
_KEPT = 2  # sizes of batches that are kept ready: full ones and the rest
_SPARE = 1.1  # as large as this is a batch for fewer candidates, or as what a GPU runs at once, and takes no longer
_RECORDED = 0.25  # of a GPU's free memory, at most, takes the motion of all candidates of a search of one batch


class OtherCandidates(Error):
    """A search that is repeated asks for other candidates than it did before."""

    def __init__(self, generation: int) -> None:
        super().__init__(f"generation {generation} of the search asks for other candidates than were evaluated")


class Generation:
    """The candidates of one generation, n rows, and what has become of them.

    If the search ends within it, these are only the first ones, as many as are to be evaluated.

    Attributes:
        number: of the generation.
        search: (n,), number of the search that asked for a row, -1 for the scene as it is.
        values: (n, P), of the parameters.
        cost: (n,). status: (n,), `RUNNING` where a row is yet to be evaluated. end_time: (n,), s. terms: (n, T).
    """

    def __init__(
        self, number: int, search: Integers, values: Floats, term_names: tuple[str, ...], whole: bool = True
    ) -> None:
        """Nothing is evaluated yet; `whole`: these are all of its candidates."""
        count, self._whole = len(values), whole
        self.number, self.search, self.values, self.term_names = number, search, values, term_names
        self.cost, self.end_time, self.terms = np.zeros(count), np.zeros(count), np.zeros((count, len(term_names)))
        self.status = np.full(count, Status.RUNNING, dtype=np.int32)

    @property
    def complete(self) -> bool:
        """Whether all of its candidates have been evaluated."""
        return self._whole and bool(np.all(self.status != Status.RUNNING))

    def ended(self, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Which of these rows have been evaluated."""
        found: NDArray[np.bool_] = self.status[rows] != Status.RUNNING
        return found

    def missing(self) -> NDArray[np.intp]:
        """Rows that are yet to be evaluated, in order."""
        return np.flatnonzero(self.status == Status.RUNNING)

    def evaluations(self) -> Evaluations:
        """The rows that have been evaluated, in order."""
        numbers = np.full(len(self.values), self.number, dtype=np.int32)
        stage = np.zeros(len(self.values), dtype=np.int32)
        whole = Evaluations(
            self.values, self.cost, self.status, self.end_time, self.search, numbers, stage, self.terms, self.term_names
        )
        return whole.rows(self.status != Status.RUNNING)

    def recall(self, known: Evaluations) -> None:
        """Take over what was evaluated before, a part of these candidates in the same order.

        Raises:
            OtherCandidates: they are others.
        """
        rows = _places(np.asarray(known.params, dtype=np.float64), self.values)
        if rows is None or np.any(known.search != self.search[rows]):
            raise OtherCandidates(self.number)
        self._take_over(known, rows)

    def follow(self, known: Evaluations) -> None:
        """Take over what was evaluated before on another machine, each in place of the nearest of these candidates.

        Raises:
            OtherCandidates: there are more of a search than it asks for here.
        """
        rows = np.zeros(len(known), dtype=np.intp)
        for number in np.unique(known.search):
            mine, theirs = np.flatnonzero(self.search == number), np.flatnonzero(known.search == number)
            if len(theirs) > len(mine):
                raise OtherCandidates(self.number)
            rows[theirs] = mine[_nearest(np.asarray(known.params[theirs], dtype=np.float64), self.values[mine])]
        self.values[rows] = known.params
        self._take_over(known, rows)

    def _take_over(self, known: Evaluations, rows: NDArray[np.intp]) -> None:
        if known.term_names != self.term_names:
            raise OtherCandidates(self.number)
        self.cost[rows], self.status[rows], self.end_time[rows] = known.cost, known.status, known.end_time
        self.terms[rows] = known.terms

    def take(self, rows: NDArray[np.intp], trials: CandidateBatch) -> None:
        """Take what has ended of the trials, the first of which evaluate these rows."""
        ended, outcomes = np.flatnonzero(trials.ended()[: len(rows)]), trials.outcomes()
        rows = rows[ended]
        self.cost[rows], self.end_time[rows] = outcomes.cost[ended], outcomes.end_time[ended]
        for index, values in enumerate(outcomes.terms.values()):
            self.terms[rows, index] = values[ended]
        self.status[rows] = outcomes.status[ended]


class GenerationEvaluator(Protocol):
    """What evaluates the generations of one optimisation.

    Attributes:
        device: on which. largest: number of candidates in a batch. term_names: of the objective's terms.
        at_once: candidates that a GPU computes in the time of one; 0 for a CPU.
    """

    device: str
    largest: int
    at_once: int
    term_names: tuple[str, ...]

    def evaluate(self, generation: Generation, limit: int, tracker: Tracker, enough: Callable[[], Any]) -> None:
        """See `BatchEvaluator.evaluate`."""

    def keep_motion(self, candidates: int) -> bool:
        """See `BatchEvaluator.keep_motion`."""

    def motion(self, values: Floats) -> Replay | None:
        """See `BatchEvaluator.motion`."""


class BatchEvaluator:
    """Evaluates generations of any size on a device, in batches of a size that suits it.

    What a candidate becomes does not depend on its batch, so neither does it on how many there are.
    """

    def __init__(self, scene: Scene, device: str | None, threads: int | None) -> None:
        """Prepare; see `make_rollout` for device and threads, and for what it raises."""
        self._scene, self._threads = scene, threads
        first = CandidateBatch(scene, 1, device, threads=threads)
        self.device = str(first.batch.device)
        self.largest = max(_suiting(device, first) // first.runs, 1)
        self.at_once = min(first.batch.at_once // first.runs, self.largest)
        self._loaded = False
        self._reported: set[str] = set()  # of the causes that ended candidates
        self.term_names = tuple(first.batch.terms())
        self._first, self._trials = first, {1: first}
        self._recorded = False
        self._values: Floats = np.zeros((0, len(first.batch.parameters)))

    def evaluate(self, generation: Generation, limit: int, tracker: Tracker, enough: Callable[[], Any]) -> None:
        """Evaluate what is missing of a generation.

        Args:
            generation: takes the outcomes, also those that have ended when an exception such as KeyboardInterrupt
                comes from `tracker`.
            limit: of so many candidates at most.
            tracker: receives the progress.
            enough: asked before every batch; true ends it.
        """
        rows = generation.missing()[: max(limit, 0)]
        for begin in range(0, len(rows), self.largest):
            if enough():
                return
            part = rows[begin : begin + self.largest]
            trials = self._of_size(len(part))
            self._values = generation.values[part]
            trials.set_parameters(_filled(self._values, trials.candidates))
            self._load(trials, tracker)
            try:
                with tracker.computing():
                    trials.run(progress=tracker.running)
            finally:
                trials.run(0.0)  # no further, but those at their end have come to it, also after an exception
                generation.take(part, trials)
            self._warn(trials)
            simulated = float(trials.batch.end_time()[: len(part) * trials.runs].sum())
            tracker.counted(len(part), float(generation.cost[part].min()), simulated)

    def _warn(self, trials: CandidateBatch) -> None:
        """Tell, once each, of the scene's own parts that ended candidates."""
        for cause in sorted({*trials.batch.causes()} - {""} - self._reported):
            self._reported.add(cause)
            warnings.warn(f"candidates have failed because {cause}", UserPartWarning, stacklevel=2)

    def keep_motion(self, candidates: int) -> bool:
        """Record the motion of all candidates if so many have room for it in one batch, and say whether they have.

        It takes hardly any time on a GPU, while to replay the best of them, alone, takes as long as a small search.
        """
        self._recorded = candidates <= min(_recordable(self._first), self.largest)
        if self._recorded:
            self._trials.clear()  # of a candidate that was not
        return self._recorded

    def motion(self, values: Floats) -> Replay | None:
        """The candidate of the last batch with these values, (P,), if it was recorded."""
        same = (self._values == values).all(axis=1)
        if not self._recorded or not same.any():
            return None
        batch, row = self._of_size(len(same)).batch, int(same.argmax())
        return batch.recording(row), batch.parts(row)

    def _of_size(self, candidates: int) -> CandidateBatch:
        """Trials of so many candidates, made now unless there are such; on a GPU some more serve as well."""
        most = candidates if self.at_once == 0 or self._recorded else max(int(candidates * _SPARE), self.at_once)
        candidates = min((size for size in self._trials if candidates <= size <= most), default=candidates)
        trials = self._trials.pop(candidates, None)
        while len(self._trials) >= _KEPT:
            del self._trials[next(iter(self._trials))]
        if trials is None:
            trials = self._made(candidates)
        self._trials[candidates] = trials  # the last ones used come last
        return trials

    def _made(self, candidates: int) -> CandidateBatch:
        """New trials; those recorded with the lanes of one candidate: most fall soon, and the last take the time."""
        if not self._recorded:
            return CandidateBatch(self._scene, candidates, self.device, threads=self._threads)
        lanes, threads = self._first.batch.lanes, self._threads
        return CandidateBatch(self._scene, candidates, self.device, record=True, threads=threads, lanes=lanes)

    def _load(self, trials: CandidateBatch, tracker: Tracker) -> None:
        """Have the kernel ready, and tell before if that takes a while."""
        if not self._loaded:
            if trials.batch.compiles:
                tracker.compiling()
            trials.batch.load()
            self._loaded = True


def _suiting(device: str | None, trials: CandidateBatch) -> int:
    """Simulations in a batch that suits the devices: as many as keep them busy, and as fit into their memory."""
    devices = find_devices(device)
    usual = CPU_BATCH if devices[0].is_cpu else GPU_BATCH
    # What an instance takes is found out by two more models, and not needed where there is room for more than that.
    fitting = _fitting(devices, trials.batch.held_bytes)
    if any(count is not None and count < usual for count in fitting):
        fitting = _fitting(devices, trials.batch.instance_bytes.total)
    return len(devices) * min([usual, *(count for count in fitting if count is not None)])


def _fitting(devices: Sequence[Any], bytes_an_instance: int) -> list[int | None]:
    """How many such instances each of these devices has memory for, as often as batches are kept."""
    return [instances_that_fit(_KEPT * bytes_an_instance, single) for single in devices]


def _recordable(trials: CandidateBatch) -> int:
    """How many candidates there is room for on a GPU with all of their motion; none where it is quicker to replay."""
    device, *others = trials.batch.devices
    if others or device.is_cpu or not trials.undisturbed:
        return 0
    return int(_RECORDED * (instances_that_fit(trials.batch.recording_bytes, device) or 0))


def _filled(values: Floats, count: int) -> Floats:
    """Values of so many candidates, the last of which stand for nobody."""
    return values[np.minimum(np.arange(count), len(values) - 1)] if count > len(values) else values


def _places(part: Floats, whole: Floats) -> NDArray[np.intp] | None:
    """Rows of `whole` that hold those of `part`, in the same order; None if some row is in none that is left."""
    if part.shape == whole.shape and np.array_equal(part, whole):
        return np.arange(len(whole))
    places: list[int] = []
    if part.shape[1:] == whole.shape[1:]:
        for row, values in enumerate(whole):
            if len(places) < len(part) and np.array_equal(part[len(places)], values):
                places.append(row)
    return np.array(places, dtype=np.intp) if len(places) == len(part) else None


def _nearest(part: Floats, whole: Floats) -> NDArray[np.intp]:
    """For each row of `part` one of `whole`, each for one only; with as many rows in both, they stay in their order."""
    if len(part) == len(whole):
        return np.arange(len(whole))
    scale = np.maximum(np.ptp(whole, axis=0), np.finfo(float).tiny)
    free, places = np.ones(len(whole), dtype=bool), np.zeros(len(part), dtype=np.intp)
    for index, values in enumerate(part):
        distance = np.sum(((whole - values) / scale) ** 2, axis=1)
        places[index] = int(np.argmin(np.where(free, distance, np.inf)))
        free[places[index]] = False
    return places
