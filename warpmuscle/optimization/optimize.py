"""Optimisation of a scene's free parameters: searches ask for candidates, batches of simulations evaluate them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

from warpmuscle.core.arguments import as_integer, as_path, as_truth
from warpmuscle.core.errors import UnusedParameterWarning
from warpmuscle.formats import SceneLike, scene_of, toml
from warpmuscle.model.unused_parameters import in_short, unused_parameters, without
from warpmuscle.optimization.curriculum import Curriculum
from warpmuscle.optimization.evaluation import BatchEvaluator
from warpmuscle.optimization.options import (
    GREATEST_SEED,
    MakeBatches,
    Tell,
    check_options,
    check_other_arguments,
    required_parameters,
)
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.optimization.run import finished, make_player, make_search_loop, run_on_disk
from warpmuscle.optimization.search_loop import SearchLoop
from warpmuscle.optimization.stages import plan
from warpmuscle.optimization.usual_objective import with_usual_objective
from warpmuscle.optimization.usual_search import USUAL, usual_search
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.partial_motion import checked_quantities
from warpmuscle.results.records import ANY_NUMBER, Result, SearchOptions, Staged, parameter_table
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import constant, free_parameters
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.kernel_cache import progress_said


def optimize(
    scene: SceneLike,
    candidates: int | None = None,
    seed: int = 1,
    device: str | None = None,
    *,
    search: str | None = None,
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
    quantities: Sequence[str] | None = None,
    single: bool = False,
) -> Result:
    """Search for the values of the scene's free parameters with the lowest cost.

    A scene that weighs no term is asked for a gait at its speed and little effort, see `usual_objective`. The first
    generation has the scene as it is among its candidates. A KeyboardInterrupt ends the search; what was
    evaluated by then is returned. The result depends on neither threads nor the size of batches.

    Free parameters that nothing uses, such as of muscles at joints that torques drive, stay as given, with an
    UnusedParameterWarning that names them.

    A scene with stages is searched stage by stage, each from the best candidate of the one before. Costs of different
    stages cannot be compared: the best candidate is that of the last stage that has any, and its motion that of the
    scene as it is in that stage. What the options mean for stages is said in `stages.plan`.

    Args:
        scene: with free parameters; or its name or file.
        candidates: how many to evaluate, in all searches and stages together; by default any number with `until`, else
            5000 a search, or on a GPU 100 generations of the usual search.
        seed: of the searches; the same seed gives the same result on the same kind of device, processor and BLAS.
        device: see `make_rollout`. threads: CPU threads, by default one a core.
        search: the strategy, see `search.strategies`; by default what suits the device, see `usual_search`: on a GPU
            islands that fill it, else cma; random for one free parameter alone.
        searches: how many independent ones at the same time, all in the same batches.
        population: candidates a generation of each search; by default the strategy's own.
        sigma: first step size, as a part of each parameter's interval; by default the strategy's own.
        restarts: how a search that has converged begins again, see `search.strategies`.
        until: s of wall time after which no other batch begins; one begins in any case.
        target: cost at which to end.
        output: result file to keep while the search goes on, so that `resume` can continue it after a kill or a
            failure at any moment; a file of that name is replaced.
        command: put into the result as what made it.
        progress: called several times a second of work.
        batches: makes what evaluates a scene, or one of its stages, in place of device and threads; by default
            batches of this optimisation's own.
        trust: let code run that the scene names; not needed where `load` was given it.
        quantities, single: what the output keeps of the motion, as of `write`; what is returned has all of it.

    Raises:
        ArgumentError: an unknown quantity.
        Error: the scene has no free parameters, or none that anything uses, it weighs nothing and has no feet, an
            option is impossible, the output cannot be written, or Ctrl-C came before any candidate had ended.
    """
    scene = scene_of(scene, trust=trust)
    seed = as_integer(seed, "seed", 0, GREATEST_SEED)
    file = None if output is None else as_path(output, "output")
    check_other_arguments(device, threads, command, progress, batches)
    checked_quantities(quantities)
    as_truth(single, "single")
    count = ANY_NUMBER if candidates is None else candidates
    scene = weighed(scene)
    with constant([scene]):  # also while it is looked for what is not used, most often nothing
        scene = searched(scene)
        strategy = USUAL if search is None else search
        options = check_options(SearchOptions(strategy, searches, population, sigma, restarts, count, until, target))
        evaluators = batches or (lambda part: BatchEvaluator(part, device, threads))
        with constant([scene]), progress_said(progress, f"searching {scene.name}", Progress.in_words) as tell:
            options, stages, evaluators = _planned(scene, options, evaluators)
            tracker = Tracker(options.candidates, options.until, tell)
            search_loop = make_search_loop(scene, seed, options, stages, evaluators, tracker)
            start = _nothing_evaluated(scene, search_loop, command, seed)
            if file is None:
                player = make_player(scene, search_loop)
                return finished(scene, search_loop, start, search_loop.run(lambda generation: None), player)
            with Checkpoint.begin(file, start) as checkpoint:
                return run_on_disk(scene, search_loop, start, checkpoint, quantities=quantities, single=single)


def _planned(
    scene: Scene, options: SearchOptions, batches: MakeBatches
) -> tuple[SearchOptions, tuple[Staged, ...], MakeBatches]:
    """The options with what suits the device in place of what was not asked for, stages, and what evaluates them."""
    count = len(free_parameters(scene))
    if scene.stages:
        check_scene(scene)
        return *plan(scene, usual_search(options, count, at_once=0)), batches
    evaluator = batches(scene)
    return usual_search(options, count, evaluator.at_once), (), lambda _: evaluator


def searched(scene: Scene) -> Scene:
    """The scene as it is searched: with an objective, and its unused free parameters as given, with a warning.

    Raises:
        Error: it has no free parameters, or none that anything uses, or it weighs nothing and has no feet.
    """
    scene = weighed(scene)
    return searched_without(scene, unused_parameters(scene))


def weighed(scene: Scene) -> Scene:
    """The scene with an objective and free parameters; raises Error as `searched`."""
    scene = with_usual_objective(scene)
    required_parameters(scene)
    return scene


def searched_without(scene: Scene, unused: list[str]) -> Scene:
    """The scene as it is searched, of which nothing uses these parameters; raises Error if they are all."""
    scene = without(scene, unused)
    if unused:
        said = f"nothing uses {in_short(unused)}: left as given, and not searched for"
        warnings.warn(said, UnusedParameterWarning, stacklevel=4)
    return scene


def _nothing_evaluated(scene: Scene, search_loop: SearchLoop | Curriculum, command: str, seed: int) -> Result:
    """The result of a search that has not begun."""
    return Result(
        scene=toml.dumps(scene),
        device=search_loop.device,
        command=command,
        seed=seed,
        parameters=parameter_table(free_parameters(scene)),
        evaluations=search_loop.evaluations(),
        searched=search_loop.searched(""),
    )
