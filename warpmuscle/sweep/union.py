"""Scenes that differ in numbers only as one scene, so that their candidates can be simulated in the same batches."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, partial
from typing import Any

import msgspec
import numpy as np
from msgspec import inspect

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.model.collisions import collision_pairs
from warpmuscle.model.objective import counted_terms
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import constant, free_parameters, rebuilt
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.checks import Checks
from warpmuscle.scene.validation.scene import check_scene

_SCENE = inspect.type_info(Scene)


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
                ends = [_interval(number, partial(check, index)) for index, number in enumerate(theirs)]
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


def _interval(number: float | Free, check: Callable[[], Checks]) -> tuple[float, float]:
    """See `Checks.interval`; what follows nothing needs no look at its scene."""
    if isinstance(number, Free):
        return check().interval(number) if number.same_as or number.per else number.interval({})
    return number, number


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
