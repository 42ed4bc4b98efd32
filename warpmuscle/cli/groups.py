"""Groups of commands, such as `throw fit` and `throw goal`, and what to type in place of commands of before."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from warpmuscle.core.errors import Error

LONGEST = 200  # letters of a command that an error repeats


def instead(command: str, arguments: Sequence[str]) -> str:
    """The command to type with these arguments, in words of an error."""
    whole = shlex.join(["warpmuscle", *command.split(), *arguments])
    return f"`{whole}`" if len(whole) <= LONGEST else f"`warpmuscle {command}` with the same arguments"


def group(help: str, former: Callable[[Sequence[str]], str]) -> typer.Typer:
    """A group of commands that was a single command.

    Args:
        former: what to type now, from the arguments of that single command.
    """

    class Group(TyperGroup):
        def parse_args(self, context: Any, args: list[str]) -> list[str]:
            if not context.resilient_parsing and args and self._is_former(args[0]):
                raise Error(f"`warpmuscle {self.name}` is a group of commands now; type {former(args)}")
            return super().parse_args(context, args)

        def _is_former(self, word: str) -> bool:
            """Whether a first word is an option or a file, which a group has none of."""
            option = word.startswith("-") and word != "--help"
            return option or (word not in self.commands and (Path(word).suffix != "" or Path(word).exists()))

    return typer.Typer(help=help, cls=Group, no_args_is_help=True, pretty_exceptions_enable=False)


def add(app: typer.Typer, name: str, command: Callable[..., Any], topic: str | None = None) -> None:
    """Add a command, in the list below a topic. A terminal breaks the lines of its description where they are full."""
    paragraphs = (inspect.getdoc(command) or "").split("\n\n")
    text = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)
    app.command(name, help=text, rich_help_panel=topic)(command)


def add_renamed(app: typer.Typer, names: Mapping[str, str]) -> None:
    """Let commands of before, by name, say which command does their work now."""
    settings = {"ignore_unknown_options": True, "allow_extra_args": True, "help_option_names": []}
    for old, new in names.items():
        app.command(old, hidden=True, context_settings=settings)(_refusal(old, new))


def _refusal(old: str, new: str) -> Callable[[typer.Context], None]:
    def refuse(context: typer.Context) -> None:
        raise Error(f"`warpmuscle {old}` has another name now; type {instead(new, context.args)}")

    return refuse
