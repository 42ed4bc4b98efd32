"""The pages of the documentation as a reader works through them: blocks of code, and what is said of them."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md*"))]
SHELL = ("bash", "sh")
_BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^\n]*?) -->\n)?^```(?P<language>\w+)(?P<rest>[^\n]*)\n(?P<text>.*?)^```",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        mark: of what is not run: `gpu`, `long` or `by hand`, and why.
        title: of a file that it is.
    """

    page: str
    line: int
    language: str
    mark: str
    title: str
    text: str

    @property
    def commands(self) -> list[list[str]]:
        """Commands of a block for a shell, in words."""
        lines = self.text.replace("\\\n", " ").splitlines()
        return [words for line in lines for words in split(line) if words]

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def split(line: str) -> list[list[str]]:
    """Words of the commands of a line, which `&&` joins."""
    commands: list[list[str]] = [[]]
    for word in shlex.split(line, comments=True):
        if word == "&&":
            commands.append([])
        else:
            commands[-1].append(word)
    return commands


def blocks(page: Path) -> list[Block]:
    """The blocks of a page, in order."""
    text = page.read_text()
    found = []
    for match in _BLOCK.finditer(text):
        title = re.search(r'title="([^"]+)"', match["rest"])
        line = text.count("\n", 0, match.start("text")) + 1
        name = str(page.relative_to(ROOT))
        found.append(
            Block(name, line, match["language"], match["mark"] or "", title[1] if title else "", match["text"])
        )
    return found


def is_ours(words: list[str]) -> bool:
    """Whether a command is one of this program."""
    return Path(words[0]).name == "warpmuscle"
