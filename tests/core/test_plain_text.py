"""What a terminal shows of names is text: no styles, no emoji, nothing that steers the terminal or reorders letters."""

import io
import os
import subprocess
from pathlib import Path

import pytest
from rich.table import Table

from child_signals import PROGRAM
from patience import PATIENCE
from warpmuscle.cli.console import PlainConsole, marked
from warpmuscle.cli.progress_bar import Bar
from warpmuscle.core.errors import Error, ResultError, SceneError, SignalError
from warpmuscle.core.plain_text import few_of, many_of, number_of, printable, readable
from warpmuscle.formats import load, toml

NAMES = ["[red]x", "a[/b]", "12:100:", ":boom:", "[link=http://x]y", "\\[bold]"]
STEERING = {
    "\x1b[2J": r"\x1b[2J", "\x1b]0;title\x07": r"\x1b]0;title\x07", "\x9b31m": r"\x9b31m", "a\rb": r"a\rb",
    "a\x08b": r"a\x08b", "\u202eabc": r"\u202eabc", "\u2066a": r"\u2066a", "\u2028": r"\u2028", "\udcff": r"\udcff",
    "\U000e0041": r"\U000e0041",
}  # fmt: skip


def shown(*objects: object, terminal: bool = False) -> str:
    """What a console prints."""
    text = io.StringIO()
    PlainConsole(file=text, soft_wrap=True, highlight=False, force_terminal=terminal, width=300).print(*objects)
    return text.getvalue()


@pytest.mark.parametrize("name", NAMES)
def test_markup_in_names_is_printed_as_it_stands(name):
    table = Table(name, title=name)
    table.add_row(name)
    assert name in shown(name)
    assert shown(table).count(name) == 3
    assert name in shown(marked("warning:", "yellow", f" {name}"))


@pytest.mark.parametrize("name", STEERING)
def test_what_steers_a_terminal_is_printed_as_an_escape(name):
    assert printable(name) == STEERING[name]
    table = Table(name)
    table.add_row(name)
    for said in (shown(name), shown(table), shown(marked(name, "bold", name))):
        assert STEERING[name] in said
        assert name not in said
    assert "\x1b]" not in shown(name, terminal=True)


@pytest.mark.parametrize("name", [*NAMES, *STEERING])
def test_status_and_bar_show_names_as_text(name):
    text = io.StringIO()
    console = PlainConsole(file=text, force_terminal=True, width=300)
    with console.status(name) as status:
        status.update(f"{name}.")
    bar = Bar(console)
    with bar:
        bar.show(0.5, name, name)
    said = text.getvalue()
    assert STEERING.get(name, name) in said
    assert "\x1b]" not in said
    assert "\x1b[2J" not in said


@pytest.mark.parametrize(
    "error",
    [Error("a\x1b[2J\nb"), ResultError("a\x1b[2J\nb"), SceneError("a\x1b[2J\nb", "k"), SignalError("a\x1b[2J\nb", "c")],
)
def test_every_error_is_one_line_without_escapes(error):
    assert str(error).endswith(r"a\x1b[2J b")


def run(*arguments: object, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [*PROGRAM, *map(str, arguments)], cwd=folder, capture_output=True, timeout=PATIENCE,
        env=os.environ | environment,
    )  # fmt: skip


def test_info_of_a_scene_with_hostile_names_prints_them_as_text(tmp_path):
    hostile = "[red]a[/b]:boom:\\u001B[2J\\u202E"
    text = toml.dumps(load("fwalk")).replace("'fwalk'", '"fwalk"').replace('"fwalk"', f'"{hostile}"')
    text += f'\n[character.bodies."{hostile}2"]\nmass = 1\n'
    (tmp_path / "a.toml").write_text(text)
    for environment in ({}, {"PYTHONIOENCODING": "ascii"}, {"FORCE_COLOR": "1", "TERM": "xterm"}):
        done = run("info", "a.toml", folder=tmp_path, **environment)
        assert done.returncode in (0, 2), done.stderr
        assert b"Traceback" not in done.stderr
        assert b"[red]a[/b]:boom:" in done.stdout + done.stderr
        assert b"\x1b[2J" not in done.stdout + done.stderr
        assert "\u202e".encode() not in done.stdout + done.stderr


def test_what_was_typed_wrong_is_quoted_without_escapes(tmp_path):
    done = run("info", "fwalk", "--se\x1b[2Jt", folder=tmp_path)
    assert done.returncode == 2
    assert b"\x1b[2J" not in done.stderr
    done = run("simulate", "nothing[/red]\x1b[2J", folder=tmp_path)
    assert done.returncode == 2
    assert rb"nothing[/red]\x1b[2J" in done.stderr


def test_search_of_a_scene_called_like_a_path_stays_in_the_folder(tmp_path):
    folder = tmp_path / "inner"
    folder.mkdir()
    (folder / "a.toml").write_text('base = "fwalk"\nname = "../../escaped"\nduration = 0.05\n')
    done = run("optimize", "a.toml", "--candidates", 3, folder=folder)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in folder.iterdir()} == {"a.toml", "_.._escaped.h5"}
    assert {path.name for path in tmp_path.iterdir()} == {"inner"}


@pytest.mark.parametrize(
    ("noun", "plural"),
    [("joint", "joints"), ("body", "bodies"), ("axis", "axes"), ("key", "keys"), ("push", "pushes"),
     ("batch", "batches"), ("index", "indexes"), ("free parameter", "free parameters")],
)  # fmt: skip
def test_nouns_have_their_plural(noun: str, plural: str):
    assert [number_of(count, noun) for count in (0, 1, 2)] == [f"0 {plural}", f"1 {noun}", f"2 {plural}"]


def test_verbs_follow_the_number():
    assert [number_of(count, "body", "need") for count in (1, 2)] == ["1 body needs", "2 bodies need"]
    assert [number_of(count, "body", "are") for count in (1, 2)] == ["1 body is", "2 bodies are"]


def test_long_lists_of_words_say_how_many_more_there_are():
    assert few_of(["a", "b", "c"], 3) == "a, b, c"
    assert few_of(("a", "b", "c", "d"), 2, "; ") == "a; b and 2 more"
    assert few_of([], 2) == ""


@pytest.mark.parametrize(
    ("count", "words"),
    [(0.0, "0 steps"), (1, "1 step"), (24, "24 steps"), (9999.4, "9999 steps"), (64000, "64 thousand steps"),
     (1_442_000, "1.442 million steps"), (278e6, "278 million steps")],
)  # fmt: skip
def test_counts_are_in_words_of_their_size(count, words):
    assert many_of(count, "step") == words


@pytest.mark.parametrize(
    ("word", "text"),
    [("walk.h5", "walk.h5"), ("Läufe", "Läufe"), ("L\udcc3\udca4ufe", "Läufe"), ("L\udce4ufe", "L\ufffdufe")],
    ids=ascii,
)
def test_a_name_in_other_bytes_than_utf_8_is_readable(word: str, text: str):
    """Bytes of UTF-8 where the locale has none, and those of another encoding."""
    assert readable(word) == text
