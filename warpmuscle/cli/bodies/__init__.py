"""The commands that make creatures and other sizes of bodies, and judge what searches made of them.

May import: cli and all below.
To add: a command in a module of its own, its name below.
"""

from __future__ import annotations

import typer

from warpmuscle.cli.bodies.build import build
from warpmuscle.cli.bodies.judge import judge
from warpmuscle.cli.groups import add

creature = typer.Typer(
    help="Make animals from short descriptions, and judge their muscles.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (build, judge):
    add(creature, command.__name__, command)
