"""The controller by quadratic programmes: how much memory a scene's has, and where things stand in it."""

from __future__ import annotations

from typing import NamedTuple

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.program.controller import BODY_FLOATS, REPORTED
from warpmuscle.kernels.program.stepping import STEP_FLOATS
from warpmuscle.model.muscles import driven
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology

QUADRATIC_PROGRAM = "quadratic_program"  # its `type`


class Places(NamedTuple):
    """Where what the controller remembers begins in its memory, and how long that is."""

    coordinates: int  # at the start
    bodies: int  # where they are at the start
    center: int  # of mass, at the start
    steps: int
    end: int


def has_program(scene: Scene) -> bool:
    """Whether a scene has such a controller."""
    return scene.controller is not None and scene.controller.type == QUADRATIC_PROGRAM


def places_of(scene: Scene) -> Places:
    """Where things stand: behind what is reported and told to muscles and joints."""
    names = topology(scene.character)
    coordinates = REPORTED + len(driven(scene, names).muscles) + names.speeds
    bodies = coordinates + names.coordinates
    center = bodies + BODY_FLOATS * len(names.bodies)
    return Places(coordinates, bodies, center, center + 3, center + 3 + STEP_FLOATS)


def with_room(controller: CustomController, scene: Scene) -> CustomController:
    """The controller with memory for the bodies and muscles of a scene.

    Raises:
        SceneError: joints follow others, bodies are held by constraints, or the rate is free or too high.
    """
    for name, joint in scene.character.joints.items():
        if joint.follows:
            message = f"a controller of type {QUADRATIC_PROGRAM!r} knows no joint that follows another one"
            raise SceneError(message, key=f"character.joints.{name}")
    if scene.character.constraints:
        message = f"a controller of type {QUADRATIC_PROGRAM!r} knows no constraints between bodies"
        raise SceneError(message, key="character.constraints")
    assert scene.controller is not None
    if scene.controller.parameters.get("step_time", 0.0) != 0.0 and scene.feet is None:
        raise SceneError(
            "a body that steps needs feet; name them in character.feet", key="controller.parameters.step_time"
        )
    decision_steps(scene, controller)
    return controller._replace(state=places_of(scene).end)


def decision_steps(scene: Scene, controller: CustomController) -> int:
    """Steps between two decisions."""
    assert scene.controller is not None
    rate, most = scene.controller.parameters.get("rate", dict(controller.defaults)["rate"]), 1.0 / scene.time_step
    if not isinstance(rate, (int, float)):
        raise SceneError(
            "how often the controller decides cannot be a free parameter", key="controller.parameters.rate"
        )
    if not 1.0 <= rate <= most * (1.0 + 1e-6):
        message = f"the controller decides at 1 Hz to {most:g} Hz, which is every step, not at {rate:g} Hz"
        raise SceneError(message, key="controller.parameters.rate")
    return max(round(most / rate), 1)
