"""Scenes that differ in numbers only as one scene, so that their candidates can be simulated in the same batches.

What nothing uses of them is found for all at once, too.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any

import msgspec
import numpy as np
from msgspec import inspect

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.model.collisions import collision_pairs
from warpmuscle.model.objective import counted_terms
from warpmuscle.model.unused_parameters import of_the_body, unused_in, unused_parameters
from warpmuscle.optimization.optimize import searched_without, weighed
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import constant, free_parameters, rebuilt, start_values
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.checks import Checks
from warpmuscle.scene.validation.scene import check_scene

_SCENE = inspect.type_info(Scene)
AT_ONCE = 4096  # parameters of scenes whose models lie side by side: some 100 MB


class MergedScene:
    """Scenes of one kind (see `groups`) as one scene, whose free parameters are all numbers in which they may differ.

    Attributes:
        scene: a candidate of any of the scenes is one of this scene, and becomes the same to the last bit.
    """

    def __init__(self, scenes: Sequence[Scene]) -> None:
        """Join the scenes.

        Raises:
            SceneError: no single scene can have all their values.
        """
        self._scenes = list(scenes)
        self._columns: dict[int, _Columns] = {}
        if all(scene is scenes[0] for scene in scenes):
            self.scene: Scene = scenes[0]
            self._paths = None
            return
        numbers = [numbers_of(scene) for scene in scenes]
        check = cache(lambda index: Checks(scenes[index]))
        free: dict[str, Free] = {}
        for path, first in numbers[0].items():
            theirs = [of_scene[path] for of_scene in numbers]
            if isinstance(first, Free) or any(number != first for number in theirs):
                ends = [_interval(number, numbers[index], partial(check, index)) for index, number in enumerate(theirs)]
                low, high = min(low for low, _ in ends), max(high for _, high in ends)
                free[path] = Free(check(0).start(first), low, high)
        self.scene = rebuilt(scenes[0], lambda path, leaf: free.get(path, leaf))
        if len(scenes) > 1:
            check_scene(self.scene)
        self._paths = [parameter.name for parameter in free_parameters(self.scene)]

    def values(self, index: int, values: Floats) -> Floats:
        """Candidates of one scene as candidates of all: (n, P of that scene) as (n, P of the joint one)."""
        if self._paths is None:
            return values
        if index not in self._columns:
            self._columns[index] = _Columns(self._scenes[index], self._paths)
        return self._columns[index].of(values)


class _Columns:
    """The numbers of one scene by the parameters of a joint one: constant, or what follows a column of its own."""

    def __init__(self, scene: Scene, paths: Sequence[str]) -> None:
        own = {parameter.name: column for column, parameter in enumerate(free_parameters(scene))}
        found = numbers_of(scene)
        self._constant = np.zeros(len(paths))
        self._free: list[tuple[int, int, Free]] = []  # column of the joint scene, and that of its own that it follows
        for column, path in enumerate(paths):
            leaf = found[path]
            if isinstance(leaf, Free):
                self._free.append((column, own[leaf.same_as or path], leaf))
            else:
                self._constant[column] = leaf

    def of(self, values: Floats) -> Floats:
        """The joint candidates of (n, P) own ones."""
        table = np.tile(self._constant, (len(values), 1))
        for column, source, leaf in self._free:
            table[:, column] = leaf.following(values[:, source])
        return table


def _interval(
    number: float | Free, numbers: Mapping[str, float | Free], check: Callable[[], Checks]
) -> tuple[float, float]:  # fmt: skip
    """See `Checks.interval`, which walks the whole scene; what depends on no command needs none of it."""
    if not isinstance(number, Free):
        return number, number
    source = numbers.get(number.same_as) if number.same_as else number
    if not isinstance(source, Free) or source.same_as or source.per or source.value is None:
        return check().interval(number)
    return number.range_over(*source.interval({}))


def groups(scenes: Sequence[Scene]) -> list[list[int]]:
    """Indices of scenes that can share batches, in the order of the first of each group.

    Scenes of a group differ in numbers only, and in none that decides what is compiled or which parts a model has.
    """
    found: dict[bytes, list[int]] = {}
    kinds: dict[int, bytes] = {}  # by scene, of which several runs may have the same one
    for index, scene in enumerate(scenes):
        # Alone are those whose kind or reference is not only the scene's own, and numbers that follow commands.
        alone = bool(scene.stages) or scene.tracking is not None or bool(scene.commands)
        key = kinds.get(id(scene))
        if key is None:
            key = b"%d" % index if alone else _kind(scene)
            if not scene.stages:
                kinds[id(scene)] = key
        found.setdefault(key, []).append(index)
    result: list[list[int]] = []
    for group in found.values():
        try:
            MergedScene(list({id(scenes[index]): scenes[index] for index in group}.values()))
            result.append(group)
        except SceneError:  # such as limits of a joint that overlap between one scene and another
            result.extend([index] for index in group)
    return sorted(result)


_unchanged: dict[int, tuple[Scene, dict[str, float | Free]]] = {}


@contextlib.contextmanager
def unchanged(scenes: Iterable[Scene]) -> Iterator[None]:
    """For a while, know the numbers and free parameters of scenes that nobody changes: to find them takes long."""
    every = list(scenes)
    found = {id(scene): (scene, dict(number_leaves(scene))) for scene in every if id(scene) not in _unchanged}
    _unchanged.update(found)
    try:
        with constant(every):
            yield
    finally:
        for key in found:
            _unchanged.pop(key, None)


def numbers_of(scene: Scene) -> dict[str, float | Free]:
    """Every number of a scene that may be a free parameter, by its path."""
    known = _unchanged.get(id(scene))
    return dict(number_leaves(scene)) if known is None else known[1]


def number_leaves(scene: Scene) -> Iterator[tuple[str, float | Free]]:
    """Every (path, number) of a scene that may be a free parameter."""
    yield from _numbers(scene, _SCENE, "")


def _numbers(value: Any, type_: inspect.Type, key: str) -> Iterator[tuple[str, float | Free]]:
    for one in type_.types if isinstance(type_, inspect.UnionType) else (type_,):
        match one:
            case inspect.StructType(cls=cls) if cls is Free:
                if isinstance(value, Free | int | float):
                    yield key, value
                    return
            case inspect.StructType(cls=cls, fields=fields) if isinstance(value, cls):
                for field in fields:
                    yield from _numbers(
                        getattr(value, field.name), field.type, f"{key}.{field.name}" if key else field.name
                    )
            case inspect.DictType(value_type=inner) if isinstance(value, dict):
                for name, member in value.items():
                    yield from _numbers(member, inner, f"{key}.{name}")
            case inspect.ListType(item_type=inner) if isinstance(value, list | tuple):
                for index, member in enumerate(value):
                    yield from _numbers(member, inner, f"{key}.{index}")
            case inspect.TupleType(item_types=inners) if isinstance(value, list | tuple):
                for index, (member, inner) in enumerate(zip(value, inners, strict=True)):
                    yield from _numbers(member, inner, f"{key}.{index}")


def _kind(scene: Scene) -> bytes:
    """What scenes that share a batch have in common: all but the values of numbers."""
    paths = numbers_of(scene)
    same: Scene = rebuilt(scene, lambda path, leaf: 0.0 if path in paths else leaf)
    touchable = _may_count(scene.ground.stiffness)
    elastic = {joint: _may_count(own.stiffness) or _may_count(own.damping) for joint, own in scene.actuation.items()}
    pairs = collision_pairs(scene, topology(scene.character))
    return msgspec.json.encode((same, counted_terms(scene.objective), touchable, elastic, pairs))


def _may_count(number: float | Free) -> bool:
    """Whether a number can be another one than 0."""
    return isinstance(number, Free) or number != 0.0


def weighed_scenes(scenes: Sequence[Scene]) -> list[Scene | Error]:
    """Each scene with an objective and free parameters, or why it has none."""
    found: list[Scene | Error] = []
    for scene in scenes:
        try:
            found.append(weighed(scene))
        except Error as error:
            found.append(error)
    return found


def searched_scenes(scenes: Sequence[Scene | Error]) -> list[Scene | Error]:
    """Each scene as `optimization.optimize.searched` has it, or why it cannot be searched; see `weighed_scenes`."""
    found = list(scenes)
    sound = [(number, scene) for number, scene in enumerate(scenes) if isinstance(scene, Scene)]
    for group in groups([scene for _, scene in sound]):
        members = [sound[place] for place in group]
        each = max(AT_ONCE // max(len(free_parameters(members[0][1])), 1), 1)
        for first in range(0, len(members), each):
            part = members[first : first + each]
            for (number, scene), names in zip(part, _unused([scene for _, scene in part]), strict=True):
                try:
                    found[number] = names if isinstance(names, Error) else searched_without(scene, names)
                except Error as error:
                    found[number] = error
    return found


def _unused(scenes: Sequence[Scene]) -> Sequence[list[str] | Error]:
    """Names of unused parameters of scenes of a group, or why they cannot be told."""
    try:
        if len(scenes) == 1:
            return [unused_parameters(scenes[0])]
        own = [of_the_body(scene) for scene in scenes]
        merged = MergedScene(own)
        return unused_in(merged.scene, [(free_parameters(one), start_values(one)) for one in own], merged.values)
    except Error as error:
        return [error] * len(scenes)
