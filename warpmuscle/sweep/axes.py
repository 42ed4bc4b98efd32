"""Axes of a sweep and entries of its list of runs: which changes to the scene each of their values is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import shown
from warpmuscle.formats.overrides import Override, is_factor
from warpmuscle.formats.toml import Source
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.checks import near

SWEEP_AXES = ("seed", "scene")  # axes of a sweep that are no keys of a scene


@dataclass(frozen=True)
class Choice:
    """One value of an axis, or one entry of the list of runs: changes with a label."""

    axis: str
    value: float | str
    overrides: tuple[Override, ...]
    factor: bool = False  # of an axis of factors
    beside: Mapping[str, float | str] = field(default_factory=dict)  # further axes that have a value by this choice
    keys_beside: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def label(self) -> str:
        value = self.value if isinstance(self.value, str) else shown(self.value)
        return f"{self.axis}={value}" if self.axis else value

    def keys(self) -> dict[str, tuple[str, ...]]:
        """By name of the axis, the keys of the scene that its values stand for; none where they are factors."""
        if self.beside:
            return {name: keys for name, keys in self.keys_beside.items() if name in self.beside}
        return {self.axis: () if self.factor else tuple(o.key for o in self.overrides)} if self.axis else {}


class _Axis(msgspec.Struct, forbid_unknown_fields=True):
    """Keys that change together."""

    keys: list[str]
    values: list[Any] = []
    factors: list[float] = []


def axes_of(source: Source, place: str, table: Mapping[str, Any]) -> list[list[Choice]]:
    """The axes of a grid that stands at a place."""
    known = (*SWEEP_AXES, *Scene.__struct_fields__)
    for key in [key for key, value in flat(table) if isinstance(value, list) and key not in known]:
        if hint := near(key, SWEEP_AXES):
            raise SceneError(f"a scene has no such key{hint}", key=f"{place}.{key}")
    axes = [_choices(source, f"{place}.{key}", key, value) for key, value in flat(table)]
    names = [axis[0].axis for axis in axes]
    if twice := [name for name in names if names.count(name) > 1]:
        raise SceneError(f"two axes would be called {twice[0]!r}: name one as NAME = {{ keys = [..], .. }}", key=place)
    return axes


def flat(table: Mapping[str, Any], above: str = "", mark: str = "keys") -> Iterator[tuple[str, Any]]:
    """The axes of a grid: keys that are written without quotes, `objective.speed = [..]`, come as nested tables.

    Args:
        mark: what a table has that is an axis itself.
    """
    for name, value in table.items():
        key = f"{above}.{name}" if above else name
        if isinstance(value, dict) and value and mark not in value:
            yield from flat(value, key, mark)
        else:
            yield key, value


def _choices(source: Source, place: str, key: str, value: Any) -> list[Choice]:
    """The values of an axis that stands at a place."""
    if isinstance(value, dict):
        axis = to_type(value, _Axis, key=place)
        if bool(axis.values) == bool(axis.factors) or not axis.keys:
            raise SceneError("an axis has keys, and either values or factors, which are not empty", key=place)
        name, keys = key, axis.keys
        values: list[Any] = axis.values or [{"factor": factor} for factor in axis.factors]
        part = "values" if axis.values else "factors"
    elif isinstance(value, list) and value:
        name, keys, values, part = short_name(key), [key], value, ""
    else:
        raise SceneError("an axis is a list of values, or { keys = [..], factors = [..] }", key=place)
    choices = []
    seen: set[str] = set()
    for index, one in enumerate(values):
        line = source.line(f"{place}.{part}.{index}" if part else f"{place}.{index}")
        overrides = tuple(Override(each, one, line) for each in keys)
        if (mark := repr(one)) in seen:
            said = f"the factor {shown(one['factor'])}" if is_factor(one) else f"the value {one}"
            raise SceneError(f"the axis has {said} twice: a run is not computed twice", key=place)
        seen.add(mark)
        choices.append(Choice(name, _shown_value(one, index), overrides, part == "factors"))
    return choices


def entries_of(source: Source, entries: Sequence[Mapping[str, Any]]) -> list[Choice]:
    """The list of runs, of which no two have the same name: results and conditions of a study are told apart by it."""
    found: dict[str, Choice] = {}
    for index, entry in enumerate(entries):
        choice = _entry(source, index, entry)
        if choice.label in found:
            place = f"run.{index}.name" if "name" in entry else f"run.{index}"
            raise SceneError(f"{choice.label!r} is the name of another run; give it a name of its own", key=place)
        found[choice.label] = choice
    return list(found.values())


def _entry(source: Source, index: int, entry: Mapping[str, Any]) -> Choice:
    """One of the list of runs."""
    flat: dict[str, Any] = {}
    for key, value in entry.items():
        if key in ("scale", "search") and isinstance(value, dict):  # written without quotes
            flat |= {f"{key}.{name}": one for name, one in value.items()}
        elif key != "name":
            flat[key] = value
    changes = [Override(key, value, source.line(f"run.{index}.{key}")) for key, value in flat.items()]
    label = entry.get("name", "")
    if not isinstance(label, str):
        raise SceneError("the name of a run is text", key=f"run.{index}.name")
    if "name" in entry and not (label.strip() and label.isprintable()):
        raise SceneError("the name of a run is text in one line, which is not empty", key=f"run.{index}.name")
    if not entry:
        raise SceneError("a run has a name, or changes something; leave an empty one out", key=f"run.{index}")
    words = [f"{short_name(change.key)}={_label(_shown_value(change.value, index))}" for change in changes]
    return Choice("", label or ",".join(words), tuple(changes))


def short_name(key: str) -> str:
    """The end of a key that says something: `pelvis.mass` of `character.bodies.pelvis.mass`."""
    names = key.split(".")
    if len(names) < 4:
        return names[-1] if names[0] != "scale" else key
    return ".".join(names[-2:])


def _shown_value(value: Any, index: int) -> float | str:
    """What stands for a value of an axis in names and tables."""
    if is_factor(value):
        value = value["factor"]
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return float(value)
    return value if isinstance(value, str) else f"#{index}"


def _label(value: float | str) -> str:
    return value if isinstance(value, str) else shown(value)
