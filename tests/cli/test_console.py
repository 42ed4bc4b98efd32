"""What commands say while they work, and what the program says by itself."""

import io
import time

import pytest
from typer.testing import CliRunner

from warpmuscle.cli import console
from warpmuscle.cli.console import PlainConsole, tell_of_compiling
from warpmuscle.cli.program import TRY, app


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> PlainConsole:
    """A console that thinks that it is a terminal."""
    shown = PlainConsole(file=io.StringIO(), force_terminal=True, width=100)
    monkeypatch.setattr(console, "log", shown)
    return shown


def test_a_status_says_what_is_compiled_and_goes_back_to_the_work(terminal):
    with terminal.status("simulating"):
        done = tell_of_compiling("joints for cpu")
        time.sleep(0.2)
        assert terminal.working.text.startswith("compiling joints for cpu")
        done()
        assert terminal.working.text == "simulating"
    assert terminal.working is None
    written = terminal.file.getvalue()
    assert "compiling joints for cpu, once (usually 5 to 20 s)" in written
    tell_of_compiling("joints for cpu")()  # where nothing is shown


def test_a_status_counts_seconds_and_names_stay_plain(terminal, monkeypatch):
    begin = time.monotonic()
    with terminal.status("reading [red]a.h5[/red]") as shown:
        monkeypatch.setattr(console.time, "monotonic", lambda: begin + 3.5)
        time.sleep(0.2)
        shown.update("drawing")
    assert "reading [red]a.h5[/red], 3 s" in terminal.file.getvalue()


def test_the_program_alone_says_what_to_try_and_each_of_it_is_a_command():
    done = CliRunner().invoke(app, [])
    assert done.exit_code == 0
    assert all(f"warpmuscle {words}" in done.stdout for words in TRY)
    names = {command.name for command in app.registered_commands}
    assert {words.split()[0] for words in TRY} - {"--help"} <= names
