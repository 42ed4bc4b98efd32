"""Controllers of one's own that a scene names, found and checked; and what declares parameters and a state at all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.kernels.control import CustomController
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.model.user_functions import FLOATS, check_arguments, check_result, checked_function, declared
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.forces import check_values

INSTANCE = (wp.int32, Model, State, Scratch)
BODY = (wp.int32, wp.int32, Model, State, Scratch)
CONTROLLER_FUNCTIONS: dict[str, tuple[tuple[Any, ...], Any]] = {  # what they take and return
    "effort": (BODY, wp.vec3), "excitation": (BODY, wp.float32), "update": (INSTANCE, None),
}  # fmt: skip
PARAMETERS = "custom_controller_parameters"


def custom_controller(scene: Scene) -> CustomController:
    """The controller of one's own that a scene names; one without functions if it names none.

    Raises:
        SceneError: there is no such thing, its functions do not take what they are given, or its parameters are not
            those of the scene.
    """
    entry, key = scene.custom_controller, "custom_controller"
    if not entry:
        return CustomController()
    found = declared(entry, key, CustomController)
    controller = found if isinstance(found, CustomController) else CustomController(effort=found)
    check_declaration(controller, CONTROLLER_FUNCTIONS, entry, key)
    check_values(controller.parameters, scene.custom_controller_parameters, PARAMETERS)
    return controller


def check_declaration(part: Any, functions: Mapping[str, tuple[tuple[Any, ...], Any]], entry: str, key: str) -> None:
    """SceneError unless a controller or force has functions that take its parameters and state, and both are sound."""
    given = {name: getattr(part, name) for name in functions if getattr(part, name) is not None}
    if not given:
        raise SceneError(f"{entry!r} has no function: give it one of {', '.join(functions)}", key=key)
    if part.parameters is not None:
        fields = getattr(part.parameters, "vars", None)
        if fields is None or not fields or any(field.type is not wp.float32 for field in fields.values()):
            raise SceneError(f"the parameters of {entry!r} are no @wp.struct of floats", key=key)
    if not isinstance(part.state, int) or isinstance(part.state, bool) or part.state < 0:
        raise SceneError(f"the state of {entry!r} is not a number of floats, but {part.state!r}", key=key)
    check_size("values", part.state, lambda message: SceneError(message, key=key))
    own = (*([] if part.parameters is None else [part.parameters]), *([FLOATS] if part.state else []))
    for name, function in given.items():
        arguments, result = functions[name]
        what = checked_function(function, entry, key).key.rpartition(".")[2]
        check_arguments(function, arguments, key, what, own)
        if result is not None:
            check_result(function, (result,), key, what)
