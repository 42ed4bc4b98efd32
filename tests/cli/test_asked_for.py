"""The program builds what it is asked for, and completes in the shell as the whole program would."""

import pytest
import typer
from typer.main import get_command
from typer.testing import CliRunner

from warpmuscle.cli.program import app, asked_for

ALL = {command.name for command in app.registered_commands}


@pytest.mark.parametrize(
    ("words", "built"), [(["scenes"], {"scenes"}), ([], ALL), (["--help"], ALL), (["no-such"], ALL)]
)
def test_a_command_that_is_called_is_built_alone(words: list[str], built: set[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.argv", ["warpmuscle", *words])
    assert {command.name for command in asked_for(app).registered_commands} == built
    assert {command.name for command in app.registered_commands} == ALL


def completed(line: str, program: typer.Typer, monkeypatch: pytest.MonkeyPatch) -> str:
    """What zsh, or bash, gets for a line that is not whole yet."""
    zsh = {"_WARPMUSCLE_COMPLETE": "complete_zsh", "_TYPER_COMPLETE_ARGS": line}
    for name, value in zsh.items():
        monkeypatch.setenv(name, value)
    return CliRunner().invoke(program, [], prog_name="warpmuscle", env=zsh).output


@pytest.mark.parametrize("line", ["warpmuscle si", "warpmuscle ", "warpmuscle simulate --du", "warpmuscle simulate fw"])
def test_what_is_completed_is_what_the_whole_program_completes(line: str, monkeypatch: pytest.MonkeyPatch):
    whole = completed(line, app, monkeypatch)
    assert "simulate" in whole or "duration" in whole or "fwalk" in whole
    assert completed(line, asked_for(app), monkeypatch) == whole


def test_a_shell_that_completes_a_name_needs_no_options(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("_WARPMUSCLE_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", "warpmuscle si")
    monkeypatch.setenv("COMP_CWORD", "1")
    commands = get_command(asked_for(app)).commands
    assert set(commands) >= ALL
    assert commands["simulate"].get_short_help_str()
    assert commands["simulate"].params == []
    monkeypatch.setenv("COMP_WORDS", "warpmuscle simulate 'fw")
    assert asked_for(app) is app
