"""What each stage of a search gets: its part of the candidates, and its own settings or those of the whole search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace as changed
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.optimization.unit_cube import to_unit
from warpmuscle.results.records import SearchOptions, Staged
from warpmuscle.scene import Scene, SearchStage
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.scene.stage_scene import freed, stage_scene
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.search.search import Search
from warpmuscle.search.strategies import make_searches


def plan(scene: Scene, options: SearchOptions) -> tuple[SearchOptions, tuple[Staged, ...]]:
    """The stages of a scene before the search begins.

    - Candidates: those asked for are the total. A stage with a number of its own gets that many, or that part of the
      total; the others share evenly what remains. If all have numbers of their own, their sum is the total. What a
      stage leaves over, because its target was reached, the last stage gets: it takes all that is left then.
    - The time asked for is the total as well, see `Curriculum`.
    - Strategy, searches, population, sigma and restarts: those asked for, unless the stage has its own. The last three
      suit a strategy, so that a stage with a strategy of its own gets them from itself alone, or by default.
    - Target: what was asked for is that of the last stage, unless it has its own, since stages differ in their costs.

    Args:
        scene: checked scene with stages.
        options: what was asked for.

    Returns:
        The options with the total, and the stages.

    Raises:
        Error: a stage would get no candidates, or cannot have these settings.
    """
    counts = _shared(scene.stages, options.candidates)
    staged = []
    for index, (stage, count) in enumerate(zip(scene.stages, counts, strict=True)):
        last = index == len(counts) - 1
        target = options.target if last and stage.target is None else stage.target
        own = changed(_settings(stage, options), candidates=count, until=stage.until, target=target)
        part = stage_scene(scene, index, start_values(scene))
        try:
            check_scene(part)
            searches_of(part, own, seed=0)
        except Error as error:
            raise Error(f"stage {stage.name!r}: {error}") from None
        staged.append(Staged(stage.name, freed(scene, stage), own))
    return changed(options, candidates=sum(counts)), tuple(staged)


def prolonged(stages: Sequence[Staged], options: SearchOptions, target: float | None) -> tuple[Staged, ...]:
    """The stages when the search has another total: the last one gets what the others leave.

    Args:
        stages: as planned at first. options: with the new total.
        target: of the last stage, None for the one that it had.
    """
    *others, last = stages
    count = max(options.candidates - sum(stage.options.candidates for stage in others), 0)
    target = last.options.target if target is None else target
    return (*others, changed(last, options=changed(last.options, candidates=count, target=target)))


def searches_of(scene: Scene, options: SearchOptions, seed: int) -> list[Search]:
    """Searches for the free parameters of a scene, from their values; raises Error, see `make_searches`."""
    parameters = free_parameters(scene)
    start: Floats = to_unit(parameters, start_values(scene))
    return make_searches(
        options.strategy, len(parameters), start, seed, options.searches,
        population=options.population, sigma=options.sigma, restarts=options.restarts,
    )  # fmt: skip


def with_population(options: SearchOptions, largest: int) -> SearchOptions:
    """The options with the generations of a random search as large as a batch (candidates), unless they say.

    Those of a search that is over in one batch have no more candidates than it asks for.
    """
    if options.strategy != "random" or options.population is not None:
        return options
    return changed(options, population=max(-(-min(largest, options.candidates) // options.searches), 1))


def stage_seed(seed: int, number: int) -> int:
    """The seed of a stage's searches: that of the whole search for the first, independent ones for the others."""
    return seed if number == 0 else int(np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)[0] >> 1)


def _shared(stages: Sequence[SearchStage], total: int) -> list[int]:
    """Candidates of each stage."""
    own = [None if stage.candidates is None else _count(stage.candidates, total) for stage in stages]
    rest = total - sum(count or 0 for count in own)
    without = own.count(None)
    if rest < without:
        raise Error(
            f"the stages need {number_of(total - rest + without, 'candidate')} at least; there are to be {total} in all"
        )
    shares = iter([rest // without + (k < rest % without) for k in range(without)] if without else ())
    counts = [next(shares) if count is None else count for count in own]
    if not without and rest < sum(1 for stage in stages if stage.candidates is not None and stage.candidates < 1.0):
        counts[-1] += rest  # what the parts lost when they were rounded
    return counts


def _count(candidates: float, total: int) -> int:
    """A stage's own number of candidates; a part of the total is rounded down, but to one at least."""
    return int(candidates) if candidates >= 1.0 else max(int(candidates * total + 1e-9), 1)


def _settings(stage: SearchStage, options: SearchOptions) -> SearchOptions:
    """The options of a stage but for its parts and its target."""
    if stage.strategy is not None:
        options = changed(options, strategy=stage.strategy, population=None, sigma=None, restarts="none")
    names = ("population", "sigma", "restarts", "searches")
    own: dict[str, Any] = {name: value for name in names if (value := getattr(stage, name)) is not None}
    return changed(options, **own)
