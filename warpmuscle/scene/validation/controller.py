"""Checks of the controller of a scene: by its type, those of SIMBICON or of one that takes parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Character, Controller
from warpmuscle.scene.controller import EVERY_OTHER, SIMBICON, declared_value
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Number
from warpmuscle.scene.simbicon.checks import check_simbicon
from warpmuscle.scene.simbicon.controller import Simbicon
from warpmuscle.scene.validation.checks import Checks, known, near
from warpmuscle.scene.validation.forces import check_values

MOVED_BY_TORQUE = ("ball", "universal", "hinge", "fixed")  # joints that a controller of legs knows
PLACES = {"by_joint": "joint", "by_body": "body", "by_muscle": "muscle"}  # what has values of its own in each


def check_controller(check: Checks) -> None:
    """The controller of a scene has what its type takes; there is not one of one's own besides, unless on SIMBICON."""
    scene, controller = check.checked, check.checked.controller
    if scene.custom_controller_parameters and not scene.custom_controller:
        raise SceneError("there is no custom_controller to take these parameters", key="custom_controller_parameters")
    if controller is None:
        return
    if controller.type == SIMBICON:
        for field in ("parameters", *PLACES):
            if getattr(controller, field):
                message = f"a {SIMBICON} controller does not take this; choose another type"
                raise SceneError(message, key=f"controller.{field}")
        check_simbicon(check, controller, scene.character)
        return
    if scene.custom_controller:
        message = f"there is a controller of type {controller.type!r} already; leave out one of them"
        raise SceneError(message, key="custom_controller")
    _check_keys(controller)
    for place, what in PLACES.items():
        for name in getattr(controller, place):
            if name != EVERY_OTHER:
                known(name, _names(place, scene.character), what, f"controller.{place}.{name}")
    if ":" not in controller.type:
        from warpmuscle.kernels.control.controllers import CONTROLLERS  # with Warp, for which others need not wait

        types = (SIMBICON, *CONTROLLERS)
        if controller.type not in CONTROLLERS:
            message = f"no controller is called {controller.type!r}{near(controller.type, types)}; "
            raise SceneError(f"{message}there are {', '.join(types)}, or module:name", key="controller.type")
        check_declared_values(CONTROLLERS[controller.type], controller, scene.character)
        if CONTROLLERS[controller.type].legs:
            _check_legs(controller.type, scene.character)


def _check_keys(controller: Controller) -> None:
    """One that is no SIMBICON has no key of it."""
    default = Simbicon()
    for field in Simbicon.__struct_fields__:
        if getattr(controller, field) != getattr(default, field):
            message = f"a controller of type {controller.type!r} takes no {field}, which is of {SIMBICON}"
            raise SceneError(message, key=f"controller.{field}")


def _check_legs(kind: str, character: Character) -> None:
    """A character has two legs that a controller of this type can move: ankles, hinges as knees, hips of the root."""
    if character.feet is None:
        raise SceneError(f"a controller of type {kind!r} needs the two feet: name them", key="character.feet")
    above = {joint.child: (name, joint) for name, joint in character.joints.items()}
    for foot in character.feet:
        body = foot
        for place in ("ankle", "knee", "hip"):
            if body not in above:
                message = f"a controller of type {kind!r} needs a {place} between the root and {foot!r}"
                raise SceneError(message, key="character.feet")
            name, joint = above[body]
            if place == "knee" and joint_type(joint).name != "hinge":
                raise SceneError(f"a controller of type {kind!r} needs a hinge as knee", key=f"character.joints.{name}")
            body = joint.parent
        if body != character.root:
            message = f"a controller of type {kind!r} needs hips of the root, and {name!r} has {body!r} above it"
            raise SceneError(message, key=f"character.joints.{name}.parent")
    for name, joint in character.joints.items():
        if joint_type(joint).name not in MOVED_BY_TORQUE:
            message = f"a controller of type {kind!r} can move only joints of type {', '.join(MOVED_BY_TORQUE)}"
            raise SceneError(message, key=f"character.joints.{name}.type")


def check_declared_values(declared: Any, controller: Controller, character: Character) -> None:
    """SceneError unless a controller has values of all that is declared, and of nothing else.

    Args:
        declared: `kernels.control.control.CustomController`.
    """
    defaults = dict(declared.defaults)
    check_values(declared.parameters, controller.parameters, "controller.parameters", given_else=defaults)
    for place, what in PLACES.items():
        struct, table = getattr(declared, place), getattr(controller, place)
        parameters = [] if struct is None else list(struct.vars)
        if table and not parameters:
            raise SceneError(f"{controller.type!r} takes no values by {what}", key=f"controller.{place}")
        for name, given in table.items():
            _check_known(parameters, given, f"controller.{place}.{name}")
        for name in _names(place, character):
            missing = [p for p in parameters if declared_value(table, name, p) is None and p not in defaults]
            if missing:
                said = f"there is no value of {', '.join(map(repr, missing))}"
                hint = f"; one under {EVERY_OTHER!r} is of every other {what}"
                raise SceneError(said + hint, key=f"controller.{place}.{name}")


def _check_known(parameters: Iterable[str], given: Mapping[str, Number], key: str) -> None:
    for name in given:
        if name not in (names := list(parameters)):
            takes = f"it takes {', '.join(names)}"
            raise SceneError(f"no parameter is called {name!r}{near(name, names)}; {takes}", key=f"{key}.{name}")


def _names(place: str, character: Character) -> list[str]:
    """What may have values of its own: joints that move, bodies, or muscles."""
    if place == "by_joint":
        return [name for name, joint in character.joints.items() if joint_type(joint).moves]
    return list(character.bodies if place == "by_body" else character.muscles)


def check_control_rate(check: Checks) -> None:
    """Targets are renewed at most once a step, and are those of a SIMBICON controller."""
    scene = check.checked
    most = 1.0 / scene.time_step
    if scene.control_rate > most * (1.0 + 1e-6):
        raise SceneError(f"the controller cannot decide more than once a step, at {most:g} Hz", key="control_rate")
    if scene.control_rate > 0.0 and (scene.simbicon is None or scene.custom_controller):
        if scene.custom_controller or scene.controller is not None:
            one = "custom_controller" if scene.custom_controller else "controller of this type"
            raise SceneError(f"a {one} decides in every step; leave control_rate out", key="control_rate")
        raise SceneError("there is no controller; leave control_rate out", key="control_rate")
