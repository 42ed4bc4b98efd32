"""Optimisation of a scene's free parameters: searches ask for candidates, batches of simulations evaluate them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace as changed
from pathlib import Path

import numpy as np

from warpmuscle.campaign import INTERRUPTED, Campaign
from warpmuscle.curriculum import Curriculum
from warpmuscle.errors import Error, Interrupted, ResultError
from warpmuscle.formats import toml
from warpmuscle.generation import Batches, Evaluator, OtherCandidates
from warpmuscle.keeper import Keeper
from warpmuscle.parameters import Parameter, free_parameters, start_values
from warpmuscle.progress import Progress, Tracker
from warpmuscle.records import ANY_NUMBER, Evaluations, Options, ParameterTable, Result, Searched, Staged, best_of
from warpmuscle.replayer import Replayer
from warpmuscle.scene import Scene
from warpmuscle.stage_plan import plan, prolonged, searches_of, settled
from warpmuscle.stage_scene import stage_scene
from warpmuscle.unused import check_used
from warpmuscle.validate import check_scene

Tell = Callable[[Progress], None]
MakeBatches = Callable[[Scene], Evaluator]


def optimize(
    scene: Scene,
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
) -> Result:
    """Search for the values of the scene's free parameters that have the least cost.

    The first generation has the scene as it is among its candidates. A KeyboardInterrupt ends the search; what was
    evaluated by then is returned. The result depends on neither threads nor the size of batches.

    A scene with stages is searched stage by stage, each from the best candidate of the one before. Costs of different
    stages cannot be compared: the best candidate is that of the last stage that has any, and its motion that of the
    scene as it is in that stage. What the options mean for stages is said in `stage_plan.plan`.

    Args:
        scene: with free parameters.
        candidates: how many to evaluate, in all searches and stages together; None for any number, with `until`.
        seed: of the searches; the same seed gives the same result on the same kind of device.
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

    Raises:
        Error: the scene has no free parameters, or one that nothing uses, an option is impossible, the output cannot
            be written, or the search was interrupted before any candidate had ended.
    """
    if candidates is None and until is None:
        raise Error("without a number of candidates a search needs a time to end at: until")
    count = ANY_NUMBER if candidates is None else candidates
    options = Options(search, searches, population, sigma, restarts, count, until, target)
    check_options(options)
    parameters = _parameters(scene)
    check_used(scene)
    stages: tuple[Staged, ...] = ()
    if scene.stages:
        check_scene(scene)
        options, stages = plan(scene, options)
    tracker = Tracker(options.candidates, options.until, progress)
    batches = batches or (lambda part: Batches(part, device, threads))
    campaign = _campaign(scene, seed, options, stages, batches, tracker)
    start = Result(
        scene=toml.dumps(scene),
        device=campaign.device,
        command=command,
        seed=seed,
        parameters=parameter_table(parameters),
        evaluations=campaign.evaluations(),
        searched=campaign.searched(""),
    )
    if output is None:
        player = _player(scene, campaign)
        return _finished(scene, campaign, start, campaign.run(lambda generation: None), player)
    with Keeper.begin(Path(output), start) as keeper:
        return _kept(scene, campaign, start, keeper)


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
) -> Result:
    """Go on with a search that was interrupted or killed, or has come to its end, as if it had not been.

    Scene, seed and options are those of the file; what it holds is not evaluated again. In a search with stages the
    last one gets the candidates that are asked for besides. A random search goes on with the candidates that it would
    have had, in generations as large as those it began with.

    Args:
        path: result file of `optimize(output=...)`, which is kept up further.
        candidates: how many more to evaluate; by default any number with `until`, else what is left of those asked for
            first.
        device: by default that of the file; on one of another kind costs differ in their last bits.
        until: s of wall time from now, by default as many as at first.
        target: cost at which to end, of the last stage if there are any; by default the one asked for.
        threads, progress, batches: as in `optimize`. command: put into the result below the earlier one.

    Raises:
        Error: the file cannot be read or written, holds no search, or was made by versions of this program or its
            libraries that ask for other candidates.
    """
    path = Path(path)
    keeper, earlier, known = Keeper.resume(path)
    with keeper:
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
        check_options(options)
        scene = toml.loads(earlier.scene)
        stages = earlier.searched.stages
        if len(stages) != len(scene.stages):
            raise ResultError(f"{path}: damaged result file: its search has other stages than its scene")
        if stages and (more is not None or target is not None):
            stages = prolonged(stages, options, target)
        tracker = Tracker(options.candidates, options.until, progress)
        batches = batches or (lambda part: Batches(part, device or earlier.device, threads))
        campaign = _campaign(scene, earlier.seed, options, stages, batches, tracker, known, earlier.searched)
        commands = "\n".join(filter(None, (earlier.command, command)))
        start = Result(earlier.scene, campaign.device, commands, earlier.seed, earlier.parameters)
        try:
            return _kept(scene, campaign, start, keeper)
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


def check_options(options: Options) -> None:
    """Raise Error for options that no strategy has to know."""
    for name in ("candidates", "searches", "population", "sigma", "until"):
        value = getattr(options, name)
        if value is not None and not 0 < value < np.inf:
            raise Error(f"{name} must be positive, not {value}")
    if options.target is not None and not np.isfinite(options.target):
        raise Error(f"the target must be a finite cost, not {options.target}")


def _campaign(
    scene: Scene,
    seed: int,
    options: Options,
    stages: tuple[Staged, ...],
    batches: MakeBatches,
    tracker: Tracker,
    known: dict[int, Evaluations] | None = None,
    earlier: Searched | None = None,
) -> Campaign | Curriculum:
    if stages:
        return Curriculum(scene, seed, options, stages, batches, tracker, known, earlier)
    evaluator = batches(scene)
    options = settled(options, evaluator.largest)
    searches = searches_of(scene, options, seed)
    return Campaign(scene, options, searches, evaluator, tracker, known, earlier.history if earlier else None)


def _kept(scene: Scene, campaign: Campaign | Curriculum, start: Result, keeper: Keeper) -> Result:
    """Run, with all generations on the disk as they come."""

    def keep(generation: Evaluations) -> None:
        keeper.put(generation, campaign.tracker.done, lambda: _so_far(campaign, start))

    player = _player(scene, campaign)
    if isinstance(campaign, Curriculum):
        ended = campaign.run(keep, lambda: keeper.write(_so_far(campaign, start)))
    else:
        ended = campaign.run(keep)
    if len(campaign.evaluations()) == 0:
        keeper.finish(_so_far(campaign, start, ended))
    result = _finished(scene, campaign, start, ended, player)
    keeper.finish(result)
    return result


def _player(scene: Scene, campaign: Campaign | Curriculum) -> Replayer:
    """What replays the best candidate unless all are recorded, made ready while the search runs.

    Not so of stages, whose last is not known yet.
    """
    player = Replayer(scene, campaign.device)
    if isinstance(campaign, Campaign) and not campaign.keep_motion():
        campaign.tracker.meanwhile = player.prepare
    return player


def _so_far(campaign: Campaign | Curriculum, start: Result, ended: str = "") -> Result:
    evaluations = campaign.evaluations()
    return changed(start, evaluations=evaluations, best=best_of(evaluations), searched=campaign.searched(ended))


def _finished(scene: Scene, campaign: Campaign | Curriculum, start: Result, ended: str, player: Replayer) -> Result:
    """The result with the motion of its best candidate."""
    result = _so_far(campaign, start, ended)
    if result.best is None or result.evaluations is None:
        kind = Interrupted if ended == INTERRUPTED else Error
        raise kind(f"{ended} before any candidate had ended: nothing to keep")
    best = np.asarray(result.best.params, dtype=np.float64)
    if scene.stages:
        scene = stage_scene(scene, int(result.evaluations.stage[result.best.index]), best)
        best, player = start_values(scene), Replayer(scene, result.device)
    recorded = campaign.motion(best) if isinstance(campaign, Campaign) else None
    motion, parts = recorded or player.replay(best)
    return changed(result, replays=(motion,), parts=parts)
