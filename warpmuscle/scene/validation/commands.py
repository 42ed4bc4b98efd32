"""Checks of a scene's commands, of the numbers that follow them, and of runs that are commanded."""

from __future__ import annotations

import math

from warpmuscle.core.errors import SceneError
from warpmuscle.scene.controller import Command
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.checks import Checks, known


def check_commands(checks: Checks) -> None:
    """Commands have a range, and what is asked for is in it; numbers follow commands that there are.

    Raises:
        SceneError: with the key of what is wrong.
    """
    scene = checks.checked
    for name, one in scene.commands.items():
        key = f"commands.{name}"
        if not name or set(name) & set('."= \n'):
            raise SceneError("a command's name is one word, without dots", key=key)
        for field in ("reference", "min", "max", "value"):
            number = getattr(one, field)
            if number is not None and not math.isfinite(number):
                raise SceneError(f"{number} is not a finite number", key=f"{key}.{field}")
        _check_course(f"{key}.over", one)
        if one.min > one.max:
            raise SceneError(f"min {one.min:g} is greater than max {one.max:g}", key=f"{key}.min")
        for field, number in (("reference", one.reference), ("value", one.asked)):
            if not one.min <= number <= one.max:
                raise SceneError(f"{number:g} is outside {one.min:g} to {one.max:g}", key=f"{key}.{field}")
    for path, number in checks.every:
        for command in number.per if isinstance(number, Free) else ():
            known(command, scene.commands, "command", f"{path}.per.{command}")
    for command, values in scene.robustness.commands.items():
        key = f"robustness.commands.{command}"
        known(command, scene.commands, "command", key)
        if not values:
            raise SceneError("a run needs a value", key=key)
        one = scene.commands[command]
        for index, value in enumerate(values):
            if not one.min <= value <= one.max:
                raise SceneError(f"{value:g} is outside {one.min:g} to {one.max:g}", key=f"{key}.{index}")


def _check_course(key: str, command: Command) -> None:
    """Times increase from 0 on or later, values are within the command's range, and none is given besides."""
    if command.over and command.value is not None:
        raise SceneError("give either `value` or `over`", key=key)
    before = -1.0
    for index, (time, value) in enumerate(command.over):
        if not (math.isfinite(time) and time >= 0.0 and time > before):
            raise SceneError(f"times must increase from 0 on, is {time:g}", key=f"{key}.{index}")
        if not command.min <= value <= command.max:
            raise SceneError(f"{value:g} is outside {command.min:g} to {command.max:g}", key=f"{key}.{index}")
        before = time
