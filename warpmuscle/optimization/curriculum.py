"""A search in stages: one search loop after the other, each from the best candidate of the one before."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from dataclasses import replace as changed

import numpy as np

from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.model.objective import counted_terms
from warpmuscle.optimization.evaluation import GenerationEvaluator
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.search_loop import INTERRUPTED, SearchLoop
from warpmuscle.optimization.stage_rows import StageRows, history_of, joined_history
from warpmuscle.optimization.stages import searches_of, stage_seed, with_population
from warpmuscle.results.records import Evaluations, History, Searched, SearchOptions, Staged, best_of, joined
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.scene.stage_scene import stage_scene


class Curriculum:
    """The stages of one search, used like a `SearchLoop`.

    A stage ends when it has had its candidates or its time, has reached its target, or its searches have finished; the
    next one begins at its best candidate, which is evaluated again in the first generation. Generations are numbered
    through all stages. The wall time asked for is that of all stages: one without a time of its own may take an even
    share of what is left when it begins.

    Stages that are over are not repeated when a search goes on, since what follows depends on their candidates alone.

    Attributes:
        tracker: how far it has come.
    """

    def __init__(
        self,
        scene: Scene,
        seed: int,
        options: SearchOptions,
        stages: Sequence[Staged],
        batches: Callable[[Scene], GenerationEvaluator],
        tracker: Tracker,
        known: Mapping[int, Evaluations] | None = None,
        earlier: Searched | None = None,
        elsewhere: int = 0,
    ) -> None:
        """Begin, or begin again.

        Args:
            scene: checked scene with stages and free parameters.
            seed: of the whole search.
            options: of the whole search.
            stages: what each of them gets, see `stages.plan`.
            batches: makes what evaluates the scene of a stage.
            tracker: what counts.
            known: evaluations of earlier, by generation.
            earlier: how far the search had come then.
            elsewhere: how many of the first generations were asked for on other machines.

        Raises:
            Error: a stage cannot be simulated, or what is known is not of this search.
        """
        self.tracker = tracker
        self._scene, self._seed, self._options, self._stages = scene, seed, options, list(stages)
        self._batches, self._known, self._earlier = batches, known or {}, earlier
        self._elsewhere = elsewhere
        self._names = [parameter.name for parameter in free_parameters(scene)]
        asked = [
            counted_terms(stage_scene(scene, number, start_values(scene)).objective) for number in range(len(stages))
        ]
        every = dict.fromkeys((*TERMS, *scene.objective.custom, *scene.objective.reported))
        self._term_names = tuple(name for name in every if any(name in names for names in asked))
        self._over: dict[int, _Over] = {}  # by stage; those before the current one count
        for number in range(earlier.stage if earlier is not None else 0):
            self._over[number] = self._recalled(number)
        self._now = self._begun(len(self._over))

    @property
    def device(self) -> str:
        """On which it evaluates."""
        return self._now.search_loop.device

    def run(self, keep: Callable[[Evaluations], None], turned: Callable[[], None] = lambda: None) -> str:
        """Go on to the end; see `SearchLoop.run`.

        Args:
            keep: gets what was evaluated of every generation that was not known before.
            turned: called when another stage has begun, to put that down before its first generation.
        """
        try:
            while True:
                now = self._now
                ended = now.search_loop.run(lambda generation: keep(self._now.rows.of_search(generation)))
                if ended == INTERRUPTED or now.rows.stage == len(self._stages) - 1:
                    return ended
                if all_ended := self._why_all_ended():
                    return all_ended
                history = now.rows.search_history(now.search_loop.searched("").history)
                self._over[now.rows.stage] = _Over(now.evaluations(), history, ended)
                self._now = self._begun(now.rows.stage + 1)  # what counts: an interrupt before it undoes all
                turned()
        except KeyboardInterrupt:
            return INTERRUPTED

    def evaluations(self) -> Evaluations:
        """All candidates so far, with all parameters of the scene, and with the terms of all stages."""
        return joined([*(over.evaluations for over in self._before()), self._now.evaluations()])

    def searched(self, ended: str) -> Searched:
        """How it has gone so far; `ended` says why it goes on no longer."""
        before, now, evaluations = self._before(), self._now.search_loop.searched(""), self.evaluations()
        parts = [*(over.history for over in before), self._now.rows.search_history(now.history)]
        stages = tuple(
            changed(stage, ended=before[k].ended if k < len(before) else "", best=best_of(evaluations, k))
            for k, stage in enumerate(self._stages)
        )
        history = joined_history(parts)
        return Searched(self._options, ended, history, now.states, stages, len(before), self._elsewhere)

    def _before(self) -> list[_Over]:
        """The stages that are over."""
        return [self._over[number] for number in range(self._now.rows.stage)]

    def _why_all_ended(self) -> str:
        """Why no other stage begins; empty to go on."""
        if self.tracker.done >= self._options.candidates:
            return "all candidates have been evaluated"
        if self.tracker.is_late(self._options.until):
            return "the time is up"
        return ""

    def _recalled(self, number: int) -> _Over:
        """A stage that was over before."""
        assert self._earlier is not None
        parts = (part for _, part in sorted(self._known.items()) if part.stage[0] == number)
        evaluations = joined([self._nothing(), *parts])
        self.tracker.recalled(len(evaluations), np.inf)
        return _Over(evaluations, history_of(self._earlier.history, number), self._earlier.stages[number].ended)

    def _begun(self, number: int) -> _Now:
        """A stage at its beginning, of which generations may be known."""
        before = joined([self._nothing(), *(self._over[k].evaluations for k in range(number))])
        best = best_of(before)
        values = start_values(self._scene) if best is None else np.asarray(best.params, dtype=np.float64)
        scene = stage_scene(self._scene, number, values)
        batches = self._batches(scene)
        stage = self._stages[number]
        options = with_population(stage.options, batches.largest)
        self._stages[number] = changed(stage, options=options)
        rows = StageRows(
            stage=number,
            first=int(before.generation.max(initial=-1)) + 1,
            values=values,
            columns=np.array([self._names.index(name) for name in stage.free], dtype=np.intp),
            term_names=self._term_names,
            terms=np.array([self._term_names.index(name) for name in batches.term_names], dtype=np.intp),
        )
        self.tracker.next_stage(number, len(self._stages), stage.name, rows.first)
        searches = searches_of(scene, options, stage_seed(self._seed, number))
        known = {k - rows.first: rows.part(part) for k, part in self._known.items() if part.stage[0] == number}
        history = None if self._earlier is None else rows.part_history(self._earlier.history)
        limits = self._limits(number, options)
        elsewhere = max(self._elsewhere - rows.first, 0)
        return _Now(rows, SearchLoop(scene, limits, searches, batches, self.tracker, known, history, elsewhere))

    def _limits(self, number: int, options: SearchOptions) -> SearchOptions:
        """Options of a stage with candidates and wall time counted from the beginning of the whole search."""
        total, tracker = self._options, self.tracker
        last = number == len(self._stages) - 1
        candidates = total.candidates if last else min(tracker.done + options.candidates, total.candidates)
        until, left = options.until, np.inf if total.until is None else total.until - tracker.elapsed
        if until is None:
            until = left / (len(self._stages) - number)
        end = tracker.elapsed + min(until, left)
        return changed(options, candidates=candidates, until=end if np.isfinite(end) else None)

    def _nothing(self) -> Evaluations:
        """No candidates."""
        whole, none = np.zeros(0, dtype=np.int32), np.zeros(0)
        params, terms = np.zeros((0, len(self._names))), np.zeros((0, len(self._term_names)))
        return Evaluations(params, none, whole, none, whole, whole, whole, terms, self._term_names)


@dataclass(frozen=True)
class _Over:
    """A stage that is over."""

    evaluations: Evaluations
    history: History
    ended: str


@dataclass(frozen=True)
class _Now:
    """The current stage."""

    rows: StageRows
    search_loop: SearchLoop

    def evaluations(self) -> Evaluations:
        """Candidates of the stage so far, as of the whole search."""
        return self.rows.of_search(self.search_loop.evaluations())
