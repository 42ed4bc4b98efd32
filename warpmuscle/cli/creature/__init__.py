"""The commands that make creatures from short descriptions, and judge what searches made of them.

May import: cli and all below.
To add: a command in a module of its own, its name below.
"""

from __future__ import annotations

import typer

from warpmuscle.cli.creature.build import build
from warpmuscle.cli.creature.judge import judge

creature = typer.Typer(
    help="Make animals from short descriptions, and judge their muscles.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (build, judge):
    creature.command(command.__name__)(command)
