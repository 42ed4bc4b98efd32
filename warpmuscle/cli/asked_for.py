"""The program with no more commands than it is asked for: to build the options of all takes longer than most run."""

from __future__ import annotations

import copy
import inspect
import os
import shlex
import sys

import typer
from typer.models import CommandInfo


def asked_for(app: typer.Typer) -> typer.Typer:
    """The program with the command alone that is called or completed, or with all where none is named.

    Where a shell completes the name of a command, all are there by their names, without options.
    """
    words = _completed()
    if words == []:
        names = copy.copy(app)
        names.registered_commands = [_by_name(command) for command in app.registered_commands]
        return names
    name = next(iter(sys.argv[1:] if words is None else words), None)
    commands = [command for command in app.registered_commands if command.name == name]
    groups = [group for group in app.registered_groups if group.name == name]
    if not commands and not groups:
        return app
    alone = copy.copy(app)
    alone.registered_commands, alone.registered_groups = commands, groups
    return alone


def _completed() -> list[str] | None:
    """The words before the one that a shell asks to complete, without the program's name; None if it asks for none."""
    if not os.environ.get("_WARPMUSCLE_COMPLETE", "").startswith("complete_"):
        return None
    try:
        if "COMP_CWORD" in os.environ:  # bash
            return shlex.split(os.environ.get("COMP_WORDS", ""))[1 : int(os.environ["COMP_CWORD"])]
        line = os.environ.get("_TYPER_COMPLETE_ARGS", "")
        words = shlex.split(line)[1:]
        return words if line.endswith(" ") else words[:-1]
    except ValueError:  # a quote that is still open
        return None


def _by_name(command: CommandInfo) -> CommandInfo:
    """A command that has a name and a text of help, and no options."""
    named = copy.copy(command)
    named.help, named.callback = command.help or inspect.getdoc(command.callback), _nothing
    return named


def _nothing() -> None:
    pass
