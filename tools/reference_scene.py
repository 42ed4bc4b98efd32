"""The page of the reference that has every structure of a scene with its fields."""

from __future__ import annotations

import inspect
import json
import re
import types
import typing
from typing import Any

import msgspec
from reference_text import table

from warpmuscle.formats.schema import notes, unit_of
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free, Number, Vector


def scene() -> str:
    """Every structure of a scene with its fields, from the scene downwards."""
    pages = [
        "# Scene", "", *SCENE_INTRODUCTION, "",
    ]  # fmt: skip
    for part in structures():
        pages += [f"## {part.__name__}", "", re.sub(r"\s*\n\s*\n\s*", "\n\n", inspect.getdoc(part) or ""), ""]
        rows = []
        hints = typing.get_type_hints(part)
        tag = part.__struct_config__.tag
        if tag:
            rows.append(("`type`", f'`"{tag}"`', "", "", ""))
        for field in msgspec.structs.fields(part):
            said = notes(part).get(field.name, "") or summary_of(hints[field.name])
            row = (f"`{field.name}`", kind(hints[field.name]), unit_of(part, field.name), default(field), said)
            rows.append(row)
        pages += [table(("field", "type", "unit", "default", "meaning"), rows), ""]
    return "\n".join(pages)


SCENE_INTRODUCTION = (
    "A scene is a TOML file whose fields are those of [Scene](#scene_1). Units are SI and radians; y is up, x to the",
    "left, z forward; quaternions are x, y, z, w. Every *number* may also be a table that makes it a free parameter,",
    "see [Free](#free). `base` names another scene, a file or a shipped one, from which a file takes all that it does",
    "not say itself; `character` may be the name of a file, or a list of files whose tables add up. A list may be",
    "written as a table of the items that change, counted from 0: `[controller.states.0]`.",
    "",
    "`warpmuscle schema` writes the same as a [JSON schema](scene.schema.json), which editors complete from:",
    "see [how to edit with completion](../how-to/edit-with-completion.md).",
)


def summary_of(hint: Any) -> str:
    """The first sentence of what the structures of a field are, if they are of one kind."""
    found = [inner for inner in (hint, *typing.get_args(hint)) if isinstance(inner, type) and inner is not Free]
    of_scene = [inner for inner in found if issubclass(inner, msgspec.Struct)]
    return (inspect.getdoc(of_scene[0]) or "").split(". ")[0].splitlines()[0].rstrip(".") if len(of_scene) == 1 else ""


def structures() -> list[type]:
    """The structures that a scene may have, each after the one that names it first."""
    found: list[type] = []

    def follow(hint: Any) -> None:
        known = (*found, Free)
        if isinstance(hint, type) and issubclass(hint, msgspec.Struct) and hint not in known:
            found.append(hint)
            for inner in typing.get_type_hints(hint).values():
                follow(inner)
        for inner in typing.get_args(hint):
            follow(inner)

    follow(Scene)
    return [*found, Free]


def kind(hint: Any) -> str:
    """A type in words."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if hint == Number:
        return "number"
    if hint == Vector:
        return "3 numbers"
    if origin is typing.Literal:
        return ", ".join(f'`"{word}"`' for word in inner)
    if origin in (typing.Union, types.UnionType):
        if set(typing.get_args(Number)) <= set(inner):
            inner = (Number, *(i for i in inner if i not in typing.get_args(Number)))
        return " or ".join(dict.fromkeys(kind(i) for i in inner if i is not type(None)))
    if origin is list:
        return f"list of {kind(inner[0])}"
    if origin is dict:
        return f"table of {kind(inner[1])} by name"
    if origin is tuple:
        return f"list of {kind(inner[0])}" if inner[-1] is ... else f"{len(inner)} of {kind(inner[0])}"
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        anchor = "scene_1" if hint is Scene else hint.__name__.lower()
        return f"[{hint.__name__}](#{anchor})"
    return {float: "fixed number", int: "whole number", str: "text", bool: "true or false"}.get(hint, str(hint))


def default(field: Any) -> str:
    """A default as TOML has it; empty if there is none, or it says nothing."""
    value = field.default if field.default is not msgspec.NODEFAULT else None
    if field.default is msgspec.NODEFAULT and field.default_factory is msgspec.NODEFAULT:
        return "needed"
    if value is None or value == "" or isinstance(value, msgspec.Struct):
        return ""
    return f"`{json.dumps(value)}`"
