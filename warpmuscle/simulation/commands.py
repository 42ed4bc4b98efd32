"""Commands of a batch, checked, and the ground that they incline under characters that walk on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpmuscle.core.arguments import as_array, as_kind
from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.pose import normalized
from warpmuscle.scene import Ground, Scene
from warpmuscle.scene.validation.checks import near

EVERY = 0.02  # s, between two changes of commands that follow a course


def checked_commands(commands: Mapping[str, ArrayLike], scene: Scene, instances: int) -> dict[str, Floats]:
    """Commands of so many instances as () or (instances,) arrays.

    Raises:
        RolloutError: the scene takes no such command, or not this value, or the array has another shape.
    """
    as_kind(dict, commands, "commands", error=RolloutError)
    checked: dict[str, Floats] = {}
    for name, values in commands.items():
        if name not in scene.commands:
            hint = near(str(name), scene.commands) or f"; it takes {', '.join(scene.commands) or 'none'}"
            raise RolloutError(f"{scene.name} takes no command {name!r}{hint}")
        one, array = scene.commands[name], as_array(values, f"command {name}", error=RolloutError).astype(np.float64)
        if array.shape not in ((), (instances,)):
            raise RolloutError(f"command {name} has shape {array.shape}; this rollout takes one value or {instances}")
        inside = (array >= one.min) & (array <= one.max)
        if not np.all(inside):
            wrong = array.reshape(-1)[int(np.argmin(inside.reshape(-1)))]
            raise RolloutError(f"command {name}: {wrong:g} is outside {one.min:g} to {one.max:g} {one.unit}".rstrip())
        checked[name] = array
    return checked


class Course:
    """Commands of a scene that change in the course of a run.

    They are renewed every `EVERY` seconds, since numbers then go to the device again.
    """

    def __init__(self, scene: Scene) -> None:
        self._commands = {name: one for name, one in scene.commands.items() if one.over}
        self._steps = max(round(EVERY / scene.time_step), 1)
        self._time_step = scene.time_step
        self.given: dict[str, float] = {}  # since the start

    def leave(self, names: Iterable[str]) -> None:
        """From now on somebody else commands these."""
        self._commands = {name: one for name, one in self._commands.items() if name not in set(names)}

    def until(self, step: int) -> int | None:
        """The step at which commands are renewed next, None if none change any more."""
        last = max((one.over[-1][0] for one in self._commands.values()), default=-1.0)
        return (step // self._steps + 1) * self._steps if step * self._time_step <= last else None

    def at(self, step: int) -> dict[str, float]:
        """What commands are from this step on, of those that are other than before."""
        time = step // self._steps * self._steps * self._time_step  # so that it does not matter where runs pause
        now = {name: one.at(time) for name, one in self._commands.items()}
        return {name: value for name, value in now.items() if value != self.given.get(name, self._commands[name].asked)}


def place_of_root(coordinate_names: Sequence[str], coordinates: Floats) -> Floats:
    """Places x, y, z (n, 3) of the roots of instances with coordinates (n, C), m; 0 where a root cannot move."""
    place = np.zeros((len(coordinates), 3))
    for axis, name in enumerate(("root.x", "root.y", "root.z")):
        if name in coordinate_names:
            place[:, axis] = coordinates[:, coordinate_names.index(name)]
    return place


def turned_below(before: Ground, after: Ground, place: Floats) -> Ground:
    """The ground as it is after a command, moved so that it goes through what was the ground below places (n, 3), m.

    Args:
        before: of a numeric scene, under the characters until now. after: of the scene as commanded.
    """
    count = len(place)
    old, new = (normalized(_columns(ground.normal, count)) for ground in (before, after))
    if np.array_equal(old, new):
        return before
    height = _columns([before.height], count)[:, 0]
    below = place.copy()
    below[:, 1] = (height - old[:, 0] * place[:, 0] - old[:, 2] * place[:, 2]) / old[:, 1]
    return msgspec.structs.replace(after, height=np.sum(new * below, axis=1))


def levelled(turned: Ground, level: Ground, again: NDArray[np.bool_]) -> Ground:
    """The ground as the scene has it below some of the instances, and as it was turned below the others."""
    count = len(again)
    height = np.where(again, _columns([level.height], count)[:, 0], _columns([turned.height], count)[:, 0])
    return msgspec.structs.replace(level, height=height)


def _columns(numbers: Sequence[Any], count: int) -> Floats:
    """Numbers of a numeric scene, floats or (n,) arrays, as (n, numbers)."""
    return np.broadcast_to(rows([list(numbers)])[:, 0], (count, len(numbers)))
