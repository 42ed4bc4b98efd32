"""Groups of commands: what was one command says what to type now, and completion goes into them."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rich.text import Text
from typer.main import get_command
from typer.testing import CliRunner

from warpmuscle.cli.program import COMMANDS, GROUPS, app
from warpmuscle.core.errors import Error


@pytest.mark.parametrize(
    ("typed", "now"),
    [
        ("throw a.csv b.csv -o throw.h5", "type `warpmuscle throw fit a.csv b.csv -o throw.h5`"),
        ("throw lift.csv --emg syn.h5 --prescribe wrist", "throw fit lift.csv --emg syn.h5 --prescribe wrist`"),
        ("throw --target 2 --target 4", "`warpmuscle throw goal --target 2 --target 4`"),
        ("throw a.csv --speed=7", "`warpmuscle throw goal a.csv --speed=7`"),
        ("throw a.csv --numbers 4 6", "`warpmuscle throw compare a.csv --numbers 4 6`"),
        ("throw a.csv --target 2 --curve", "`warpmuscle throw goal` for goals, `warpmuscle throw compare` for --curve"),
        ("throw-rule a.csv --goals 50 -o rule.h5", "`warpmuscle throw predict a.csv --goals 50 -o rule.h5`"),
        ("synergies emg.csv -n 4", "`warpmuscle synergies extract emg.csv -n 4`"),
        ("cluster-synergies a.h5 b.h5 --help", "`warpmuscle synergies cluster a.h5 b.h5 --help`"),
        (
            f"throw {' '.join(f'throw{k}.csv' for k in range(40))}",
            "type `warpmuscle throw fit` with the same arguments",
        ),
    ],
)
def test_a_command_of_before_says_in_a_line_what_to_type_now(typed: str, now: str):
    done = CliRunner().invoke(app, typed.split())
    assert isinstance(done.exception, Error), done.output
    assert now in str(done.exception)
    assert "\n" not in str(done.exception)


def test_a_mistyped_command_of_a_group_is_no_command_of_before():
    done = CliRunner().invoke(app, ["throw", "gaol"])
    assert done.exit_code == 2
    assert "No such command 'gaol'" in done.output
    assert "goal" in done.output


def test_an_option_of_before_says_what_it_is_called_now():
    done = CliRunner().invoke(app, ["apply", "a.h5", "-o", "a.toml", "--hardiest", "20"])
    assert str(done.exception) == "--hardiest is called --most-robust now: write --most-robust 20"
    assert "hardiest" not in CliRunner().invoke(app, ["apply", "--help"]).output


@pytest.mark.parametrize("group", GROUPS)
def test_a_group_alone_tells_of_its_commands_and_completion_names_them(group: str, tmp_path: Path):
    names = {command.name for command in GROUPS[group].registered_commands}
    assert len(names) > 1
    shown = CliRunner().invoke(app, [group]).output
    assert all(name in shown for name in names)
    variables = {"_WARPMUSCLE_COMPLETE": "complete_bash", "COMP_WORDS": f"warpmuscle {group} ", "COMP_CWORD": "2"}
    code = "from warpmuscle.cli.program import app; app(prog_name='warpmuscle')"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=os.environ | variables, capture_output=True, text=True
    )
    assert set(done.stdout.split()) == names


def helps(command: Any, name: str = "warpmuscle") -> Iterator[tuple[str, str]]:
    """All texts of help of a command, its options and the commands below it."""
    for part in (command, *command.params):
        yield name, getattr(part, "help", None) or ""
    for below, inner in getattr(command, "commands", {}).items():
        yield from helps(inner, f"{name} {below}")


def test_words_in_brackets_are_not_lost_from_help_as_markup():
    every = list(helps(get_command(app)))
    assert len({name for name, _ in every}) > 30
    assert any("table \\[study]" in text for _, text in every)
    assert [name for name, text in every if Text.from_markup(text).plain != text.replace("\\[", "[")] == []


def every_command(command: Any) -> Iterator[Any]:
    for one in getattr(command, "commands", {}).values():
        yield from every_command(one) if hasattr(one, "commands") else [one]


def test_terminals_break_the_lines_of_descriptions_where_they_are_full():
    texts = [command.help or "" for command in every_command(get_command(app)) if not command.hidden]
    assert len(texts) > 30
    assert all(text and "\n" not in text.replace("\n\n", "") for text in texts)


def test_help_lists_commands_below_what_they_are_for():
    shown = CliRunner().invoke(app, ["--help"]).stdout
    assert all(topic in shown for topic in COMMANDS)
