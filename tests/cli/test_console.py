"""What commands say while they work, and what the program says by itself."""

import io
import re
import sys
import threading
import webbrowser
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from command_line import run
from patience import MOMENT, PATIENCE, ended, for_a_moment, until
from warpmuscle.cli import console, streams
from warpmuscle.cli.console import PlainConsole, tell_of_compiling
from warpmuscle.cli.program import TRY, app
from warpmuscle.cli.progress_bar import Bar
from warpmuscle.cli.view import open_page


@pytest.fixture(autouse=True)
def no_lines_for_waiting() -> None:
    """They are what these tests are about."""


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> PlainConsole:
    """A console that thinks that it is a terminal."""
    shown = PlainConsole(file=io.StringIO(), force_terminal=True, width=100)
    monkeypatch.setattr(console, "log", shown)
    return shown


def test_a_status_says_what_is_compiled_and_goes_back_to_the_work(terminal):
    with terminal.status("simulating"):
        done = tell_of_compiling("joints for cpu")
        assert terminal.working.text.startswith("compiling joints for cpu")
        until(lambda: "compiling joints for cpu, once (usually 5 to 20 s)" in terminal.file.getvalue())
        done()
        assert terminal.working.text == "simulating"
    assert terminal.working is None
    tell_of_compiling("joints for cpu")()  # where nothing is shown


def test_a_status_counts_seconds_and_names_stay_plain(terminal, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(console, "time", SimpleNamespace(monotonic=lambda: now[0]))
    with terminal.status("reading [red]a.h5[/red]") as shown:
        now[0] += 3.5
        until(lambda: "reading [red]a.h5[/red], 3 s" in terminal.file.getvalue())
        shown.update("drawing")


def test_what_takes_long_is_told_without_a_terminal_too(monkeypatch):
    shown = PlainConsole(file=io.StringIO(), force_terminal=False)
    monkeypatch.setattr(console, "log", shown)
    monkeypatch.setattr(console, "SILENCE", 0.05)
    monkeypatch.setattr(console, "LINES", 0.05)  # of a program that has run for minutes, as all tests' may have
    with shown.status("reading"):
        until(lambda: re.search(r"^reading, \d+ s$", shown.file.getvalue(), re.M))
    done = tell_of_compiling("joints for cpu")  # beside a bar
    until(lambda: re.search(r"^compiling joints for cpu, once, \d+ s$", shown.file.getvalue(), re.M))
    done()
    written = shown.file.getvalue()
    ended("says what goes on")
    assert shown.file.getvalue() == written


def test_nothing_that_is_told_of_a_work_comes_behind_what_is_printed_after_it(monkeypatch):
    writing, go_on = threading.Event(), threading.Event()

    class Slow(io.StringIO):
        def write(self, words: str) -> int:
            if "compiling" in words:
                writing.set()
                go_on.wait(PATIENCE)
            return super().write(words)

    shown = PlainConsole(file=Slow(), force_terminal=False)
    monkeypatch.setattr(console, "SILENCE", 0.05)
    monkeypatch.setattr(console, "LINES", 0.05)
    monkeypatch.setattr(console, "log", shown)
    done = tell_of_compiling("joints for cpu")
    assert writing.wait(PATIENCE)
    threading.Timer(MOMENT, go_on.set).start()
    done()
    shown.file.write("wrote it\n")
    until(lambda: "compiling" in shown.file.getvalue())
    assert shown.file.getvalue().splitlines()[-1] == "wrote it"


def test_compile_says_what_was_compiled_and_how_far_it_is(tmp_path):
    done = run("compile", "fwalk", "fwalk", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("1 of 2: fwalk ")
    assert lines[1] == "2 of 2: fwalk was compiled before"
    assert not list(tmp_path.iterdir())
    wrong = run("compile", "fwalk", "nosuch", folder=tmp_path)
    assert wrong.returncode == 2
    assert "nosuch" in wrong.stderr


def test_the_program_alone_says_what_to_try_and_each_of_it_is_a_command():
    done = CliRunner().invoke(app, [])
    assert done.exit_code == 0
    assert all(f"warpmuscle {words}" in done.stdout for words in TRY)
    names = {command.name for command in app.registered_commands}
    assert {words.split()[0] for words in TRY} - {"--help"} <= names


def test_lines_come_often_while_somebody_waits_and_seldom_later(monkeypatch):
    assert console.between_lines() in (console.SILENCE, console.LINES)
    assert console.SILENCE < 2.0
    monkeypatch.setattr(console, "_BEGIN", console.time.monotonic())
    assert console.between_lines() == console.SILENCE
    monkeypatch.setattr(console, "_BEGIN", console.time.monotonic() - console.AWAITED)
    assert console.between_lines() == console.LINES


def test_a_page_opens_only_where_somebody_sits_before_a_screen(monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SSH_CONNECTION"):
        monkeypatch.delenv(name, raising=False)
    assert not open_page(tmp_path / "a b.html")
    monkeypatch.setenv("DISPLAY", ":0")
    assert open_page(tmp_path / "a b.html")
    assert opened == [(tmp_path / "a b.html").as_uri()]
    monkeypatch.setenv("SSH_CONNECTION", "10.0.0.1 22 10.0.0.2 22")
    assert not open_page(tmp_path / "a b.html")
    assert len(opened) == 1


def test_a_bar_says_its_last_line_again_while_nothing_is_new(monkeypatch):
    shown = PlainConsole(file=io.StringIO(), force_terminal=False)
    monkeypatch.setattr(console, "SILENCE", 0.1)
    monkeypatch.setattr(console, "LINES", 0.1)
    with Bar(shown) as bar:
        until(lambda: "getting ready\n" in shown.file.getvalue())
        bar.show(0.5, "1/2", "best 3")
        until(lambda: shown.file.getvalue().count("1/2: best 3\n") > 1)
    written = shown.file.getvalue()
    assert written.endswith("1/2: best 3\n")
    ended("says what goes on")
    assert shown.file.getvalue() == written


@pytest.mark.parametrize(("command", "told"), [("optimize", True), ("plot", True), ("--help", False)])
def test_a_slow_start_is_told_until_the_command_speaks(monkeypatch, command, told):
    written: list[bytes] = []
    monkeypatch.setattr(streams.sys, "argv", ["warpmuscle", command])
    monkeypatch.setattr(streams.os, "write", lambda stream, text: written.append(text) or len(text))
    monkeypatch.setattr(streams, "started", threading.Event())
    monkeypatch.setattr(streams, "FIRST", 0.02)
    monkeypatch.setattr(streams, "SLOW", 0.02)
    monkeypatch.setattr(streams, "AGAIN", 0.02)
    monkeypatch.setattr(console, "started", streams.started)
    monkeypatch.setattr(streams, "time", SimpleNamespace(monotonic=lambda: 0.0))
    streams.tell_of_start()
    if told:
        until(lambda: len(written) > 2)
    else:
        for_a_moment()
    assert set(written) == ({b"starting warpmuscle, 0 s\n"} if told else set())
    PlainConsole(file=io.StringIO()).print("read")
    ended("starting")  # so that nothing follows


def test_the_start_is_told_of_commands_that_there_are():
    names = {command.name for command in app.registered_commands} | {group.name for group in app.registered_groups}
    assert names > streams.WORKING
    assert max(streams.SLOW, streams.FIRST, streams.AGAIN, console.SILENCE + console.BRIEF) < 2.0
