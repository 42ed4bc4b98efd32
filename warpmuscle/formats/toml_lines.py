"""Where the keys of a TOML text stand: tomllib gives values without lines, and errors about values need them."""

from __future__ import annotations

import re

BARE = re.compile(r"[A-Za-z0-9_-]+")
BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
SCALAR = re.compile(r"[^,\]}\r\n#]+")
STRINGS = (
    re.compile(r'"""(?:[^\\]|\\.)*?"{3,5}', re.DOTALL),
    re.compile(r"'''.*?'{3,5}", re.DOTALL),
    re.compile(r'"(?:[^"\\]|\\.)*"'),
    re.compile(r"'[^']*'"),
)
ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{4})|U([0-9a-fA-F]{8})|(.))")
ESCAPED = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", "e": "\x1b"}

Path = tuple[str, ...]


def key_lines(text: str) -> dict[Path, int]:
    """Line, counted from 1, of every key and of every item of a list, by path; indices of items are texts.

    Args:
        text: TOML that tomllib has accepted.
    """
    return _Walk(text).lines


class _Walk:
    """A position in a valid text, moving over its keys and values."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text.replace("\r\n", "\n"), 0
        self.lines: dict[Path, int] = {}
        self._line, self._counted = 1, 0  # the line of the last mark, and how much of the text was looked at for it
        self.counts: dict[Path, int] = {}  # items so far of the arrays of tables
        table: Path = ()
        self.blank()
        while self.at < len(self.text):
            if self.here("["):
                table = self.header()
            else:
                self.pair(table)
            self.blank()

    def here(self, token: str) -> bool:
        """Whether the text goes on with a token, which is then passed."""
        found = self.text.startswith(token, self.at)
        self.at += len(token) if found else 0
        return found

    def blank(self) -> None:
        """Pass blanks, line ends and comments."""
        match = BLANK.match(self.text, self.at)
        self.at = match.end() if match else self.at

    def mark(self, path: Path) -> None:
        """The path stands in the line of the current position, unless it stood somewhere before."""
        self._line += self.text.count("\n", self._counted, self.at)
        self._counted = self.at
        self.lines.setdefault(path, self._line)

    def header(self) -> Path:
        """Pass the rest of `[table]` or `[[table]]`; the path of what follows, with the indices of the last items."""
        many = self.here("[")
        path: Path = ()
        names = self.key()
        for depth, name in enumerate(names):
            path = (*path, name)
            self.mark(path)
            if many and depth == len(names) - 1:
                self.counts[path] = self.counts.get(path, 0) + 1
            if path in self.counts:
                path = (*path, str(self.counts[path] - 1))
                self.mark(path)
        self.at = self.text.index("]", self.at) + (2 if many else 1)
        return path

    def pair(self, table: Path) -> None:
        """Pass `key = value`."""
        path = table
        for name in self.key():
            path = (*path, name)
            self.mark(path)
        self.blank()
        self.here("=")
        self.value(path)

    def key(self) -> list[str]:
        """Pass a key; its parts."""
        parts = []
        while True:
            self.blank()
            if bare := BARE.match(self.text, self.at):
                parts.append(bare[0])
                self.at = bare.end()
            else:
                parts.append(_unquoted(self.string()))
            self.blank()
            if not self.here("."):
                return parts

    def string(self) -> str:
        """Pass a string, quotes included; empty if there is none."""
        for pattern in STRINGS:
            if match := pattern.match(self.text, self.at):
                self.at = match.end()
                return match[0]
        return ""

    def value(self, path: Path) -> None:
        """Pass a value, marking what is inside."""
        self.blank()
        if self.here("["):
            self.items(path)
        elif self.here("{"):
            self.blank()
            while not self.here("}"):
                self.pair(path)
                self.blank()
                self.here(",")
                self.blank()
        elif not self.string():
            match = SCALAR.match(self.text, self.at)
            self.at = match.end() if match else len(self.text)

    def items(self, path: Path) -> None:
        """Pass the rest of a list."""
        index = 0
        self.blank()
        while not self.here("]"):
            item = (*path, str(index))
            self.mark(item)
            self.value(item)
            self.blank()
            self.here(",")
            self.blank()
            index += 1


def _unquoted(quoted: str) -> str:
    """The text that a quoted key stands for."""
    if not quoted.startswith('"'):
        return quoted[1:-1]

    def character(match: re.Match[str]) -> str:
        digits = match[1] or match[2]
        return chr(int(digits, 16)) if digits else ESCAPED.get(match[3], match[3])

    return ESCAPE.sub(character, quoted[1:-1])
