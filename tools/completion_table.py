"""Writes the table that shells complete commands and options from: run it where these have changed.

.venv/bin/python tools/completion_table.py
"""

from __future__ import annotations

import inspect
import json
from typing import Any

from typer.core import TyperArgument, TyperGroup, TyperOption
from typer.main import get_command
from typer.rich_utils import rich_render_text

from warpmuscle.cli.common import scene_names_like
from warpmuscle.cli.completion import TABLE
from warpmuscle.cli.program import app


def completion_of(param: Any) -> str | None:
    """How values are completed: "scenes", by their names; None, by the shell; "asked", as the program itself says."""
    own, kind = param._custom_shell_complete, param.type_descriptor
    if own is None:
        return "asked" if kind.is_choice or kind.is_file else None
    return "scenes" if scene_names_like in functions_in(own) else "asked"


def functions_in(wrapper: Any) -> list[Any]:
    """What the function calls that typer has made of a function for completion."""
    return [inspect.unwrap(cell.cell_contents) for cell in wrapper.__closure__ or () if callable(cell.cell_contents)]


def shown(help: str | None) -> str:
    """Help without marks of style, as typer gives it to a shell, in one line."""
    return " ".join(rich_render_text(help).split()) if help else ""


def table_of(command: Any, context: Any = None) -> dict[str, Any]:
    """What completion must know of a command or a group, and of those in it."""
    context = context or command.make_context(command.name, [], resilient_parsing=True)
    params = command.get_params(context)
    found: dict[str, Any] = {
        "options": [
            {
                "names": [*one.opts, *one.secondary_opts],
                "help": shown(one.help),
                "takes": one.nargs if not (one.is_flag or one.count) else 0,
                "multiple": bool(one.multiple),
                "values": completion_of(one),
            }
            for one in params
            if isinstance(one, TyperOption) and not one.hidden
        ],
        "arguments": [
            {"many": one.nargs == -1, "values": completion_of(one)} for one in params if isinstance(one, TyperArgument)
        ],
    }
    if isinstance(command, TyperGroup):
        found["commands"] = {
            name: {"help": shown(one.get_short_help_str())}
            | table_of(one, one.make_context(name, [], resilient_parsing=True))
            for name in command.list_commands(context)
            if not (one := command.get_command(context, name)).hidden
        }
    return found


def text() -> str:
    """The table as it lies in the package, a command a line."""
    commands = table_of(get_command(app))["commands"]
    lines = [f"{json.dumps(name)}: {json.dumps(one, ensure_ascii=False)}" for name, one in commands.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    TABLE.write_text(text(), encoding="utf-8")
    print(f"wrote {TABLE}")
