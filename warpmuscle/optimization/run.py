"""One search from its start to its result, on the disk as it goes or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace as changed

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, Interrupted
from warpmuscle.optimization.curriculum import Curriculum
from warpmuscle.optimization.options import MakeBatches
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.replay import Replayer
from warpmuscle.optimization.search_loop import INTERRUPTED, SearchLoop
from warpmuscle.optimization.stages import searches_of, with_population
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.partial_motion import with_less
from warpmuscle.results.records import Evaluations, Result, Searched, SearchOptions, Staged, best_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values
from warpmuscle.scene.stage_scene import stage_scene


def make_search_loop(
    scene: Scene,
    seed: int,
    options: SearchOptions,
    stages: tuple[Staged, ...],
    batches: MakeBatches,
    tracker: Tracker,
    known: dict[int, Evaluations] | None = None,
    earlier: Searched | None = None,
    elsewhere: int = 0,
) -> SearchLoop | Curriculum:
    """One loop for the whole search, or a curriculum of one for each of its stages.

    Args:
        batches: makes what evaluates candidates of a scene. tracker: receives the progress.
        known: evaluations of earlier, by generation, which are not made again. earlier: the search that they are of.
        elsewhere: how many of the first generations were asked for on other machines.
    """
    if stages:
        return Curriculum(scene, seed, options, stages, batches, tracker, known, earlier, elsewhere)
    evaluator = batches(scene)
    options = with_population(options, evaluator.largest)
    searches = searches_of(scene, options, seed)
    history = earlier.history if earlier else None
    return SearchLoop(scene, options, searches, evaluator, tracker, known, history, elsewhere)


def run_on_disk(
    scene: Scene, search_loop: SearchLoop | Curriculum, start: Result, checkpoint: Checkpoint, moved: bool = False,
    quantities: Sequence[str] | None = None, single: bool = False,
) -> Result:  # fmt: skip
    """Run, with all generations on the disk as they come.

    Args:
        moved: the files are of another machine: before anything of this one is put down, they must say so.
        quantities, single: what the file keeps of the motion, see `partial_motion.reduced`; the result has all of it.
    """
    first = moved

    def keep(generation: Evaluations) -> None:
        nonlocal first
        if first:
            checkpoint.write(_so_far(search_loop, start))
        else:
            checkpoint.put(generation, search_loop.tracker.done, lambda: _so_far(search_loop, start))
        first = False

    player = make_player(scene, search_loop)
    if isinstance(search_loop, Curriculum):
        ended = search_loop.run(keep, lambda: checkpoint.write(_so_far(search_loop, start)))
    else:
        ended = search_loop.run(keep)
    if len(search_loop.evaluations()) == 0:
        checkpoint.finish(_so_far(search_loop, start, ended))
    result = finished(scene, search_loop, start, ended, player)
    checkpoint.finish(with_less(result, quantities, single) if quantities is not None or single else result)
    return result


def make_player(scene: Scene, search_loop: SearchLoop | Curriculum) -> Replayer:
    """What replays the best candidate unless all are recorded, made ready while the search runs.

    Not so of stages, whose last is not known yet.
    """
    player = Replayer(scene, search_loop.device)
    if isinstance(search_loop, SearchLoop) and not search_loop.keep_motion():
        search_loop.tracker.meanwhile = player.prepare
    return player


def _so_far(search_loop: SearchLoop | Curriculum, start: Result, ended: str = "") -> Result:
    evaluations = search_loop.evaluations()
    return changed(start, evaluations=evaluations, best=best_of(evaluations), searched=search_loop.searched(ended))


def finished(scene: Scene, search_loop: SearchLoop | Curriculum, start: Result, ended: str, player: Replayer) -> Result:
    """The result with the motion of its best candidate."""
    result = _so_far(search_loop, start, ended)
    if result.best is None or result.evaluations is None:
        kind = Interrupted if ended == INTERRUPTED else Error
        raise kind(f"{ended} before any candidate had ended: nothing to keep")
    best: Floats = np.asarray(result.best.params, dtype=np.float64)
    if scene.stages:
        scene = stage_scene(scene, int(result.evaluations.stage[result.best.index]), best)
        best, player = start_values(scene), Replayer(scene, result.device)
    recorded = search_loop.motion(best) if isinstance(search_loop, SearchLoop) else None
    motion, parts = recorded or player.replay(best)
    return changed(result, replays=(motion,), parts=parts)
