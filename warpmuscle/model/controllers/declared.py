"""Controllers that are declared, by a user's module or by one of `kernels`: which a scene has, found and checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.kernels.control.control import PLACES, CustomController
from warpmuscle.kernels.control.controllers import CONTROLLERS
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.model.controllers.program import has_program, with_room
from warpmuscle.model.extensions import (
    BODY,
    check_count,
    check_declaration,
    check_fields,
    check_number,
    check_parameters,
    check_texts,
)
from warpmuscle.model.user_functions import Table, arguments_of, declared, name_of
from warpmuscle.scene import Scene
from warpmuscle.scene.controller import SIMBICON, declared_value
from warpmuscle.scene.number import Number
from warpmuscle.scene.validation.checks import known
from warpmuscle.scene.validation.controller import check_declared_values
from warpmuscle.scene.validation.forces import check_values

INSTANCE = (wp.int32, Model, State, Scratch)
FUNCTIONS: dict[str, tuple[tuple[Any, ...], Any]] = {  # what they take and return
    "effort": (BODY, wp.vec3), "excitation": (BODY, wp.float32), "update": (INSTANCE, None), "damping": (BODY, wp.vec3),
}  # fmt: skip
PHASES = dict.fromkeys(FUNCTIONS, "control") | {"excitation": "muscles"}  # of a step, in which each is called


def declared_name(scene: Scene) -> tuple[str, str]:
    """What a scene calls its declared controller, and the key that does; nothing where it has none."""
    if scene.custom_controller:
        return scene.custom_controller, "custom_controller"
    if scene.controller is not None and scene.controller.type != SIMBICON:
        return scene.controller.type, "controller.type"
    return "", ""


def has_declared(scene: Scene) -> bool:
    """Whether a scene has a declared controller."""
    return bool(declared_name(scene)[0])


def declared_controller(scene: Scene) -> CustomController:
    """The controller that a scene names.

    Raises:
        SceneError: there is no such thing, its functions do not take what they are given, or its parameters are not
            those of the scene.
    """
    entry, key = declared_name(scene)
    if ":" not in entry and key == "controller.type":
        shipped: CustomController = CONTROLLERS[entry]
        return with_room(shipped, scene) if has_program(scene) else shipped
    found = declared(entry, key, CustomController)
    controller = found if isinstance(found, CustomController) else CustomController(effort=found)
    _check(controller, entry, key)
    if key == "controller.type":
        assert scene.controller is not None
        check_declared_values(controller, scene.controller, scene.character)
    else:
        _check_alone(controller, entry)
        check_values(controller.parameters, scene.custom_controller_parameters, "custom_controller_parameters")
    return controller


def _check(controller: CustomController, entry: str, key: str) -> None:
    """SceneError unless a declaration is sound."""
    own: dict[str, tuple[Any, ...]] = dict.fromkeys(FUNCTIONS, ())
    structs = [controller.parameters]
    for place, of in (("by_joint", "effort"), ("by_body", "effort"), ("by_muscle", "excitation")):
        struct = getattr(controller, place)
        if struct is not None:
            check_parameters(struct, f"those {place} of {entry!r}", key)
            if any(struct is other for other in structs):
                raise SceneError(f"{entry!r} has one structure in two places: make one for {place}", key=key)
            structs.append(struct)
            own[of] += (struct,)
            own["update"] += (Table(struct),)
            given = [one for name in FUNCTIONS if (one := getattr(controller, name)) is not None]
            if not any({struct, Table(struct)}.intersection(arguments_of(one)) for one in given):
                raise SceneError(f"no function of {entry!r} takes {name_of(struct)}, its numbers {place}", key=key)
    own["damping"] = own["effort"]
    if controller.damping is not None and controller.effort is None:
        raise SceneError(f"{entry!r} has a damping, and no effort that it belongs to", key=key)
    check_fields(controller, ("shipped", "explicit"), entry, key)
    check_texts({"description": controller.description}, entry, key)
    check_count(controller.state_a_body, f"the state of a body of {entry!r}", key)
    check_declaration(controller, FUNCTIONS, entry, key, PHASES, own)
    _check_defaults(controller, [struct for struct in structs if struct is not None], entry, key)
    _check_recorded(controller, entry, key)


def _check_defaults(controller: CustomController, structs: list[Any], entry: str, key: str) -> None:
    pairs = controller.defaults
    if not isinstance(pairs, tuple) or not all(isinstance(pair, tuple) and len(pair) == 2 for pair in pairs):
        raise SceneError(f"defaults of {entry!r} must be a tuple of (parameter, number)", key=key)
    names = [name for struct in structs for name in struct.vars]
    for name, number in pairs:
        known(name, names, "parameter", key, f"in defaults of {entry!r}")
        check_number(number, f"{name!r} in defaults of {entry!r}", key)


def _check_recorded(controller: CustomController, entry: str, key: str) -> None:
    pairs = controller.recorded
    sound = isinstance(pairs, tuple) and all(
        isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(text, str) for text in pair) for pair in pairs
    )
    if not sound:
        raise SceneError(f"what is recorded of {entry!r} must be a tuple of (name, unit)", key=key)
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names) or not all(name.isidentifier() and name.isascii() for name in names):
        raise SceneError(f"names of what is recorded of {entry!r} must be words, each once: {names}", key=key)
    if len(names) > controller.state:
        message = f"{entry!r} records {number_of(len(names), 'number')} of its state, which has {controller.state}"
        raise SceneError(message, key=key)


def _check_alone(controller: CustomController, entry: str) -> None:
    for place in PLACES:
        if getattr(controller, place) is not None:
            message = f"{entry!r} takes values {place}: name it as `type` in [controller], which has room for them"
            raise SceneError(message, key="custom_controller")


def parameters_of(scene: Scene, defaults: Mapping[str, float]) -> Mapping[str, Number]:
    """The parameters of the whole that a scene gives its declared controller, and else their defaults."""
    if scene.custom_controller or scene.controller is None:
        return {**defaults, **scene.custom_controller_parameters}
    return {**defaults, **scene.controller.parameters}


def parameters_of_each(
    scene: Scene, place: str, names: Sequence[str], struct: Any, defaults: Mapping[str, float]
) -> Iterator[dict[str, Number]]:
    """What each of these joints, bodies or muscles has of a structure's parameters, or their defaults, or zeros."""
    table = {} if scene.controller is None else getattr(scene.controller, place)
    for name in names:
        values = {parameter: declared_value(table, name, parameter) for parameter in struct.vars}
        yield {
            parameter: defaults.get(parameter, 0.0) if value is None else value for parameter, value in values.items()
        }
