"""Scenes as small files based on other scenes: only what differs, and curves through several scenes' numbers."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.toml_layout import inline, key_text
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import at_start, leaves

OF_SCENE = ("name", "description")  # what a scene says of itself


def on_base(scene: Scene, base: Scene, base_name: str, comment: Sequence[str] = ()) -> str:
    """A scene as TOML text that takes from a base all that is the same there.

    Args:
        scene: sound scene. base: the scene called `base_name`, from which it differs in single values only.
        comment: lines to begin with.

    Raises:
        SceneError: the scenes differ in more than single values.
    """
    return _text(scene, base_name, _differences(scene, base, base_name), comment)


def over(scenes: Sequence[Scene], key: str, base: Scene, base_name: str, comment: Sequence[str] = ()) -> str:
    """Scenes with different values of one number as one scene, in which that one is free and what else differs follows.

    Args:
        scenes: two or more, which differ in numbers only. key: path of the number; it starts from the first scene's.
        base, base_name, comment: see `on_base`.

    Raises:
        SceneError: not all have a number of their own at the key, or they differ in more than numbers.
    """
    tables = [dict(leaves(at_start(scene))) for scene in scenes]
    at = [float(table[key]) for table in tables if isinstance(table.get(key), int | float)]
    if len(at) < len(scenes) or len(set(at)) < max(len(at), 2):
        raise SceneError("each of two or more scenes needs a number of its own here", key=key)
    order = np.argsort(at)
    mine: dict[str, Any] = {}
    for path, leaf in leaves(scenes[0]):
        values = [table.get(path) for table in tables]
        if path == key:
            mine[path] = Free(at[0], min(at), max(at))
        elif all(value == values[0] for value in values) or path in OF_SCENE:
            mine[path] = values[0]
        elif isinstance(leaf, int | float | Free) and not isinstance(leaf, bool):
            mine[path] = Free(same_as=key, through=tuple((at[index], float(values[index])) for index in order))
        else:
            raise SceneError("the scenes differ in more than numbers", key=path)
    return _text(scenes[0], base_name, _changes(mine, dict(leaves(base)), base_name), comment)


def _differences(scene: Scene, base: Scene, base_name: str) -> dict[str, Any]:
    """Leaves of the scene, by path, that the base has not, or otherwise."""
    mine, theirs = dict(leaves(scene)), dict(leaves(base))
    alone = [path for path in (*mine, *theirs) if path not in mine or path not in theirs]
    if alone:
        raise SceneError(f"this is not in both {scene.name} and {base_name}, on which it should be based", key=alone[0])
    return _changes(mine, theirs, base_name)


def _changes(mine: Mapping[str, Any], theirs: Mapping[str, Any], base_name: str) -> dict[str, Any]:
    """What differs, by path: a leaf, or the fields of a number in which it is not as theirs."""
    found: dict[str, Any] = {}
    for path, leaf in mine.items():
        other = theirs.get(path)
        if leaf == other:
            continue
        if leaf is None:
            raise SceneError(f"{base_name} says something here that cannot be taken back", key=path)
        if (whole := _plain_list(mine, theirs, path)) is not None:
            found[path.rpartition(".")[0]] = whole  # the base may have it by default only, without items to change
        elif isinstance(leaf, Free) and isinstance(other, Free) and bool(other.same_as) == bool(leaf.same_as):
            names = (field.name for field in msgspec.structs.fields(leaf))
            found[path] = {name: getattr(leaf, name) for name in names if getattr(leaf, name) != getattr(other, name)}
        else:
            found[path] = leaf
    return found


def _plain_list(mine: Mapping[str, Any], theirs: Mapping[str, Any], path: str) -> list[Any] | None:
    """The whole list of an item that is one of plain values in the base; None for other leaves."""
    parent, _, index = path.rpartition(".")
    if not index.isdigit():
        return None
    paths = list(itertools.takewhile(lambda item: item in mine, (f"{parent}.{k}" for k in itertools.count())))
    if not paths or any(isinstance(theirs.get(item), Free) for item in paths):
        return None
    return [mine[item] for item in paths]


def _text(scene: Scene, base_name: str, changes: Mapping[str, Any], comment: Sequence[str]) -> str:
    lines = [*(f"# {line}" for line in comment), *([""] if comment else []), f"name = {inline(scene.name)}"]
    lines += [f"base = {inline(base_name)}", f"description = {inline(scene.description)}"]
    tables: dict[tuple[str, ...], list[str]] = {(): []}
    for path, leaf in changes.items():
        if path not in OF_SCENE:
            *table, name = path.split(".")
            tables.setdefault(tuple(table), []).append(f"{key_text(name)} = {inline(leaf)}")
    lines += tables.pop(())
    for table_path, rows in tables.items():
        lines += ["", f"[{'.'.join(map(key_text, table_path))}]", *rows]
    return "\n".join(lines) + "\n"
