"""Optimisation of a scene's free parameters: searches ask for candidates, batches of simulations evaluate them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace as changed
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.arguments import as_number, as_path, as_text, as_truth, as_whole, check_function
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, Interrupted, ResultError, ResumeWarning
from warpmuscle.core.limits import check_size
from warpmuscle.core.machine import in_words, this_machine
from warpmuscle.formats import SceneLike, scene_of, toml
from warpmuscle.model.unused_parameters import check_used
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.optimization.curriculum import Curriculum
from warpmuscle.optimization.evaluation import BatchEvaluator, Evaluator, OtherCandidates
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.optimization.replay import Replayer
from warpmuscle.optimization.search_loop import INTERRUPTED, SearchLoop
from warpmuscle.optimization.stages import plan, prolonged, searches_of, with_population
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.records import (
    ANY_NUMBER,
    Evaluations,
    Options,
    ParameterTable,
    Result,
    Searched,
    Staged,
    best_of,
    version_of,
)
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import Parameter, free_parameters, start_values
from warpmuscle.scene.stage_scene import stage_scene
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.batch_input import checked_threads
from warpmuscle.simulation.devices import find_devices

GREATEST_SEED = 2**63 - 1  # that a result file can hold
Tell = Callable[[Progress], None]
MakeBatches = Callable[[Scene], Evaluator]


def optimize(
    scene: SceneLike,
    candidates: int | None = 5000,
    seed: int = 1,
    device: str | None = None,
    *,
    search: str = "random",
    searches: int = 1,
    population: int | None = None,
    sigma: float | None = None,
    restarts: str = "none",
    until: float | None = None,
    target: float | None = None,
    output: str | Path | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    batches: MakeBatches | None = None,
    trust: bool = False,
) -> Result:
    """Search for the values of the scene's free parameters that have the least cost.

    The first generation has the scene as it is among its candidates. A KeyboardInterrupt ends the search; what was
    evaluated by then is returned. The result depends on neither threads nor the size of batches.

    A scene with stages is searched stage by stage, each from the best candidate of the one before. Costs of different
    stages cannot be compared: the best candidate is that of the last stage that has any, and its motion that of the
    scene as it is in that stage. What the options mean for stages is said in `stages.plan`.

    Args:
        scene: with free parameters; or its name or file.
        candidates: how many to evaluate, in all searches and stages together; None for any number, with `until`.
        seed: of the searches; the same seed gives the same result on the same kind of device, processor and BLAS.
        device: see `make_rollout`. threads: CPU threads, by default one a core.
        search: the strategy, see `search.strategies`.
        searches: how many independent ones at the same time, all in the same batches.
        population: candidates a generation of each search; by default the strategy's own.
        sigma: first step size, as a part of each parameter's interval; by default the strategy's own.
        restarts: how a search that has converged begins again, see `search.strategies`.
        until: s of wall time after which no other batch begins.
        target: cost at which to end.
        output: result file to keep while the search goes on, so that `resume` can continue it after a kill or a
            failure at any moment; a file of that name is replaced.
        command: put into the result as what made it.
        progress: called several times a second of work.
        batches: makes what evaluates a scene, or one of its stages, in place of device and threads; by default
            batches of this optimisation's own.
        trust: let code run that the scene names; not needed where `load` was told so.

    Raises:
        Error: the scene has no free parameters, or one that nothing uses, an option is impossible, the output cannot
            be written, or the search was interrupted before any candidate had ended.
    """
    scene, options = scene_of(scene, trust=trust), Options(search, searches, population, sigma, restarts)
    seed = as_whole(seed, "seed", 0, GREATEST_SEED)
    file = None if output is None else as_path(output, "output")
    _check_rest(device, threads, command, progress, batches)
    if candidates is None and until is None:
        raise Error("without a number of candidates a search needs a time to end at: until")
    count = ANY_NUMBER if candidates is None else candidates
    options = check_options(changed(options, candidates=count, until=until, target=target))
    parameters = _parameters(scene)
    check_used(scene)
    stages: tuple[Staged, ...] = ()
    if scene.stages:
        check_scene(scene)
        options, stages = plan(scene, options)
    tracker = Tracker(options.candidates, options.until, progress)
    batches = batches or (lambda part: BatchEvaluator(part, device, threads))
    search_loop = _search_loop(scene, seed, options, stages, batches, tracker)
    start = Result(
        scene=toml.dumps(scene),
        device=search_loop.device,
        command=command,
        seed=seed,
        parameters=parameter_table(parameters),
        evaluations=search_loop.evaluations(),
        searched=search_loop.searched(""),
    )
    if file is None:
        player = _player(scene, search_loop)
        return _finished(scene, search_loop, start, search_loop.run(lambda generation: None), player)
    with Checkpoint.begin(file, start) as checkpoint:
        return _kept(scene, search_loop, start, checkpoint)


def resume(
    path: str | Path,
    candidates: int | None = None,
    device: str | None = None,
    *,
    until: float | None = None,
    target: float | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    batches: MakeBatches | None = None,
    trust: bool = False,
) -> Result:
    """Go on with a search that was interrupted or killed, or has come to its end, as if it had not been.

    Scene, seed and options are those of the file; what it holds is not evaluated again. In a search with stages the
    last one gets the candidates that are asked for besides. A random search goes on with the candidates that it would
    have had, in generations as large as those it began with. On another processor, or with another BLAS, it goes on
    from what was evaluated, with a ResumeWarning that says so: what is asked for then is not the same to the bit. The
    same warning tells of a search that another version of this program began.

    Args:
        path: result file of `optimize(output=...)`, which is kept up further.
        candidates: how many more to evaluate; by default any number with `until`, else what is left of those asked for
            first.
        device: by default that of the file; on one of another kind costs differ in their last bits.
        until: s of wall time from now, by default as many as at first.
        target: cost at which to end, of the last stage if there are any; by default the one asked for.
        threads, progress, batches, trust: as in `optimize`. command: put into the result below the earlier one.

    Raises:
        Error: the file cannot be read or written, holds no search, or was made by versions of this program or its
            libraries that ask for other candidates.
    """
    path = as_path(path, "path")
    candidates = None if candidates is None else as_whole(candidates, "candidates")
    until = None if until is None else as_number(until, "until", above=0.0)
    target = None if target is None else as_number(target, "target")
    _check_rest(device, threads, command, progress, batches)
    as_truth(trust, "trust")
    checkpoint, earlier, known = Checkpoint.resume(path)
    with checkpoint:
        assert earlier.searched is not None
        evaluated = sum(map(len, known.values()))
        options = earlier.searched.options
        more = ANY_NUMBER if candidates is None and until is not None else candidates
        options = changed(
            options,
            candidates=options.candidates if more is None else evaluated + more,
            until=options.until if until is None else until,
            target=options.target if target is None else target,
        )
        options = check_options(options)
        scene = scene_of(scene_in(earlier), trust=trust)
        stages = earlier.searched.stages
        if len(stages) != len(scene.stages):
            raise ResultError(f"{path}: damaged result file: its search has other stages than its scene")
        if stages and (more is not None or target is not None):
            stages = prolonged(stages, options, target)
        elsewhere = earlier.searched.elsewhere
        _warn_of_version(path, earlier)
        if _on_another_machine(path, earlier):
            elsewhere = max(known, default=-1) + 1
        tracker = Tracker(options.candidates, options.until, progress)
        batches = batches or (lambda part: BatchEvaluator(part, device or earlier.device, threads))
        search_loop = _search_loop(
            scene, earlier.seed, options, stages, batches, tracker, known, earlier.searched, elsewhere
        )
        commands = "\n".join(filter(None, (earlier.command, command)))
        start = Result(earlier.scene, search_loop.device, commands, earlier.seed, earlier.parameters)
        try:
            return _kept(scene, search_loop, start, checkpoint, elsewhere > earlier.searched.elsewhere)
        except OtherCandidates as error:
            made = ", ".join(f"{name} {version}" for name, version in earlier.versions.items())
            raise ResultError(f"{path}: cannot be continued here: {error}; it was made by {made}") from None


def parameter_table(parameters: list[Parameter]) -> ParameterTable:
    """Free parameters as a result file keeps them."""
    return ParameterTable(
        name=tuple(p.name for p in parameters),
        unit=tuple(p.unit for p in parameters),
        min=np.array([p.min for p in parameters]),
        max=np.array([p.max for p in parameters]),
        step=np.array([p.step for p in parameters]),
        value=np.array([p.value for p in parameters]),
        scale=tuple(p.scale for p in parameters),
    )


def _parameters(scene: Scene) -> list[Parameter]:
    """The free parameters; Error if there is none."""
    parameters = free_parameters(scene)
    if not parameters:
        raise Error(
            "this scene has no free parameters: write a number in it as { value = .., min = .., max = .., step = .. }"
        )
    return parameters


def check_options(options: Options) -> Options:
    """Options as numbers of Python; raise Error for what no strategy has to know."""
    found: dict[str, Any] = {
        "strategy": as_text(options.strategy, "search"),
        "restarts": as_text(options.restarts, "restarts"),
        "candidates": as_whole(options.candidates, "candidates"),
        "searches": as_whole(options.searches, "searches"),
    }
    if options.population is not None:
        found["population"] = as_whole(options.population, "population")
    for name in ("sigma", "until"):
        if (value := getattr(options, name)) is not None:
            found[name] = as_number(value, name, above=0.0)
    check_size("candidates", found["candidates"])
    if options.target is not None:
        found["target"] = as_number(options.target, "target")
    return changed(options, **found)


def _check_rest(device: Any, threads: Any, command: Any, progress: Any, batches: Any) -> None:
    """Raise Error for what no option of a search is."""
    if batches is None:
        find_devices(device)
    checked_threads(threads)
    as_text(command, "command")
    check_function(progress, "progress")
    check_function(batches, "batches")


def _search_loop(
    scene: Scene,
    seed: int,
    options: Options,
    stages: tuple[Staged, ...],
    batches: MakeBatches,
    tracker: Tracker,
    known: dict[int, Evaluations] | None = None,
    earlier: Searched | None = None,
    elsewhere: int = 0,
) -> SearchLoop | Curriculum:
    if stages:
        return Curriculum(scene, seed, options, stages, batches, tracker, known, earlier, elsewhere)
    evaluator = batches(scene)
    options = with_population(options, evaluator.largest)
    searches = searches_of(scene, options, seed)
    history = earlier.history if earlier else None
    return SearchLoop(scene, options, searches, evaluator, tracker, known, history, elsewhere)


def _kept(
    scene: Scene, search_loop: SearchLoop | Curriculum, start: Result, checkpoint: Checkpoint, moved: bool = False
) -> Result:
    """Run, with all generations on the disk as they come.

    Args:
        moved: the files are of another machine: before anything of this one is put down, they must say so.
    """
    first = moved

    def keep(generation: Evaluations) -> None:
        nonlocal first
        if first:
            checkpoint.write(_so_far(search_loop, start))
        else:
            checkpoint.put(generation, search_loop.tracker.done, lambda: _so_far(search_loop, start))
        first = False

    player = _player(scene, search_loop)
    if isinstance(search_loop, Curriculum):
        ended = search_loop.run(keep, lambda: checkpoint.write(_so_far(search_loop, start)))
    else:
        ended = search_loop.run(keep)
    if len(search_loop.evaluations()) == 0:
        checkpoint.finish(_so_far(search_loop, start, ended))
    result = _finished(scene, search_loop, start, ended, player)
    checkpoint.finish(result)
    return result


def _player(scene: Scene, search_loop: SearchLoop | Curriculum) -> Replayer:
    """What replays the best candidate unless all are recorded, made ready while the search runs.

    Not so of stages, whose last is not known yet.
    """
    player = Replayer(scene, search_loop.device)
    if isinstance(search_loop, SearchLoop) and not search_loop.keep_motion():
        search_loop.tracker.meanwhile = player.prepare
    return player


def _warn_of_version(path: Path, earlier: Result) -> None:
    """Warn if another version of this program, whose terms may count otherwise, began a search."""
    began, here = earlier.versions.get("warpmuscle"), version_of("warpmuscle")
    if began != here:
        warnings.warn(
            f"{path}: was begun by warpmuscle {began}; this is {here}, which may count terms otherwise: "
            "costs from now on need not compare with those before",
            ResumeWarning,
            stacklevel=3,
        )


def _on_another_machine(path: Path, earlier: Result) -> bool:
    """Whether a search began with another processor or BLAS, and then warn; files of before do not say."""
    began, here = dict(earlier.machine), this_machine()
    if not began or began == here:
        return False
    warnings.warn(
        f"{path}: began on {in_words(began)}; on {in_words(here)} it goes on from what was evaluated, but asks for "
        "other candidates in their last bits than it would have there",
        ResumeWarning,
        stacklevel=3,
    )
    return True


def _so_far(search_loop: SearchLoop | Curriculum, start: Result, ended: str = "") -> Result:
    evaluations = search_loop.evaluations()
    return changed(start, evaluations=evaluations, best=best_of(evaluations), searched=search_loop.searched(ended))


def _finished(
    scene: Scene, search_loop: SearchLoop | Curriculum, start: Result, ended: str, player: Replayer
) -> Result:
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
