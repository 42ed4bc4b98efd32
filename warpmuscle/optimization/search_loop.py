"""The loop of an optimisation: ask all searches, evaluate, keep, tell; replayed from what is known where it can be."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Interrupted
from warpmuscle.core.interruption import interruption_noticed
from warpmuscle.optimization.evaluation import Generation, GenerationEvaluator, OtherCandidates
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.replay import Replay
from warpmuscle.optimization.unit_cube import from_unit, to_unit
from warpmuscle.results.records import Evaluations, History, Searched, SearchOptions, joined
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.search.batched import Batch, ask_all, tell_all
from warpmuscle.search.search import Search

GIVEN = -1  # number of the search that asks for the scene as given
ROUNDING = 1e-6  # of a parameter's interval: candidates of two machines that are closer, or within a step, are one
INTERRUPTED = "interrupted"  # why it ended, if a KeyboardInterrupt ended it


class SearchLoop:
    """One optimisation from its first generation on.

    What was evaluated before is not evaluated again, but passed to the searches again. They depend on nothing else, so
    that a search that was interrupted goes on as if it had not been.

    On another machine that is not so: linear algebra rounds differently there, and what the searches ask for moves
    away from what was evaluated. There they receive the earlier candidates with their costs in place of their own.

    Attributes:
        tracker: how far it has come.
    """

    def __init__(
        self,
        scene: Scene,
        options: SearchOptions,
        searches: list[Search],
        batches: GenerationEvaluator,
        tracker: Tracker,
        known: Mapping[int, Evaluations] | None = None,
        history: History | None = None,
        elsewhere: int = 0,
    ) -> None:
        """Begin, or begin again.

        Args:
            scene: with free parameters.
            options: when to end.
            searches: that have not been asked anything yet.
            batches: what evaluates. tracker: what counts.
            known: evaluations of earlier, by generation.
            history: of earlier, what the searches are checked by.
            elsewhere: how many of the first generations were asked for on other machines.
        """
        self.tracker = tracker
        self._parameters, self._given = free_parameters(scene), start_values(scene)
        self._start = to_unit(self._parameters, self._given)
        self._options, self._searches, self._batches = options, searches, batches
        self._known, self._elsewhere = known or {}, elsewhere
        self._crc32: dict[tuple[int, int], int] = {}  # of what was asked for earlier, by generation and search
        if history is not None:
            keys = zip(history.generation.tolist(), history.search.tolist(), strict=True)
            self._crc32 = dict(zip(keys, history.asks_crc32.tolist(), strict=True))
        self._done: list[Evaluations] = []
        self._history: list[_Generation] = []
        self._number = 0  # of the generation that comes next

    @property
    def device(self) -> str:
        """On which it evaluates."""
        return self._batches.device

    def keep_motion(self) -> bool:
        """If there is but one generation, record the motion of its candidates, see `BatchEvaluator.keep_motion`."""
        options = self._options
        once = not self._known and options.candidates <= (options.population or 0) * options.searches
        return once and self._batches.keep_motion(options.candidates)

    def motion(self, values: Floats) -> Replay | None:
        """See `BatchEvaluator.motion`."""
        return self._batches.motion(values)

    def run(self, keep: Callable[[Evaluations], None]) -> str:
        """Go on to the end.

        Args:
            keep: gets what was evaluated of every generation that was not known before, the last one perhaps in part.

        Returns:
            Why it ended.

        Raises:
            Error: interrupted before it has come beyond what is known; OtherCandidates: the searches ask for others.
        """
        try:
            # Raised anywhere, an interruption may be swallowed, as in a `__del__`, or leave a lock held.
            with interruption_noticed() as self.tracker.interrupted:
                ended = self._to_the_end(keep)
                self.tracker.heed()
                return ended
        except KeyboardInterrupt:
            if len(self._done) <= max(self._known, default=-1):
                raise Interrupted(
                    "interrupted before the search was where it had been; its file is unchanged"
                ) from None
            return INTERRUPTED

    def _to_the_end(self, keep: Callable[[Evaluations], None]) -> str:
        self.tracker.begun()
        while not (ended := self._why_ended()) or self._number in self._known:
            self.tracker.heed()
            if not self._one_generation(keep):
                return self._why_ended()
        return ended

    def evaluations(self) -> Evaluations:
        """All candidates so far."""
        nobody = np.zeros(0, dtype=np.int32)
        nothing = Generation(0, nobody, np.zeros((0, len(self._parameters))), self._batches.term_names)
        return joined([nothing.evaluations(), *self._done])

    def searched(self, ended: str) -> Searched:
        """How it has gone so far; `ended` says why it goes on no longer."""
        columns: dict[str, Any] = {}
        for name in _Generation._fields:
            whole = name in ("generation", "search", "asks_crc32")
            columns[name] = np.array([getattr(one, name) for one in self._history], np.int64 if whole else np.float64)
        history = History(**columns, stage=np.zeros(len(self._history), dtype=np.int64))
        states = tuple(search.state() for search in self._searches)
        return Searched(self._options, ended, history, states, elsewhere=self._elsewhere)

    def _why_ended(self) -> str:
        """Why to end before another batch; empty to go on."""
        options, tracker = self._options, self.tracker
        if options.target is not None and tracker.best <= options.target:
            return "the target is reached"
        if tracker.done >= options.candidates:
            return "all candidates have been evaluated"
        if tracker.is_late(options.until):
            return "the time is up"
        if tracker.stopped:
            return tracker.stopped
        if all(search.finished() for search in self._searches):
            reasons = dict.fromkeys(search.finished() for search in self._searches)
            return f"every search has finished: {', '.join(reasons)}"
        return ""

    def _one_generation(self, keep: Callable[[Evaluations], None]) -> bool:
        """Ask, evaluate, keep and tell; False if only a part could be evaluated, of which nothing is reported."""
        batch = ask_all(self._searches)
        known = self._known.get(self._number)
        generation = self._generation(batch, all_of_it=known is not None)
        if known is not None:
            if self._number < self._elsewhere:
                batch = self._follow(batch, generation, known)
            else:
                self._check(batch)
                generation.recall(known)
            self.tracker.recalled(len(known), float(known.cost.min()))
        count = len(known) if known is not None else 0
        try:
            if not generation.complete:
                left = self._options.candidates - self.tracker.done
                self._batches.evaluate(generation, left, self.tracker, self._why_ended)
        finally:
            self._done.append(generation.evaluations())
            if not generation.complete and len(self._done[-1]) > count:
                keep(self._done[-1])
        if not generation.complete:
            return False
        self._tell(batch, generation)
        if len(self._done[-1]) > count:
            keep(self._done[-1])
        return True

    def _generation(self, batch: Batch, all_of_it: bool) -> Generation:
        """What the searches ask for as one generation; the first one has the scene as given, by their wish or not.

        Args:
            all_of_it: or no more of it than are to be evaluated; those that are known may be anywhere in it.
        """
        search = batch.owner.astype(np.int32)
        given = np.all(batch.candidates == self._start, axis=1)
        extra = self._number == 0 and not given.any()
        count = len(search) if all_of_it else min(len(search), self._options.candidates - self.tracker.done)
        values = from_unit(self._parameters, batch.candidates[:count])
        values[given[:count]] = self._given  # exactly, also where it lies between the steps
        if extra:
            search = np.concatenate([np.array([GIVEN], dtype=np.int32), search])
            values = np.concatenate([self._given[None], values])
        whole = len(values) == len(search)
        return Generation(self._number, search[: len(values)], values, self._batches.term_names, whole)

    def _follow(self, batch: Batch, generation: Generation, known: Evaluations) -> Batch:
        """Put what another machine asked for and evaluated in place of what is asked for here; the batch with it.

        Raises:
            OtherCandidates: a search cannot take it.
        """
        before = generation.values.copy()
        generation.follow(known)
        closeness = [max(p.step, ROUNDING * (p.max - p.min)) for p in self._parameters]
        moved = np.any(np.abs(generation.values - before) > 1.001 * np.array(closeness), axis=1)
        values, moved = generation.values[generation.search != GIVEN], moved[generation.search != GIVEN]
        candidates = batch.candidates.copy()
        candidates[moved] = to_unit(self._parameters, values[moved])
        for index in np.unique(batch.owner):
            if not self._searches[index].follow(candidates[batch.owner == index]):
                raise OtherCandidates(self._number)
        return Batch(candidates, batch.owner)

    def _check(self, batch: Batch) -> None:
        """Raise OtherCandidates if a search asks for others than it did before."""
        for index, asked in _by_search(batch):
            if self._crc32.get((self._number, index), _crc32(asked)) != _crc32(asked):
                raise OtherCandidates(self._number)

    def _tell(self, batch: Batch, generation: Generation) -> None:
        tell_all(self._searches, batch, generation.cost[generation.search != GIVEN])
        for index, asked in _by_search(batch):
            costs = generation.cost[generation.search == index]
            spread = float(np.sqrt(np.mean(np.var(asked, axis=0))))
            sigma = self._searches[index].step_size()
            best, median = float(costs.min()), float(np.median(costs))
            self._history.append(_Generation(self._number, index, best, median, spread, sigma, _crc32(asked)))
        self.tracker.next_generation(float(np.median(generation.cost)))
        self._number += 1


def _by_search(batch: Batch) -> list[tuple[int, Floats]]:
    """Numbers of the searches with what each of them asks for."""
    return [(int(index), batch.candidates[batch.owner == index]) for index in np.unique(batch.owner)]


class _Generation(NamedTuple):
    """A row of `History`."""

    generation: int
    search: int
    best: float
    median: float
    spread: float
    sigma: float
    asks_crc32: int


def _crc32(asked: Floats) -> int:
    return zlib.crc32(np.ascontiguousarray(asked, dtype=np.float64).tobytes())
