"""The text that SCONE and Hyfydy write their files in: keys with values or with more keys in braces, with their lines.

    key = value    key { ... }    key [ ... ]    # comment    /* comment */    << file that stands here >>
    $name = value    key = $name    key = "words with ${name} in them"

A `$name` is known from where it is given a value on to the end of the braces, or of the file, in which that stands, and
in files that are included there. Files that are included lie in the folder of the first one, or below it. Files of the
years before 2019 have `; comment`, `#include "file"`, and `type = Kind` in a block where others have its kind as key.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import NoReturn

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.limits import GREATEST_NUMBER, check_size
from warpmuscle.formats.lines import NUMBER, Notes, read_text

TOKEN = re.compile(
    r"""\#include\s*"(?P<included>[^"\n]*)"
    |(?P<space>\s+|(?:\#|//|;)[^\n]*|/\*.*?\*/)
    |"(?P<text>[^"\n]*)"
    |'(?P<quoted>[^'\n]*)'
    |<<(?P<file>[^<>\n]*)>>
    |(?P<mark>[{}\[\]=])
    |(?P<word>(?!/\*)[^\s{}\[\]="\#]+)""",
    re.VERBOSE | re.DOTALL,
)
CLOSING = {"{": "}", "[": "]"}
WITHIN = re.compile(r"\$\{([^{}\s]*)\}")
SAME = {"quoted": "text", "included": "file"}  # kinds of tokens that others mean
KINDS = ("Optimizer", "Objective", "Model", "Controller", "Measure", "Reflex")  # keys of blocks that say their `type`


@dataclass(slots=True, eq=False)
class Node:
    """A key with its value, or with what stands in its braces; members of a list have an empty key."""

    key: str
    file: Path
    line: int
    value: str | None = None
    children: list[Node] = field(default_factory=list)
    used: bool = False  # whether anybody has asked for it

    def fail(self, message: str) -> NoReturn:
        """Raise SceneError at this node."""
        raise SceneError(shortened(f"{self.key}: {message}" if self.key else message), file=self.file, line=self.line)

    def find(self, *keys: str) -> Node | None:
        """The last child of one of these keys, which counts as used."""
        found = None
        for child in self.children:
            if child.key in keys:
                found, child.used = child, True
        return found

    def every(self, *keys: str) -> list[Node]:
        """All children of these keys, which count as used."""
        found = [child for child in self.children if child.key in keys]
        for child in found:
            child.used = True
        return found

    def need(self, key: str) -> Node:
        """The child of a key."""
        found = self.find(key)
        if found is None:
            self.fail(f"there is no `{key}` in it")
        return found

    def text(self) -> str:
        """Its value."""
        if self.value is None:
            self.fail("a value is needed, not braces")
        return self.value

    def number(self) -> float:
        """Its value as a finite number."""
        return self.number_in(self.text())

    def number_in(self, word: str) -> float:
        """A word of it as a finite number."""
        value = float(word) if NUMBER.fullmatch(word) else math.nan
        if not abs(value) <= GREATEST_NUMBER:
            what = f"is beyond {GREATEST_NUMBER:g}" if NUMBER.fullmatch(word) else "is not a number"
            self.fail(f"{word!r} {what}")
        return value + 0.0

    def truth(self) -> bool:
        """Its value as true or false."""
        word = self.text().lower()
        if word not in ("0", "1", "true", "false"):
            self.fail(f"is 0 or 1, not {word!r}")
        return word in ("1", "true")

    def string_of(self, key: str, default: str = "") -> str:
        """The value of a child, or the default."""
        found = self.find(key)
        return default if found is None else found.text()

    def number_of(self, key: str, default: float) -> float:
        """The number of a child, or the default."""
        found = self.find(key)
        return default if found is None else found.number()

    def truth_of(self, key: str, default: bool) -> bool:
        """Whether a child says yes, or the default."""
        found = self.find(key)
        return default if found is None else found.truth()

    def vector_of(self, key: str, default: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[float, float, float]:
        """A child with x, y and z, or with a list of three numbers, or with three in quotes."""
        found = self.find(key)
        if found is None:
            return default
        if found.value is not None and len(words := found.value.split()) == 3:
            x, y, z = (found.number_in(word) for word in words)
        elif all(child.key == "" for child in found.children) and len(found.children) == 3:
            x, y, z = (child.number() for child in found.every(""))
        else:
            x, y, z = (found.number_of(axis, default[index]) for index, axis in enumerate("xyz"))
        found.tell_unused("a vector has x, y and z")
        return x, y, z

    def tell_unused(self, hint: str = "") -> None:
        """SceneError at the first child that nobody has asked for."""
        for child in self.children:
            if not child.used:
                inside = f"`{self.key}`" if self.key else "this block"
                child.fail(f"not known in {inside}" + (f"; {hint}" if hint else ""))

    def all(self) -> Iterator[Node]:
        """This node and all within it."""
        rest = [self]
        while rest:
            node = rest.pop()
            yield node
            rest.extend(reversed(node.children))


def parse(path: Path, notes: Notes) -> Node:
    """A node whose children are what stands in a file, and in those that it includes.

    Raises:
        SceneError: with file and line.
    """
    return _Reader(path, notes).read()


class _Reader:
    """Reads one file with all that it includes; counts what there is of it together."""

    def __init__(self, path: Path, notes: Notes) -> None:
        self._path, self._notes = path, notes
        self._folder = path.absolute().parent
        self._elements = 0
        self.values: dict[str, Node] = {}  # by `$name`

    def read(self) -> Node:
        top = Node("", self._path, 1)
        top.children = self._file(self._path, ())
        return top

    def _file(self, path: Path, within: tuple[Path, ...]) -> list[Node]:
        """What stands in a file, which files include within each other."""
        return _File(path, self, (*within, path.absolute())).nodes()

    def count(self, node: Node) -> None:
        """One more element."""
        self._elements += 1
        check_size("elements", self._elements, lambda text: SceneError(text, file=node.file, line=node.line))

    def included(self, name: str, at: Node, within: tuple[Path, ...]) -> list[Node]:
        """What stands in an included file."""
        self.count(at)
        name = name.strip()
        path = find_beside(name, at, self._folder, self._notes)
        if path.absolute() in within:
            at.fail(f"{name!r} includes itself")
        check_size("bases", len(within), lambda text: SceneError(text, file=at.file, line=at.line))
        return self._file(path, within)


def find_beside(name: str, at: Node, folder: Path, notes: Notes, suffixes: tuple[str, ...] = ()) -> Path:
    """The file that a node names: from its own folder, or by the end of its path, and not outside of a folder.

    Args:
        suffixes: others that it may have instead.
    """
    name = name.strip().strip('"').strip()
    named = PurePosixPath(name.replace("\\", "/"))
    parts = named.parts
    if not parts or not str(named).isprintable() or len(str(named)) > 1000:
        at.fail(f"{name!r} is not the name of a file")
    if named.is_absolute() or ".." in parts or ":" in parts[0]:
        at.fail(f"{name!r} leads out of the folder; name a file in it or below")
    inside = folder.resolve()
    own = at.file.absolute().parent
    for base in (own, folder):
        for start in range(len(parts)):
            for suffix in (named.suffix, *suffixes):
                found = base.joinpath(*parts[start:]).with_suffix(suffix)
                try:
                    there = found.is_file()
                    where = found.resolve() if there else found
                except (OSError, ValueError, RuntimeError):
                    continue
                if there and not where.is_relative_to(inside):
                    at.fail(f"{name!r} leads out of the folder, to {where}")
                if there:
                    if start > 0 or suffix != named.suffix:
                        notes.ignore(at.file, at.line, f"{at.key} {name}".strip(), f"not there; took {found.name}")
                    return found
    at.fail(f"there is no file {name!r} here")


class _File:
    """The tokens of one file, one after the other."""

    def __init__(self, path: Path, reader: _Reader, within: tuple[Path, ...]) -> None:
        self._path, self._reader, self._within = path, reader, within
        self._tokens = self._scan(read_text(path))
        self._next: tuple[str, str, int] = next(self._tokens)

    def nodes(self) -> list[Node]:
        """All that stands in the file."""
        return self._block("", Node("", self._path, 1), 0)

    def _scan(self, text: str) -> Iterator[tuple[str, str, int]]:
        """Kinds, texts and lines of tokens; at the end one of the kind `end`."""
        place, line = 0, 1
        while place < len(text):
            found = TOKEN.match(text, place)
            if found is None:
                word = text[place : place + 12].split("\n")[0]
                raise SceneError(f"cannot be read from {word!r} on", file=self._path, line=line)
            kind = found.lastgroup or ""
            if kind != "space":
                yield SAME.get(kind, kind), found.group(kind), line
            line += found.group().count("\n")
            place = found.end()
        while True:
            yield "end", "", line

    def _take(self) -> tuple[str, str, int]:
        token, self._next = self._next, next(self._tokens)
        return token

    def _block(self, opening: str, owner: Node, depth: int) -> list[Node]:
        """Nodes up to the bracket that closes a block, or to the end of the file; so far a `$name` of it is known."""
        check_size("nesting", depth, lambda text: SceneError(text, file=owner.file, line=owner.line))
        outside = self._reader.values
        self._reader.values = dict(outside)
        found = self._nodes(opening, owner, depth)
        self._reader.values = outside
        return found

    def _nodes(self, opening: str, owner: Node, depth: int) -> list[Node]:
        """The nodes of a block."""
        closing, found = CLOSING.get(opening, ""), list[Node]()
        while True:
            kind, text, line = self._take()
            node = Node("", self._path, line)
            self._reader.count(node)
            if kind == "end":
                if closing:
                    owner.fail(f"`{opening}` is not closed: the file ends before `{closing}`")
                return found
            if kind == "mark" and text == closing:
                return found
            if kind == "file":
                found += self._reader.included(text, node, self._within)
                continue
            if kind == "mark" and text in CLOSING and opening == "[":
                node.children = self._block(text, node, depth + 1)
            elif kind == "mark":
                node.fail(f"`{text}` does not belong here")
            elif opening == "[" and self._next[:2] != ("mark", "="):
                self._put(node, text)
            else:
                node.key = text
                self._value(node, depth)
                if kind == "word" and text.startswith("$"):
                    self._reader.values[text] = node
                    continue
                if text == "INCLUDE" and (named := node.find("file")) is not None:
                    found += self._reader.included(named.text(), named, self._within)
                    continue
                _say_kind(node)
            found.append(node)

    def _value(self, node: Node, depth: int) -> None:
        """What follows a key: `= value`, or a block."""
        if self._next[:2] == ("mark", "="):
            self._take()
        kind, text, _ = self._next
        if kind == "mark" and text in CLOSING:
            self._take()
            node.children = self._block(text, node, depth + 1)
        elif kind in ("word", "text"):
            self._take()
            self._put(node, text)
        else:
            node.fail("a key is followed by = and a value, or by braces")

    def _put(self, node: Node, text: str) -> None:
        """Give a node a value, or what a `$name` was given."""
        if not text.startswith("$") or text.startswith("${"):
            node.value = WITHIN.sub(lambda found: self._given(node, f"${found[1]}").text(), text)
            return
        given = self._given(node, text)
        node.value, node.children = given.value, [self._copied(child) for child in given.children]

    def _given(self, node: Node, name: str) -> Node:
        """What a `$name` was given."""
        if name not in self._reader.values:
            node.fail(f"{shortened(name)} has no value here: give it one before, as in {shortened(name)} = 0.01")
        return self._reader.values[name]

    def _copied(self, node: Node) -> Node:
        """A node of its own, which counts as unused; what is copied counts as elements."""
        self._reader.count(node)
        children = [self._copied(child) for child in node.children]
        return Node(node.key, node.file, node.line, node.value, children)


def _say_kind(node: Node) -> None:
    """Give a block that says its `type` this as its key."""
    if node.key in KINDS and (kind := next((child for child in node.children if child.key == "type"), None)):
        node.key = kind.text()
        node.children.remove(kind)
