"""The scene of one stage of a search: what the stage says put in place of what the whole scene says."""

from __future__ import annotations

import fnmatch

import msgspec

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Scene, SearchStage
from warpmuscle.scene.parameters import free_parameters, pinned, start_values

_HOW = ("candidates", "strategy", "population", "sigma", "restarts", "searches", "until", "target")


def freed(scene: Scene, stage: SearchStage) -> tuple[str, ...]:
    """Names of the scene's free parameters that a stage may change, in their order.

    Those are the ones that any of its patterns matches, but not numbers in place of which the stage has its own.
    """
    own = {f"objective.{name}" for name in stage.objective} | {f"failure.{name}" for name in stage.failure}
    names = (parameter.name for parameter in free_parameters(scene))
    return tuple(name for name in names if name not in own and (not stage.free or _matches(name, stage.free)))


def stage_scene(scene: Scene, number: int, values: Floats) -> Scene:
    """The scene that a stage searches, without stages; a scene that has none only starts from other values.

    Args:
        scene: checked scene; it is not changed.
        number: of the stage.
        values: (P,), of all the scene's free parameters. They start from these values if the stage frees them, and have
            these values in all its candidates if it does not.

    Raises:
        Error: see `pinned`.
    """
    if not scene.stages:
        return pinned(scene, values, {parameter.name for parameter in free_parameters(scene)})
    stage = scene.stages[number]
    fixed = pinned(scene, values, set(freed(scene, stage)))
    return msgspec.structs.replace(
        fixed,
        objective=msgspec.structs.replace(fixed.objective, **stage.objective),
        failure=msgspec.structs.replace(fixed.failure, **stage.failure),
        robustness=msgspec.structs.replace(fixed.robustness, **stage.robustness),
        duration=fixed.duration if stage.duration is None else stage.duration,
        stages=[],
    )


def without_only_stage(scene: Scene) -> Scene:
    """The scene that its only stage searches, if that leaves to the whole search how; others as they are.

    A search of it is the same to the last bit, but needs no stages.
    """
    if len(scene.stages) != 1 or any(getattr(scene.stages[0], name) is not None for name in _HOW):
        return scene
    return stage_scene(scene, 0, start_values(scene))


def _matches(name: str, patterns: list[str]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
