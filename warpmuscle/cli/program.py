"""The program: its commands, and which of them are built."""

from __future__ import annotations

import copy
import inspect
import os
import shlex
import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer
from typer.models import CommandInfo

from warpmuscle.cli.arm_angles import arm_angles
from warpmuscle.cli.bodies import creature
from warpmuscle.cli.bodies.reactions import reactions
from warpmuscle.cli.bodies.scale import scale
from warpmuscle.cli.bodies.walking_task import walking_task
from warpmuscle.cli.console import marked, out
from warpmuscle.cli.ending import run_to_end
from warpmuscle.cli.gaits import gait, robustness
from warpmuscle.cli.groups import add, add_renamed
from warpmuscle.cli.inverse import inverse
from warpmuscle.cli.judge import judge
from warpmuscle.cli.learn import learn
from warpmuscle.cli.optimize import optimize
from warpmuscle.cli.plot import plot
from warpmuscle.cli.results import apply, export, report
from warpmuscle.cli.scenes import convert, fit_muscles, fit_paths, info, scenes
from warpmuscle.cli.simulate import simulate
from warpmuscle.cli.start import compile, example, schema
from warpmuscle.cli.studies.adaptation import adaptation
from warpmuscle.cli.studies.patient import patient
from warpmuscle.cli.sweep import join, study, sweep
from warpmuscle.cli.synergies import synergies
from warpmuscle.cli.throw import throw
from warpmuscle.cli.video import video
from warpmuscle.cli.view import view

app = typer.Typer(
    help="Simulate, optimise and train muscle-actuated bodies, thousands at once.\n\n"
    "A SCENE is the name of a shipped one (see `warpmuscle scenes`), a TOML file, a model of OpenSim (.osim), MuJoCo "
    "(.xml, .urdf), SCONE (.scone) or Hyfydy (.hfd), or .rbs and .sbc files of the Simbicon Controller Editor "
    "Framework, and a .rs file if the .sbc names none.",
    invoke_without_command=True,
    pretty_exceptions_enable=False,
)
COMMANDS: dict[str, tuple[Callable[..., Any], ...]] = {  # by what they are for, as the reference has them
    "Load and describe scenes": (scenes, info, convert, example, schema, fit_muscles, fit_paths, scale),
    "Creatures": (creature,),
    "Run simulations": (simulate, compile),
    "Search for parameters": (optimize, sweep, join, study, patient, adaptation, apply),
    "Learn policies": (learn, walking_task),
    "Look at motions": (view, plot, video, report, gait, judge, robustness),
    "Read, write and export": (export,),
    "From recordings to muscles": (inverse, reactions, arm_angles, synergies),
    "Throws": (throw,),
}
GROUPS = {"creature": creature, "synergies": synergies, "throw": throw}  # of commands, such as `throw fit`
RENAMED = {"cluster-synergies": "synergies cluster", "throw-rule": "throw predict"}
for topic, commands in COMMANDS.items():
    for command in commands:
        if not isinstance(command, typer.Typer):
            add(app, command.__name__.replace("_", "-"), command, topic)
for name, group in GROUPS.items():
    topic = next(topic for topic, commands in COMMANDS.items() if group in commands)
    app.add_typer(group, name=name, rich_help_panel=topic)
add_renamed(app, RENAMED)


def _print_version(given: bool) -> None:
    if given:
        from warpmuscle.results.records import version_of

        out.print(f"warpmuscle {version_of('warpmuscle')}", markup=False)
        raise typer.Exit


TRY = {
    "view walk56_person": "a walk on 56 muscles, in the browser (extra `view`)",
    "view fwalk --live": "push a biped and steer it while it walks",
    "optimize stumble56 --candidates 2000": "one that falls learns to walk: about a minute on two cores",
    "gait walk56_person": "a walk in numbers, beside people's",
    "convert yours.osim -o yours.toml": "your OpenSim model as a scene",
    "scenes": "all shipped scenes",
    "example": "sample files, for everything in the manual",
    "--help": "all commands; `warpmuscle COMMAND --help` describes one",
}


def _print_what_to_try() -> None:
    out.print("warpmuscle simulates muscle-actuated bodies, thousands at once. Try")
    width = max(map(len, TRY))
    for words, what in TRY.items():
        out.print(marked(f"  warpmuscle {words:{width}}", "bold", f"  {what}"))


@app.callback()
def common(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and end.")
    ] = False,
) -> None:
    """Options of the program itself."""
    if context.invoked_subcommand is None:
        _print_what_to_try()


def asked_for(app: typer.Typer) -> typer.Typer:
    """The program with the command alone that is called or completed, or with all where none is named.

    To build the options of all commands takes longer than most of them run.

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


def main() -> None:
    """Run the command line; an error that a user can mend is one line and exit code 2."""
    run_to_end(lambda: asked_for(app)(prog_name="warpmuscle", standalone_mode=False))
