"""The elements of an XML file with their lines, within bounds of size, number and depth."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from warpmuscle.core.errors import SceneError, shortened
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import GREATEST_NUMBER, check_size
from warpmuscle.core.plain_text import number_of

UTF_16 = (b"\xff\xfe", b"\xfe\xff")
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
LOOSE = re.compile(r"&(?!\w+;|#\w+;)", re.ASCII)  # an ampersand that begins no character's name
STRAY = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
BRACKETS = re.compile(r"\(([^()]*)\)")
INFINITE = {"inf": float("inf"), "infinity": float("inf")}


@dataclass(slots=True, eq=False)
class Element:
    """An element, its name as OpenSim's objects have one, and whether anybody has asked for it."""

    tag: str
    file: Path
    line: int
    name: str = ""
    text: str = ""
    children: list[Element] = field(default_factory=list)
    used: bool = False

    def fail(self, message: str) -> NoReturn:
        """Raise SceneError at this element."""
        raise SceneError(shortened(f"{self.what}: {message}"), file=self.file, line=self.line)

    @property
    def what(self) -> str:
        """Tag and name, for messages."""
        return f"<{self.tag}>" + (f" {self.name!r}" if self.name else "")

    def child(self, *tags: str) -> Element | None:
        """The last child with one of these tags, as OpenSim reads it; it counts as used."""
        found = None
        for child in self.children:
            if child.tag in tags:
                found, child.used = child, True
        return found

    def all(self) -> Iterator[Element]:
        """This element and all within it."""
        rest = [self]
        while rest:
            element = rest.pop()
            yield element
            rest.extend(reversed(element.children))

    def objects(self) -> list[Element]:
        """The members of a set, which stand in its `objects`; all within the set counts as asked for."""
        inner = self.child("objects")
        self.child("groups")
        members = inner.children if inner is not None else []
        for member in members:
            member.used = True
        return members

    def words(self) -> list[str]:
        """Its text in words."""
        self.used = True
        return self.text.split()

    def word(self) -> str:
        """Its text as one word, which is a name and may have blanks in it."""
        self.used = True
        return self.text.strip()

    def numbers(self, count: int | None = None, infinite: bool = False) -> list[float]:
        """Its text as numbers, as many as wanted, finite ones unless infinite ones may be.

        As in OpenSim, a list of any length may have commas and stand in brackets, and one of a certain length may have
        commas behind its numbers.
        """
        words = self.words()
        if count is None:
            inner = BRACKETS.fullmatch(self.text.strip())
            words = (inner.group(1) if inner else self.text).replace(",", " ").split()
        elif count != len(words):
            self.fail(f"needs {number_of(count, 'number')}, has {len(words)}")
        return [self._number(word.rstrip(","), infinite) for word in words]

    def number(self, infinite: bool = False) -> float:
        """Its text as one number."""
        return self.numbers(1, infinite)[0]

    def truth(self) -> bool:
        """Its text as true or false."""
        word = self.word().lower()
        if word not in ("true", "false", "1", "0"):
            self.fail(f"is true or false, not {word!r}")
        return word in ("true", "1")

    def _number(self, word: str, infinite: bool) -> float:
        value = float(word) if NUMBER.fullmatch(word) else INFINITE.get(word.lower().lstrip("+-"), float("nan"))
        if word.startswith("-") and value == float("inf"):
            value = -value
        if value != value or (abs(value) == float("inf") and not infinite):
            self.fail(f"{word!r} is not a finite number" if value == value else f"{word!r} is not a number")
        if abs(value) > GREATEST_NUMBER and not infinite:
            self.fail(f"{word} is beyond {GREATEST_NUMBER:g}, the greatest number that is read")
        return value + 0.0  # -0.0 becomes 0.0


def parse(path: Path) -> Element:
    """The root element of a file.

    Raises:
        SceneError: it cannot be read, is no XML, declares a type or entities, or is beyond a limit; with file and line.
    """
    text = _text(path)
    try:
        return _Parser(path, text).root
    except _Unsound as first:
        try:
            return _Parser(path, mended(text)).root
        except _Unsound:
            raise first.error from None


def mended(text: str) -> str:
    """A text as the parsers of OpenSim and MuJoCo take it, with as many lines.

    They take two hyphens and `<` within comments, ampersands alone, bytes that are no characters, and whatever stands
    before and behind the elements.
    """
    text = COMMENT.sub(lambda found: "\n" * found.group().count("\n"), text)
    text = LOOSE.sub("&amp;", STRAY.sub(" ", text))
    start = text.find("<")
    before = text[: max(start, 0)].count("\n")
    body = text[max(start, 0) :]
    end = body.rfind(">") + 1
    if before and body.startswith("<?xml"):  # a declaration must be the first thing
        body, end = body[body.find("?>") + 2 :], end - body.find("?>") - 2
    return "\n" * before + body[:end]


class _Unsound(Exception):
    """A text is not XML, which may be mended."""

    def __init__(self, error: SceneError) -> None:
        super().__init__()
        self.error = error


def _text(path: Path) -> str:
    """Text of a file in UTF-8, UTF-16 with its mark, or else Latin-1, as old files have in names of authors."""
    try:
        data = read_file(path, "model")
    except (OSError, ValueError) as error:
        raise SceneError(unreadable(error), file=path) from None
    if data.startswith(UTF_16):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


class _Parser:
    """Builds the tree of one text."""

    def __init__(self, path: Path, text: str) -> None:
        self._path, self._count = path, 0
        self._open: list[Element] = []
        self._texts: list[list[str]] = []
        self._expat = expat.ParserCreate("utf-8")
        self._expat.buffer_text = True
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.CharacterDataHandler = self._characters
        self._expat.StartDoctypeDeclHandler = self._doctype
        self._root: Element | None = None
        self.root: Element
        try:
            self._expat.Parse(text.encode("utf-8", errors="replace"), True)
        except expat.ExpatError as error:
            message = f"not sound XML: {expat.ErrorString(error.code)}"
            raise _Unsound(self._error(message, error.lineno)) from None
        assert self._root is not None  # or there would have been an error
        self.root = self._root

    def _error(self, message: str, line: int = 0) -> SceneError:
        return SceneError(message, file=self._path, line=line or self._expat.CurrentLineNumber)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        check_size("elements", self._count, self._error)
        check_size("nesting", len(self._open) + 1, self._error)
        name = attributes.get("name", attributes.get("Version", "") if not self._open else "")
        element = Element(tag, self._path, self._expat.CurrentLineNumber, name.strip())
        if "file" in attributes:
            element.fail("stands in a file of its own; save the model whole from OpenSim")
        if self._open:
            self._open[-1].children.append(element)
        self._root = self._root or element
        self._open.append(element)
        self._texts.append([])

    def _end(self, tag: str) -> None:
        self._open.pop().text = "".join(self._texts.pop())

    def _characters(self, text: str) -> None:
        self._texts[-1].append(text)

    def _doctype(self, *_: object) -> None:
        raise self._error("a model has no document type; remove <!DOCTYPE>")
