"""Completion in a shell from a table of commands and options, without the program itself, which takes longer to import.

The table is made by `tools/completion_table.py`. What it does not hold is left to the program.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from warpmuscle.core.shipped import shipped_scenes

TABLE = Path(__file__).with_name("completion.json")
Item = tuple[str, str]  # what is completed to, and what it is


def complete(request: str) -> bool:
    """Answer what a shell asks, such as `complete_bash`; False if only the program can.

    Its words are in the environment, where the scripts of `warpmuscle --install-completion` put them.
    """
    words = _words(request)
    if words is None:
        return False
    try:
        items = completions(*words)
    except (OSError, ValueError):  # of a table that cannot be read
        return False
    if items is None:
        return False
    if os.environ.get("_TYPER_COMPLETE_FISH_ACTION") == "is-args" and request == "complete_fish":
        sys.exit(0 if items else 1)
    print(_ANSWERS[request](items))
    return True


def _words(request: str) -> tuple[list[str], str] | None:
    """The words before the one that is not whole yet, without the program's name, and that one; None if unclear."""
    if request not in _ANSWERS:
        return None
    try:
        if request == "complete_bash":
            words = shlex.split(os.environ["COMP_WORDS"])
            place = int(os.environ["COMP_CWORD"])
            return words[1:place], words[place] if place < len(words) else ""
        line = os.environ["_TYPER_COMPLETE_ARGS"]
        words = shlex.split(line)[1:]
        return (words, "") if line.endswith(" ") or not words else (words[:-1], words[-1])
    except (KeyError, ValueError):  # or a quote that is still open
        return None


def completions(before: list[str], incomplete: str) -> list[Item] | None:
    """What the last word may be, in order; None where the table does not say.

    Args:
        before: all words but the program and the last one.
    """
    commands: dict[str, Any] = json.loads(TABLE.read_text(encoding="utf-8"))
    rest = list(before)
    while rest:
        command = commands.get(rest.pop(0))
        if command is None:
            return None
        if "commands" not in command:
            return _of_command(command, rest, incomplete)
        commands = command["commands"]
    if incomplete and not incomplete[0].isalnum():
        return None
    return [(name, one["help"]) for name, one in commands.items() if name.startswith(incomplete)]


def _of_command(command: dict[str, Any], before: list[str], incomplete: str) -> list[Item] | None:
    """What the last word after a command may be."""
    options = {name: one for one in command["options"] for name in one["names"]}
    given: list[dict[str, Any]] = []
    count = 0  # of arguments
    words = list(before)
    while words:
        word = words.pop(0)
        option = options.get(word)
        if option is None:
            if word.startswith("-"):  # several short options, --name=value, or the end of options
                return None
            count += 1
            continue
        given.append(option)
        if option["takes"] > len(words):
            return None if incomplete.startswith(("-", "=")) else _values(option["values"], incomplete)
        del words[: option["takes"]]
    if incomplete.startswith("-") and "=" not in incomplete:
        left = (one for one in command["options"] if one["multiple"] or one not in given)
        return [(name, one["help"]) for one in left for name in one["names"] if name.startswith(incomplete)]
    if incomplete and not incomplete[0].isalnum():
        return None
    for number, argument in enumerate(command["arguments"]):
        if argument["many"] or number >= count:
            return _values(argument["values"], incomplete)
    return []


def _values(kind: str | None, incomplete: str) -> list[Item] | None:
    """Values that begin so: scenes, or none, so that the shell completes files; None if only the program can."""
    if kind == "asked":
        return None
    return [(name, "") for name in shipped_scenes(incomplete)] if kind == "scenes" else []


def _for_bash(items: list[Item]) -> str:
    return "\n".join(name for name, _ in items)


def _for_zsh(items: list[Item]) -> str:
    lines = [f'"{_escaped(name)}"' + (f':"{_escaped(help)}"' if help else "") for name, help in items]
    return "_arguments '*: :((" + "\n".join(lines) + "))'" if lines else "_files"


def _escaped(text: str) -> str:
    for letter, instead in (('"', '""'), ("'", "''"), ("$", "\\$"), ("`", "\\`"), (":", "\\\\:")):
        text = text.replace(letter, instead)
    return text


def _for_fish(items: list[Item]) -> str:
    return "\n".join(f"{name}\t{' '.join(help.splitlines())}" if help else name for name, help in items)


_ANSWERS: dict[str, Callable[[list[Item]], str]] = {
    "complete_bash": _for_bash, "complete_zsh": _for_zsh, "complete_fish": _for_fish,
}  # fmt: skip
