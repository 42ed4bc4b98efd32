"""Free parameters of a scene as vectors: which there are, putting values in, writing values back."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.scene import Scene
from warpmuscle.scene.impairments.impaired import impaired
from warpmuscle.scene.number import Free, Number, Scale
from warpmuscle.scene.units import unit_below

Part = TypeVar("Part")
PLAIN: frozenset[type] = frozenset({float, int, str, bool, type(None)})  # what most leaves are


@dataclass(frozen=True)
class Parameter:
    """A number that a search may change."""

    name: str  # path in the scene, such as `controller.pd.lHip.kp`
    value: float  # start value
    min: float
    max: float
    step: float  # precision; 0 if continuous
    unit: str  # such as "N m/rad"; empty for a pure number
    scale: Scale = "linear"  # of the unit interval that a search sees


def leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Every (dotted path, value) below `value` that is no structure, list, tuple or table, in order of appearance."""
    waiting = [iter(named_members(value) or ())]
    keys = [key]
    while waiting:
        for name, member in waiting[-1]:
            path = f"{keys[-1]}.{name}" if keys[-1] else name
            members = None if type(member) in PLAIN else named_members(member)
            if members is None:
                yield path, member
            else:
                waiting.append(iter(members))
                keys.append(path)
                break
        else:
            waiting.pop()
            keys.pop()


def _free_leaves(value: Any, key: str, unit: str, found: list[tuple[str, Free, str]]) -> None:
    """Put the leaves into a list that are `Free`, with units; scenes are walked often, and most of them is numbers."""
    for name, member in named_members(value, PLAIN) or ():
        if type(member) is Free:
            found.append((f"{key}{name}", member, unit_below(value, name, unit)))
        else:
            _free_leaves(member, f"{key}{name}.", unit_below(value, name, unit), found)


def free_parameters(scene: Scene) -> list[Parameter]:
    """The free parameters of a scene in order of appearance; numbers that follow another one are left out."""
    if (constant := _constant.get(id(scene))) is not None:
        return list(constant.parameters)
    return _parameters(scene, free_numbers(scene))


@dataclass
class Constant:
    """What is known of a scene that nobody changes for a while."""

    scene: Scene
    numbers: list[tuple[str, Free, str]]  # as `free_numbers` has them
    parameters: list[Parameter]
    checked: bool = False  # and found to be sound


_constant: dict[int, Constant] = {}


def constant_scene(scene: Scene) -> Constant | None:
    """What is known of a scene within `constant`; nothing of others."""
    return _constant.get(id(scene))


@contextlib.contextmanager
def constant(scenes: Iterable[Scene]) -> Iterator[None]:
    """For a while, know the free parameters of scenes that nobody changes, and which are sound.

    To find either takes milliseconds, and a search wants to know them dozens of times.
    """
    found = {}
    for scene in scenes:
        if id(scene) not in _constant:
            numbers = free_numbers(scene)
            found[id(scene)] = Constant(scene, numbers, _parameters(scene, numbers))
    _constant.update(found)
    try:
        yield
    finally:
        for key in found:
            _constant.pop(key, None)


def free_numbers(scene: Scene) -> list[tuple[str, Free, str]]:
    """Path, number and unit of all that is no plain number."""
    if (constant := _constant.get(id(scene))) is not None:
        return list(constant.numbers)
    found: list[tuple[str, Free, str]] = []
    _free_leaves(scene, "", "1", found)
    return found


class KnownNumbers(NamedTuple):
    """What `substitute` finds of a scene, for one that nobody changes."""

    numbers: list[tuple[str, Free, str]]  # as `free_numbers` has them
    parameters: list[Parameter]
    within: set[str]  # paths of all that has any of them


def known_numbers(scene: Scene) -> KnownNumbers:
    """What `substitute` finds of a scene, so that it need not look again."""
    found = free_numbers(scene)
    return KnownNumbers(
        found, _parameters(scene, found), {"", *(path for key, _, _ in found for path in _down_to(key))}
    )


def _parameters(scene: Scene, found: Sequence[tuple[str, Free, str]]) -> list[Parameter]:
    result: list[Parameter] = []
    for key, number, unit in found:
        if number.is_parameter:
            result.append(_parameter(key, number, "" if unit == "1" else unit))
        for command in number.per:
            for power, (name, rate) in enumerate(number.rates(command), 1):
                if isinstance(rate, Free):
                    per = scene.commands[command].unit if command in scene.commands else ""
                    result.append(_parameter(f"{key}.per.{name}", rate, _unit_per(unit, per, power)))
    return result


def _parameter(name: str, number: Free, unit: str) -> Parameter:
    assert number.value is not None
    assert number.min is not None
    assert number.max is not None
    return Parameter(name, number.value, number.min, number.max, number.step, unit, number.scale)


def _unit_per(unit: str, command: str, power: int) -> str:
    """Unit of what is added for a power of a command."""
    if not command:
        return "" if unit == "1" else unit
    return f"{unit}/({command})" if power == 1 else f"{unit}/({command})^{power}"


def start_values(scene: Scene) -> Floats:
    """Start values of the free parameters, (P,)."""
    return np.array([parameter.value for parameter in free_parameters(scene)], dtype=np.float64)


def at_start(scene: Scene) -> Scene:
    """The scene with its free parameters at their start values, to be read only: parts without any are the scene's."""
    known = known_numbers(scene)
    values = np.array([parameter.value for parameter in known.parameters], dtype=np.float64)
    return substitute(scene, values, known=known)


def greatest(scene: Scene, number: Number) -> float:
    """The highest value that a number of a scene can take in a search."""
    if not isinstance(number, Free):
        return number
    away = ranges_of_commands(scene)
    if not number.same_as:
        return number.interval(away)[1]
    source = next(free for key, free in leaves(scene) if key == number.same_as)
    return number.range_over(*source.interval(away))[1]


def ranges_of_commands(scene: Scene) -> dict[str, tuple[float, float]]:
    """How far commands may be from their references, by name: lowest and highest distance."""
    return {name: (one.min - one.reference, one.max - one.reference) for name, one in scene.commands.items()}


def distances_of_commands(scene: Scene, asked: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """How far commands are from their references, by name.

    Args:
        asked: other values than those of the scene, of some of them; floats or arrays.
    """
    asked = asked or {}
    return {name: asked.get(name, one.asked) - one.reference for name, one in scene.commands.items()}


def substitute(
    scene: Scene, values: Floats, commands: Mapping[str, Any] | None = None, known: KnownNumbers | None = None
) -> Scene:
    """The scene with numbers, or one number an instance, in place of its free parameters.

    Args:
        scene: checked scene (see `validation.scene.check_scene`); it is not changed.
        values: (n, P), one row an instance, or (P,), in the order of `free_parameters`.
        commands: floats, or (n,) arrays, in place of the scene's own commands of these names.
        known: the scene's `known_numbers`, where nobody changes the scene or the result: parts without any are then
            those of the scene, and not copies.

    Returns:
        A scene whose fields hold (n,) arrays of float64, or floats for a (P,) vector, where they held a `Free`;
        a number that follows another one holds the same array as that one. Its muscles have their impairments.

    Raises:
        Error: `values` has another number of columns than the scene has free parameters.
    """
    found, parameters, within = known_numbers(scene) if known is None else known
    values = _as_values(parameters, values, dimensions=(1, 2))
    columns: dict[str, Any] = {}
    for index, parameter in enumerate(parameters):
        columns[parameter.name] = float(values[index]) if values.ndim == 1 else values[:, index].copy()
    following = {key: number for key, number, _ in found if number.per}
    if following:
        away = distances_of_commands(scene, commands)
        columns |= {key: _commanded(key, number, away, columns) for key, number in following.items()}

    def column(key: str, number: Free) -> Any:
        name = number.same_as or key
        if name not in columns:
            raise SceneError(f"{name!r} is not a free parameter", key=f"{key}.same_as")
        return number.following(columns[name])

    where = None if known is None else within
    numeric = rebuilt(scene, lambda key, leaf: column(key, leaf) if isinstance(leaf, Free) else leaf, within=where)
    return impaired(numeric)


def _down_to(key: str) -> Iterator[str]:
    """A path and all above it."""
    words = key.split(".")
    return (".".join(words[: k + 1]) for k in range(len(words)))


def _commanded(key: str, number: Free, away: Mapping[str, Any], columns: Mapping[str, Any]) -> Any:
    """A number that follows commands; its own value and what is added per command may be columns."""

    def value_of(name: str, fixed: Number | None) -> Any:
        return columns.get(f"{key}.{name}" if name else key, fixed)

    return number.commanded(away, value_of)


def with_values(scene: Scene, values: Floats) -> Scene:
    """The same scene, its free parameters starting from other values; they stay free.

    Args:
        scene: checked scene; it is not changed.
        values: (P,) in the order of `free_parameters`.

    Raises:
        Error: wrong number of values, or one of them lies outside its parameter's interval.
    """
    parameters = free_parameters(scene)
    values = _as_values(parameters, values, dimensions=(1,))
    starts = {parameter.name: float(value) for parameter, value in zip(parameters, values, strict=True)}
    for parameter in parameters:
        if not parameter.min <= starts[parameter.name] <= parameter.max:
            raise Error(
                f"{parameter.name}: value {starts[parameter.name]:g} is outside its interval "
                f"[{parameter.min:g}, {parameter.max:g}]"
            )

    def restarted(key: str, leaf: Any) -> Any:
        if not isinstance(leaf, Free) or leaf.same_as:
            return leaf
        per = leaf.with_rates(lambda name, rate: restarted(f"{key}.{name}", rate))
        return msgspec.structs.replace(leaf, value=starts.get(key, leaf.value), per=per)

    return rebuilt(scene, restarted)


def rebuilt(
    value: Part, replace: Callable[[str, Any], Any], key: str = "", within: Collection[str] | None = None
) -> Part:
    """A copy of a scene or of a part of it, with `replace(path, leaf)` in place of every leaf (see `leaves`).

    Args:
        within: paths that may change; what stands at others is not copied. By default all.
    """
    if within is not None and key not in within:
        return value
    members = None if type(value) in PLAIN else named_members(value)
    if members is None:
        return replace(key, value)  # type: ignore[no-any-return]
    parts = [(name, rebuilt(one, replace, f"{key}.{name}" if key else name, within)) for name, one in members]
    kind: Any = type(value)
    if isinstance(value, msgspec.Struct):
        return kind(**dict(parts))  # type: ignore[no-any-return]
    return kind(parts if isinstance(value, dict) else [member for _, member in parts])  # type: ignore[no-any-return]


def pinned(scene: Scene, values: Floats, free: Collection[str]) -> Scene:
    """The same scene with only some of its parameters free, and all of them at other values.

    Args:
        scene: checked scene; it is not changed.
        values: (P,) in the order of `free_parameters`.
        free: names of those that stay free; the others become numbers, and so do the numbers that follow them.

    Raises:
        Error: wrong number of values, or one of them lies outside its parameter's interval.
    """
    started = with_values(scene, values)
    numbers = dict(zip((parameter.name for parameter in free_parameters(scene)), map(float, values), strict=True))
    kept = {key for key, number, _ in free_numbers(scene) if number.per} | set(free)  # what commands change stays

    def replaced(key: str, leaf: Any) -> Any:
        if not isinstance(leaf, Free):
            return leaf
        if leaf.same_as:
            return leaf if leaf.same_as in kept else leaf.following(numbers[leaf.same_as])
        if key not in kept:
            return numbers[key]
        per = leaf.with_rates(lambda name, rate: replaced(f"{key}.{name}", rate))
        if key in free or not leaf.is_parameter:
            return msgspec.structs.replace(leaf, per=per)
        return Free(numbers[key], per=per)

    return rebuilt(started, replaced)


def named_members(value: Any, without: Container[type] = ()) -> list[tuple[str, Any]] | None:
    """Named members of a structure, list, tuple or table; None for anything else, a free parameter included.

    Args:
        without: types whose members are left out.
    """
    if isinstance(value, msgspec.Struct) and not isinstance(value, Free):
        return [(name, one) for name in value.__struct_fields__ if type(one := getattr(value, name)) not in without]
    if isinstance(value, dict):
        return [(str(name), one) for name, one in value.items() if type(one) not in without]
    if isinstance(value, list | tuple):
        return [(str(index), one) for index, one in enumerate(value) if type(one) not in without]
    return None


def _as_values(parameters: list[Parameter], values: Floats, dimensions: tuple[int, ...]) -> Floats:
    """`values` as float64; Error unless it has one finite column a parameter."""
    values = np.asarray(values, dtype=np.float64)
    if values.ndim not in dimensions or values.shape[-1] != len(parameters):
        wanted = " or ".join({1: f"({len(parameters)},)", 2: f"(n, {len(parameters)})"}[n] for n in dimensions)
        raise Error(f"expected values of shape {wanted}, one a free parameter, got {values.shape}")
    if not np.isfinite(values).all():
        bad = parameters[int(np.argwhere(~np.isfinite(values))[0, -1])]
        raise Error(f"{bad.name}: value is not finite")
    return values
