"""Plain data into typed data, with errors that name the offending key in plain words."""

from __future__ import annotations

import difflib
import re
import sys
from typing import Any, TypeVar

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of

T = TypeVar("T")

WORDS = {
    "float": "a number", "int": "a whole number", "str": "text", "bool": "true or false", "array": "a list",
    "object": "a table", "null": "nothing", "datetime": "a date and time", "date": "a date", "time": "a time",
}  # fmt: skip
# Numbers may be free parameters, which a user need not hear of as an alternative type each time.
PHRASES = {
    "float | object": "a number",
    "float | null": "a number",
    "float | object | null": "a number",
    "object | null": "a table",
    "array | null": "a list",
    "str | null": "text",
}


def to_type(data: Any, type_: type[T], key: str = "") -> T:
    """`data`, made of dicts, lists and plain values, as a value of a structure type.

    Args:
        data: what a file holds.
        type_: the structure type wanted.
        key: path of `data` within the scene, put before the keys in errors.

    Raises:
        SceneError: with the full key of what does not fit.
    """
    try:
        return msgspec.convert(data, type_)
    except (msgspec.ValidationError, OverflowError, RecursionError) as error:
        text, _, path = str(error).partition(" - at `")
        keys = _keys(data, type_, str(error), path.rstrip("`")) if path else []
        raise _explained(text, data, type_, [key] if key else [], keys) from None
    except SystemError as error:  # of msgspec before 0.22, which goes on after a whole number that no float holds
        beyond = _beyond(data)
        if beyond is None:
            raise
        raise SceneError("number out of range", key=".".join([key, *beyond] if key else beyond)) from error


def _beyond(data: Any) -> list[str] | None:
    """Path of the first whole number that no float holds; None where there is none."""
    if isinstance(data, int):
        return [] if abs(data) > sys.float_info.max else None
    members = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    for key, value in members:
        if (path := _beyond(value)) is not None:
            return [str(key), *path]
    return None


def _keys(data: Any, type_: type[Any], message: str, path: str) -> list[str]:
    """The path of an error as keys; msgspec writes `[...]` for a key of a table, which is found by trying them."""
    keys: list[str] = []
    for part in re.findall(r"\.([A-Za-z_0-9]+)|\[([0-9]+|\.\.\.)\]", path):
        name = part[0] or part[1]
        if name == "...":
            table = _get(data, keys)
            candidates = list(table) if isinstance(table, dict) else []
            found = next((k for k in candidates if _fails_alike(data, type_, keys, k, message)), None)
            if found is None:
                return keys
            data = _with(data, keys, {found: table[found]})
            name = found
        keys.append(name)
    return keys


def _fails_alike(data: Any, type_: type[Any], keys: list[str], only: str, message: str) -> bool:
    """Whether the same error comes up when the table at `keys` holds the key `only` alone."""
    try:
        msgspec.convert(_with(data, keys, {only: _get(data, keys)[only]}), type_)
    except (msgspec.ValidationError, OverflowError, RecursionError) as error:
        return str(error) == message
    return False


def _get(data: Any, keys: list[str]) -> Any:
    """The value at a path, None if there is none."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(key)
        elif isinstance(data, list | tuple) and key.isdigit() and int(key) < len(data):
            data = data[int(key)]
        else:
            return None
    return data


def _with(data: Any, keys: list[str], value: Any) -> Any:
    """A copy of `data` with another value at a path."""
    if not keys:
        return value
    if isinstance(data, dict):
        return data | {keys[0]: _with(data[keys[0]], keys[1:], value)}
    index = int(keys[0])
    return [_with(item, keys[1:], value) if i == index else item for i, item in enumerate(data)]


def _explained(text: str, data: Any, type_: type[Any], prefix: list[str], keys: list[str]) -> SceneError:
    """The error in plain words, with its key."""
    path = ".".join(prefix + keys)
    if unknown := re.fullmatch(r"Object contains unknown field `(.*)`", text, re.DOTALL):
        name, known = unknown[1], _fields(type_, data, keys)
        has_parameters = "parameters" in known
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.75 if has_parameters else 0.6)
        hint = f"numbers of its kind belong into parameters = {{ {name} = ... }}; " if has_parameters else ""
        hint = f"did you mean {near[0]!r}? " if near else hint
        if keys and not prefix and name in _fields(type_, data, []):
            hint = "it is one of the whole file and belongs above the first table; "
        known_keys = f"known keys: {', '.join(known)}" if known else "no key is known here"
        return SceneError(f"unknown key; {hint}{known_keys}", key=".".join([*prefix, *keys, name]))
    if missing := re.fullmatch(r"Object missing required field `(.*)`", text):
        return SceneError(f"missing key {missing[1]!r}", key=path)
    if length := re.fullmatch(r"Expected `array` of length (\d+), got (\d+)", text):
        return SceneError(f"expected {number_of(int(length[1]), 'value')}, got {length[2]}", key=path)
    if kind := re.fullmatch(r"Expected `(.*)`, got `(.*)`", text):
        return SceneError(f"expected {_words(kind[1])}, got {_words(kind[2])}", key=path)
    if value := re.fullmatch(r"Invalid (?:enum )?value '?(.*?)'?", text, re.DOTALL):
        known = _choices(type_, data, keys)
        near = difflib.get_close_matches(value[1], known, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        return SceneError(f"{value[1]!r} is none of {', '.join(map(repr, known))}{hint}", key=path)
    return SceneError(text[:1].lower() + text[1:], key=path)


def _words(types: str) -> str:
    """A type of msgspec's messages in plain words."""
    return PHRASES.get(types) or " or ".join(WORDS.get(name, name) for name in types.split(" | "))


def _type_at(type_: type[Any], data: Any, keys: list[str]) -> list[msgspec.inspect.Type]:
    """The types that a value at a path may have."""
    types: list[msgspec.inspect.Type] = [msgspec.inspect.type_info(type_)]
    for depth, key in enumerate(keys):
        types = [inner for one in types for inner in _inside(one, key, _get(data, keys[:depth]))]
    return [inner for one in types for inner in _alternatives(one)]


def _alternatives(type_: msgspec.inspect.Type) -> list[msgspec.inspect.Type]:
    return list(type_.types) if isinstance(type_, msgspec.inspect.UnionType) else [type_]


def _inside(type_: msgspec.inspect.Type, key: str, value: Any) -> list[msgspec.inspect.Type]:
    """The types that the member `key` of `value` may have."""
    match type_:
        case msgspec.inspect.UnionType(types=types):
            return [inner for one in types if _tagged_as(one, value) for inner in _inside(one, key, value)]
        case msgspec.inspect.StructType(fields=fields):
            return [field.type for field in fields if field.encode_name == key]
        case msgspec.inspect.DictType(value_type=inner):
            return [inner]
        case msgspec.inspect.ListType(item_type=inner):
            return [inner]
        case msgspec.inspect.TupleType(item_types=inners):
            return list(inners[int(key) : int(key) + 1]) if key.isdigit() else []
    return []


def _tagged_as(type_: msgspec.inspect.Type, value: Any) -> bool:
    """Whether a table can be of this type, going by its tag."""
    if not isinstance(type_, msgspec.inspect.StructType) or type_.tag_field is None or not isinstance(value, dict):
        return True
    return value.get(type_.tag_field) in (type_.tag, None)


def _fields(type_: type[Any], data: Any, keys: list[str]) -> list[str]:
    """Names that a table at a path may have."""
    names: list[str] = []
    value = _get(data, keys)
    for one in _type_at(type_, data, keys):
        if isinstance(one, msgspec.inspect.StructType) and _tagged_as(one, value):
            names += [one.tag_field] if one.tag_field else []
            names += [field.encode_name for field in one.fields]
    return list(dict.fromkeys(names))


def _choices(type_: type[Any], data: Any, keys: list[str]) -> list[str]:
    """Values that a text at a path may have: those of a literal, or the tags of a tagged table."""
    literals = [one for one in _type_at(type_, data, keys) if isinstance(one, msgspec.inspect.LiteralType)]
    choices = sorted(str(value) for one in literals for value in one.values)
    for one in _type_at(type_, data, keys[:-1]) if keys else []:
        if isinstance(one, msgspec.inspect.StructType) and one.tag_field == keys[-1]:
            choices.append(str(one.tag))
    return choices
