"""The command line."""

from __future__ import annotations

import gc
import sys

import typer
from rich.markup import escape

from warpmuscle.cli.console import INTERRUPTED, log
from warpmuscle.cli.optimize import optimize
from warpmuscle.cli.plot import plot
from warpmuscle.cli.results import apply, export, report
from warpmuscle.cli.scenes import convert, fit_muscles, info, scenes
from warpmuscle.cli.simulate import simulate
from warpmuscle.cli.sweep import sweep
from warpmuscle.cli.synergies import synergies
from warpmuscle.cli.throw import throw
from warpmuscle.cli.video import video
from warpmuscle.cli.view import view
from warpmuscle.errors import Error

GARBAGE = 50_000  # objects, at which Python looks for what it can free: starting makes many, all of which stay

app = typer.Typer(
    help="Simulate and optimise muscle-actuated bipeds, thousands at once.\n\n"
    "A SCENE is the name of a shipped one (see `warpmuscle scenes`), a TOML file, or .rbs and .sbc files of the "
    "Simbicon Controller Editor Framework, and a .rs file if the .sbc names none.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
COMMANDS = (
    scenes, info, simulate, optimize, sweep, apply, report, view, plot, video, export, fit_muscles, convert,
    synergies, throw,
)  # fmt: skip
for command in COMMANDS:
    app.command(command.__name__.replace("_", "-"))(command)


def main() -> None:
    """Run the command line; an error that a user can mend is one line and exit code 2."""
    gc.set_threshold(GARBAGE)
    try:
        code = app(standalone_mode=False)
    except Error as error:
        log.print(f"[bold red]error:[/] {escape(str(error))}")
        sys.exit(2)
    except Exception as error:
        usage = getattr(error, "show", None)  # an error in the command's own arguments
        if usage is None:
            raise
        usage()
        sys.exit(2)
    finally:
        gc.freeze()  # what is left goes with the process; to look for garbage in it takes 0.15 s
    if code == INTERRUPTED:
        log.print("interrupted")
    sys.exit(code)
