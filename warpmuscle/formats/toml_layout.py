"""TOML text laid out for people: a table a body or joint, rows in columns, numbers without noise."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import msgspec

from warpmuscle.core.files import shown
from warpmuscle.scene import Part
from warpmuscle.scene.number import Free

WIDTH = 150  # longest line that holds a whole table
LIST_WIDTH = 100  # longest line that holds a list of tables, or many numbers
ITEM_WIDTH = 80  # longest table that is a line of a list, such as a via point
Text = Callable[[Any], str]  # of a value, on one line


def layout(part: Part, instead: dict[str, Any] | None = None) -> str:
    """A structure as TOML text.

    A table or list goes on one line if it fits, else its members get lines or tables of their own; members of a table
    that keys of the user's choice name, such as the bodies, stay in order, and short ones line up in columns.

    Args:
        part: what to write; members that equal their defaults are left out.
        instead: what to write for some of its members instead.
    """
    lines: list[str] = []
    plain = _plain(part) | (instead or {})
    _write_table(plain, (), lines, _Texts().of)
    return "\n".join(lines).strip("\n") + "\n"


class _Named(dict[str, Any]):
    """A table whose keys are names that the user chose, in an order that matters."""


def _plain(value: Any) -> Any:
    """Structures as dicts, tables with chosen keys as `_Named`, free parameters as they are."""
    if isinstance(value, Free):
        return value
    if isinstance(value, msgspec.Struct):
        config = value.__struct_config__
        tag = {config.tag_field: config.tag} if config.tag_field else {}
        return tag | _plain_fields(value)
    if isinstance(value, dict):
        return _Named({name: _plain(member) for name, member in value.items()})
    if isinstance(value, list | tuple):
        return [_plain(member) for member in value]
    return value


_fields = cache(msgspec.structs.fields)


def _plain_fields(part: msgspec.Struct) -> dict[str, Any]:
    """Fields of a structure without what equals its default."""
    plain = {}
    for field in _fields(type(part)):
        member = getattr(part, field.name)
        default = field.default_factory() if field.default_factory is not msgspec.NODEFAULT else field.default
        if field.required or member != default:
            plain[field.name] = _plain(member)
    return plain


class _Texts:
    """Values of a plain tree on one line, each made once: tables are measured at every depth."""

    def __init__(self) -> None:
        self._known: dict[int, str] = {}

    def of(self, value: Any) -> str:
        """See `inline`."""
        if not isinstance(value, dict | list):
            return inline(value)
        text = self._known.get(id(value))
        if text is None:
            text = self._known[id(value)] = _inline(value, self.of)
        return text


def _write_table(
    table: dict[str, Any], path: tuple[str, ...], lines: list[str], text: Text, header: str = ""
) -> None:  # fmt: skip
    """Lines of a table: what fits on one line first, then tables of their own for the others."""
    rows = {key: f"{key_text(key)} = {text(member)}" for key, member in table.items()}
    own = [key for key, member in table.items() if _is_long(member, rows[key], len(path) + 1, text)]
    if own and isinstance(table, _Named):
        own = list(table)  # none on a line, to keep the order
    short = [key for key in table if key not in own]
    if header and (short or not table or header.startswith("[[")):
        lines.extend(["", header])
    if isinstance(table, _Named) and short:
        lines.extend(_columns(table, text))
    else:
        lines.extend(rows[key] if len(rows[key]) <= LIST_WIDTH else _folded(key, table[key], text) for key in short)
    for key in sorted(own, key=lambda key: isinstance(table[key], list)):
        inner, member = (*path, key), table[key]
        name = ".".join(map(key_text, inner))
        if isinstance(member, list):
            for item in member:
                _write_table(item, inner, lines, text, f"[[{name}]]")
        else:
            _write_table(member, inner, lines, text, f"[{name}]")


def _is_long(member: Any, row: str, depth: int, text: Text) -> bool:
    """Whether a member gets tables of its own, as those with chosen names and all at the top level do."""
    if isinstance(member, list):
        tables = [item for item in member if isinstance(item, dict)]
        return len(row) > LIST_WIDTH and any(len(text(item)) > ITEM_WIDTH for item in tables)
    if isinstance(member, _Named) and member:
        return depth < 3 or len(row) > WIDTH
    return isinstance(member, dict) and (len(row) > WIDTH or depth == 1)


def _columns(table: dict[str, Any], text: Text) -> list[str]:
    """Rows `key = { a = 1, b = 2 }`, their cells padded to line up where all rows have the same members."""
    names = [key_text(key) for key in table]
    width = max(map(len, names), default=0)
    members = list(table.values())
    if not all(isinstance(member, dict) for member in members):
        return [f"{key_text(key)} = {text(member)}" for key, member in table.items()]
    fields = list(dict.fromkeys(field for member in members for field in member))
    cells = {
        field: [f"{key_text(field)} = {text(m[field])}" if field in m else "" for m in members] for field in fields
    }
    widths = {field: max(map(len, column)) + 1 for field, column in cells.items()}
    rows = []
    for index, name in enumerate(names):
        present = [field for field in fields if cells[field][index]]
        row = ""
        for field in present:
            cell = cells[field][index] + ("" if field == present[-1] else ",")
            row += cell.ljust(widths[field] + 1) if field != present[-1] else cell
        rows.append(f"{name.ljust(width)} = {{ {row.strip()} }}" if row else f"{name.ljust(width)} = {{}}")
    return rows


def _folded(key: str, values: Any, text: Text) -> str:
    """A long list over several lines; anything else on one."""
    if not isinstance(values, list):
        return f"{key_text(key)} = {text(values)}"
    if any(isinstance(value, dict) for value in values):
        return "\n".join([f"{key_text(key)} = [", *(f"    {text(value)}," for value in values), "]"])
    lines, row = [f"{key_text(key)} = ["], "   "
    for value in values:
        item = f" {text(value)},"
        if len(row) + len(item) > LIST_WIDTH:
            lines.append(row)
            row = "   "
        row += item
    return "\n".join([*lines, row, "]"])


def inline(value: Any) -> str:
    """A value on one line."""
    return _inline(value, inline)


def _inline(value: Any, text: Text) -> str:
    """The same, made of the texts of its members."""
    if isinstance(value, Free):
        value = _plain_fields(value)
    if isinstance(value, dict):
        members = ", ".join(f"{key_text(key)} = {text(member)}" for key, member in value.items())
        return f"{{ {members} }}" if members else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(text, value))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    return shown(value)


@cache
def _text(value: str) -> str:
    import tomlkit  # which those who only read do not wait for

    return tomlkit.item(value).as_string()


@cache
def key_text(name: str) -> str:
    """A key as it is written, in quotes if need be."""
    import tomlkit

    return tomlkit.key(name).as_string() if name else '""'
