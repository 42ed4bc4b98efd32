"""Line-oriented keyword files: what .rbs, .sbc and .rs have in common.

A keyword is recognised at the start of a line, leading blanks aside, by the first entry of an ordered table that the
line starts with, as in the original program; the rest of the line holds the arguments. `#` starts a comment.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.plain_text import number_of

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


@dataclass(frozen=True)
class Ignored:
    """Something in a file that a reader did not use or a writer could not keep, or a note on what it took instead."""

    file: Path
    line: int  # counted from 1; 0 where no line is meant
    text: str  # the line without surrounding blanks, or the key of a scene that was not written
    reason: str


@dataclass
class Notes:
    """What reading leaves beside the data: what was ignored, and where each key came from."""

    ignored: list[Ignored] = field(default_factory=list)
    places: dict[str, tuple[Path, int]] = field(default_factory=dict)  # by key of the scene

    def ignore(self, file: Path, line: int, text: str, reason: str) -> None:
        """Note what was not used, or was taken otherwise, and why."""
        self.ignored.append(Ignored(file, line, text, reason))

    def placed(self, error: SceneError) -> SceneError:
        """The error with file and line of its key, or of the innermost table around it that has them."""
        key = error.key
        while key and key not in self.places:
            key = key.rpartition(".")[0]
        return error.at(*self.places[key]) if key and error.file is None else error


@dataclass(frozen=True)
class Line:
    """A line that is neither empty nor a comment."""

    file: Path
    number: int
    text: str  # without surrounding blanks
    keyword: str  # empty if the line starts with none of the table
    rest: str  # what follows the keyword

    def error(self, message: str, key: str = "") -> SceneError:
        """An error at this line."""
        return SceneError(message, key, self.file, self.number)

    def ignore(self, notes: Notes, reason: str) -> None:
        """Put this line on the list of what was ignored."""
        notes.ignore(self.file, self.number, self.text, reason)

    def mark(self, notes: Notes, key: str) -> None:
        """Remember that a key of the scene was read from this line."""
        notes.places[key] = (self.file, self.number)

    def word(self, what: str) -> str:
        """The first word after the keyword."""
        words = self.rest.split()
        if not words:
            raise self.error(f"`{self.keyword}` needs {what}")
        return words[0]

    def choice(self, *choices: str) -> str:
        """The first word after the keyword, one of the given ones."""
        word = self.word(" or ".join(choices))
        if word not in choices:
            raise self.error(f"`{self.keyword}` takes {' or '.join(choices)}, not {word!r}")
        return word

    def index(self, what: str) -> int:
        """The first word after the keyword as a whole number."""
        word = self.word(what)
        if not re.fullmatch(r"[+-]?\d{1,9}", word, re.ASCII):
            raise self.error(f"`{self.keyword}` needs {what}, not {word!r}")
        return int(word)

    def numbers(self, count: int, what: str, notes: Notes) -> tuple[float, ...]:
        """The first `count` words after the keyword as finite numbers; what follows them is listed as ignored."""
        words = self.rest.partition("#")[0].split()
        if len(words) < count:
            wanted = f"{number_of(count, 'number')} ({what})"
            raise self.error(f"{self._subject()} needs {wanted}, got {len(words)}")
        if len(words) > count:
            self.ignore(notes, f"only its first {count} value{'s are' if count > 1 else ' is'} used")
        return tuple(self.number_in(word, notes) for word in words[:count])

    def triple(self, what: str, notes: Notes) -> tuple[float, float, float]:
        """The first three words after the keyword as finite numbers."""
        x, y, z = self.numbers(3, what, notes)
        return x, y, z

    def quantity(self, what: str, notes: Notes) -> float:
        """The first word after the keyword as a finite number."""
        return self.numbers(1, what, notes)[0]

    def number_in(self, word: str, notes: Notes) -> float:
        """A word as a finite number, an `s` for seconds behind it left out; SceneError at this line if it is none."""
        if word.endswith("s") and NUMBER.fullmatch(word[:-1]):
            self.ignore(notes, f"the s of {word} is left out")
            word = word[:-1]
        value = float(word) if NUMBER.fullmatch(word) else math.nan
        if not math.isfinite(value):
            raise self.error(f"{self._subject()}: {word!r} is not a {'finite ' if NUMBER.match(word) else ''}number")
        return value + 0.0  # -0.0, as writers of such files produce, is 0.0

    def _subject(self) -> str:
        return f"`{self.keyword}`" if self.keyword else "this line"


class Lines:
    """The lines of a file one after another; blocks share the position."""

    def __init__(self, path: Path, keywords: Sequence[str], notes: Notes) -> None:
        self.path, self.notes = path, notes
        self._lines = iter(list(_lines(path, keywords)))

    def __iter__(self) -> Iterator[Line]:
        """The remaining lines; loops within loops continue where the other one stands."""
        return self._lines

    def block(self, opening: Line, end: str) -> Iterator[Line]:
        """Lines up to the keyword that ends a block; SceneError if the file ends first."""
        for line in self._lines:
            if line.keyword == end:
                return
            yield line
        raise opening.error(f"`{opening.keyword}` is not closed: the file ends before `{end}`")


def read_text(path: Path) -> str:
    """Text of a file, UTF-8 or else Latin-1; SceneError if it cannot be read."""
    try:
        data = read_file(path)
    except (OSError, ValueError) as error:
        raise SceneError(unreadable(error), file=path) from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # comments with accents; keywords and numbers are ASCII either way


def _lines(path: Path, keywords: Sequence[str]) -> Iterator[Line]:
    """Lines that say something, each with its keyword. LF, CR LF and CR end a line, and so does the end of the file."""
    text = read_text(path).replace("\r\n", "\n").replace("\r", "\n")
    for number, raw in enumerate(text.split("\n"), start=1):
        stripped = raw.strip()
        if stripped and not stripped.startswith("#"):
            keyword = next((keyword for keyword in keywords if stripped.startswith(keyword)), "")
            yield Line(path, number, stripped, keyword, stripped[len(keyword) :].strip())
