"""What a search asks for where its scene weighs no term: a gait at the speed of the scene, at little effort."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import leaves
from warpmuscle.scene.scene import Scene
from warpmuscle.scene.validation.muscles import SceneWarning

# Over 10 s a body that stands still in place of going 1 m/s costs 2000; walks of the shipped bipeds cost 50 to 150.
GAIT = {"speed": 200.0, "heading": 30.0}
TARGET = "objective.target_speed"
OF_SPEED = ("speed", "stride_speed")  # terms that ask for the target speed
OF_MUSCLES, OF_TORQUES = {"cost_of_transport": 20.0}, {"torque": 0.02}


def weighs_nothing(scene: Scene) -> bool:
    """Whether neither the objective of a scene nor that of a stage weighs a term."""
    objective = scene.objective
    weights = [*(getattr(objective, name) for name in TERMS), *objective.custom.values()]
    weights += [stage.objective.get(name, 0.0) for stage in scene.stages for name in TERMS]
    return not any(isinstance(weight, Free) or weight for weight in weights)


def with_usual_objective(scene: Scene) -> Scene:
    """The scene, with `GAIT` and the effort of its muscles or torques as its objective if it weighs nothing itself.

    Raises:
        SceneError: nothing is weighed, and there are no feet to walk on.
    """
    if not weighs_nothing(scene):
        return scene
    if scene.feet is None:
        raise SceneError(
            "nothing says what a search is for: weigh terms, such as tracking = 1 or effort_squared = 1",
            key="objective",
        )
    effort = OF_MUSCLES if scene.character.muscles else OF_TORQUES
    return msgspec.structs.replace(scene, objective=msgspec.structs.replace(scene.objective, **GAIT, **effort))


def warn_of_speed_in_vain(scene: Scene, keys: Iterable[str]) -> None:
    """SceneWarning if the target speed is among the keys that somebody sets for a search that does not depend on it."""
    weights = [
        *(getattr(scene.objective, name) for name in OF_SPEED),
        *scene.objective.custom.values(),
        *(stage.objective.get(name, 0.0) for stage in scene.stages for name in OF_SPEED),
    ]
    asked = any(isinstance(weight, Free) or weight for weight in weights) or weighs_nothing(scene)
    follows = any(isinstance(number, Free) and number.same_as == TARGET for _, number in leaves(scene))
    if TARGET in keys and not asked and not follows:
        warnings.warn(
            f"{TARGET} changes nothing in a search on {scene.name}, whose objective does not weigh speed: "
            "set objective.speed, too, such as 10",
            SceneWarning,
            stacklevel=3,
        )
