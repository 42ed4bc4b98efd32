"""Numbers of a scene that are freed by patterns of their paths, each within an interval around its value."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import few_of
from warpmuscle.formats.overrides import check_exists, is_pattern, matching
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import rebuilt
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.sweep.union import number_leaves

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
PART = re.compile(rf"({NUMBER})\s*%")
ENDS = re.compile(rf"\[\s*({NUMBER})\s*,\s*({NUMBER})\s*\]")


@dataclass(frozen=True)
class Interval:
    """What numbers of a pattern may be in a search: so far from their value, as a part of it, or between two ends."""

    pattern: str  # a path, whose parts may have `*`, `?` and `[...]`
    part: float = 0.0  # of the number's value, to either side; if there are no ends
    ends: tuple[float, float] | None = None


def read_interval(text: str) -> Interval:
    """`PATTERN = 20 %` or `PATTERN = [min, max]`.

    Raises:
        SceneError: it is neither.
    """
    pattern, _, interval = (part.strip() for part in text.partition("="))
    if pattern and (match := PART.fullmatch(interval)) and float(match[1]) > 0.0:
        return Interval(pattern, part=float(match[1]) / 100.0)
    if pattern and (match := ENDS.fullmatch(interval)) and float(match[1]) < float(match[2]):
        return Interval(pattern, ends=(float(match[1]), float(match[2])))
    raise SceneError(
        f"{text!r}: write PATTERN = 20 %, or PATTERN = [min, max], such as 'character.muscles.?SOL.* = 20 %'"
    )


def with_free_numbers(scene: Scene, intervals: Sequence[Interval]) -> tuple[Scene, list[str]]:
    """The scene with numbers free besides those that are, one interval after the other.

    A number that is free already keeps its value, step and scale. Of a pattern, numbers that follow others go on
    following them, and what is 0 stays as it is where an interval is relative: these are named in notes.

    Returns:
        The scene, and notes on what stays as it is.

    Raises:
        SceneError: nothing has such a path, or a number cannot be free in such an interval.
    """
    notes: list[str] = []
    for interval in intervals:
        numbers = {tuple(path.split(".")): number for path, number in number_leaves(scene)}
        names = interval.pattern.split(".")
        matched = {".".join(path): numbers[path] for path in matching(names, numbers)}
        if not matched:
            check_exists(scene, names)
            what = "no number that may be free has a path of this pattern" if is_pattern(interval.pattern) else ""
            raise SceneError(what or "is not a number that may be free", interval.pattern)
        followers = [path for path, number in matched.items() if isinstance(number, Free) and number.same_as]
        nothing = [
            path for path, number in matched.items() if path not in followers and not _has_width(number, interval)
        ]
        found = {path: number for path, number in matched.items() if path not in followers and path not in nothing}
        if not found:
            raise SceneError(_why_none(matched, followers), interval.pattern)
        if nothing:
            notes.append(
                f"{interval.pattern}: {few_of(nothing, 1)}: 0 or without end, which has no interval in percent"
            )
        free = {path: _freed(path, number, interval) for path, number in found.items()}
        scene = rebuilt(scene, partial(_at, free))
    check_scene(scene)
    return scene, notes


def _at(numbers: dict[str, Free], path: str, leaf: Any) -> Any:
    """What stands at a path of the scene."""
    return numbers.get(path, leaf)


def _has_width(number: float | Free, interval: Interval) -> bool:
    """Whether a number has a value, and an interval that is not nothing."""
    value = number.value if isinstance(number, Free) else number
    return interval.ends is not None or (value is not None and math.isfinite(value) and value != 0.0)


def _freed(path: str, number: float | Free, interval: Interval) -> Free:
    """A number with an interval around its value."""
    value = number.value if isinstance(number, Free) else float(number)
    assert value is not None  # of all that do not follow another number
    low, high = interval.ends or sorted((value * (1.0 - interval.part), value * (1.0 + interval.part)))
    try:
        if isinstance(number, Free):
            return msgspec.structs.replace(number, min=low, max=high)
        return Free(value, low, high)
    except ValueError as error:
        raise SceneError(str(error), path) from None


def _why_none(matched: dict[str, float | Free], followers: list[str]) -> str:
    """Why none of the numbers that have such a path can be freed."""
    if followers:
        number = matched[followers[0]]
        assert isinstance(number, Free)
        return f"follows {number.same_as}: free that one"
    return "is 0 or without end, which has no interval in percent: write [min, max]"
