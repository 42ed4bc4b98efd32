"""The scene of one stage of a search: what the stage says put in place of what the whole scene says."""

from __future__ import annotations

import fnmatch

import msgspec

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Scene, SearchStage
from warpmuscle.scene.parameters import free_parameters, pinned


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


def _matches(name: str, patterns: list[str]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
