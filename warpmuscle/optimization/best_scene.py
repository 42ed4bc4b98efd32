"""The scene of a result with its best parameters: to go on with, or as its motion was made."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np

from warpmuscle.core.arguments import as_integer, as_kind, as_texts
from warpmuscle.core.errors import ResultError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import toml
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.results.brief import check_complete
from warpmuscle.results.records import Result
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import constant, free_parameters, pinned, start_values, substitute, with_values
from warpmuscle.scene.stage_scene import stage_scene


def recorded_scene(result: Result) -> Scene:
    """The scene of a result without free parameters, with the values that its motion was made with."""
    scene, best = scene_in(result), result.best
    if best is not None and result.evaluations is not None:
        stage = int(result.evaluations.stage[best.index])
        with constant([scene]):
            scene = stage_scene(scene, stage, np.asarray(best.params, dtype=np.float64))
    with constant([scene]):
        return substitute(scene, start_values(scene))


def named(result: Result) -> str:
    """What errors call the text of the scene of a result."""
    return f"{result.file}, its scene" if result.file else toml.TEXT


def scene_in(result: Result) -> Scene:
    """The scene of a result, found to be the one that its tables are of.

    Raises:
        SceneError: it cannot be used. ResultError: its parameters, stages or terms are others.
    """
    scene, found = toml.loads(result.scene, name=named(result)), result.evaluations
    if found is None:
        return scene
    if tuple(parameter.name for parameter in free_parameters(scene)) != result.parameters.name:
        raise ResultError("damaged result file: its scene has other free parameters than its table of parameters")
    if len(found) and int(found.stage.max()) >= max(len(scene.stages), 1):
        raise ResultError(f"damaged result file: its scene has no stage {found.stage.max()}")
    for name in found.term_names:
        if name not in (*TERMS, *scene.objective.custom, *scene.objective.reported):
            raise ResultError(f"damaged result file: its objective has no term {name!r}")
    return scene


def best_scene(result: Result, fixed: Sequence[str] = (), among: int | None = None) -> tuple[Scene, str]:
    """The scene of an optimisation with the parameters of its best candidate.

    Args:
        fixed: patterns of names, such as "character.*", of parameters that are to be free no more.
        among: of so many best candidates the one that holds up best, see `robust_selection`; else of least cost.

    Returns:
        The scene, and in words how its numbers were found.

    Raises:
        ResultError: there are no candidates, or none to choose among, or no parameter that a pattern means.
    """
    as_kind(Result, result, "result", error=ResultError)
    fixed = as_texts(fixed, "fixed", error=ResultError)
    if among is not None:
        among = as_integer(among, "among", error=ResultError)
    if result.best is None:
        raise ResultError("holds no candidates to choose the best of")
    scene, chosen = scene_in(result), ""
    values, cost = result.best.params, result.best.cost
    if among is not None:
        if result.evaluations is None or scene.stages:
            raise ResultError("the most robust one is chosen among the candidates of a search without stages")
        check_complete(result, "the most robust one cannot be chosen among them")
        from warpmuscle.optimization.robust_selection import RUNS, most_robust  # which simulates

        row, held = most_robust(scene, result.evaluations, among)
        values, cost = result.evaluations.params[row], float(result.evaluations.cost[row])
        chosen = f"; the most robust of the best {among}, upright in {held} of {RUNS} runs"
    best = np.asarray(values, dtype=np.float64)
    names = [parameter.name for parameter in free_parameters(scene)]
    for pattern in fixed:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise ResultError(f"has no free parameter of the name {pattern!r} that could be fixed")
    free = {name for name in names if not any(fnmatchcase(name, pattern) for pattern in fixed)}
    how = f"cost {cost:.6g} after {number_of(result.evaluated, 'candidate')} on {result.device}{chosen}"
    how += f": {result.command}" if result.command else ""
    return pinned(with_values(scene, best), best, free), how


def is_to_walk(result: Result, recorded: Scene | None = None) -> bool:
    """Whether a search was for the walk of a person, by norms, and found something; `recorded`: its scene."""
    if result.best is None or result.evaluations is None:
        return False
    scene = recorded_scene(result) if recorded is None else recorded
    return scene.feet is not None and bool(scene.objective.norms)
