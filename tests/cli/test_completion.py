"""Completion from the table says what the program says."""

import os
import subprocess
import sys

import completion_table
import pytest
from typer.testing import CliRunner

from warpmuscle.cli import completion
from warpmuscle.cli.program import app
from warpmuscle.formats import scene_names

LINES = [
    "warpmuscle ",
    "warpmuscle s",
    "warpmuscle simulate --",
    "warpmuscle simulate --du",
    "warpmuscle simulate fwalk --duration 1 --du",
    "warpmuscle simulate --set a=1 --se",
    "warpmuscle simulate ",
    "warpmuscle simulate fw",
    "warpmuscle simulate no_scene_begins_so",
    "warpmuscle simulate my/folder/fw",
    "warpmuscle simulate fwalk -o out.h5 w",
    "warpmuscle optimize walk56 --search ",
    "warpmuscle gait ",
    "warpmuscle throw ",
    "warpmuscle throw fit --",
    "warpmuscle throw predict --sc",
    "warpmuscle example ",
    "warpmuscle simulate --output=o",
    "warpmuscle simulate 'fw",
    "warpmuscle simulate -- fw",
    "warpmuscle nothing ",
    "warpmuscle --",
]


def environment(shell: str, line: str) -> dict[str, str]:
    """What the script of a shell sets."""
    words = line.split(" ")
    bash = {"COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    others = {"_TYPER_COMPLETE_ARGS": line, "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    return {"_WARPMUSCLE_COMPLETE": f"complete_{shell}"} | (bash if shell == "bash" else others)


def by_table(shell: str, line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str | None:
    for name, value in environment(shell, line).items():
        monkeypatch.setenv(name, value)
    return capsys.readouterr().out if completion.complete(f"complete_{shell}") else None


def test_the_table_is_that_of_the_program():
    assert completion.TABLE.read_text(encoding="utf-8") == completion_table.text(), (
        "commands or options have changed: run tools/completion_table.py"
    )


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.parametrize("line", LINES)
def test_a_shell_is_told_what_the_program_would_say(
    line: str, shell: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    told = by_table(shell, line, monkeypatch, capsys)
    if told is not None:
        given = CliRunner().invoke(app, [], prog_name="warpmuscle", env=environment(shell, line))
        assert told.split() == given.output.split()


def test_what_people_mostly_complete_is_told_by_the_table(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    asked = [line for line in LINES if by_table("bash", line, monkeypatch, capsys) is None]
    assert set(asked) <= set(LINES[LINES.index("warpmuscle gait ") :]) - {"warpmuscle gait ", "warpmuscle throw "}
    assert by_table("bash", "warpmuscle view ", monkeypatch, capsys) == "\n".join(scene_names()) + "\n"


def test_neither_typer_nor_rich_is_imported_to_complete():
    code = (
        "import sys; from warpmuscle.__main__ import main; main(); "
        "assert not {'typer', 'rich', 'numpy', 'warp'} & set(sys.modules)"
    )
    for line, said in (
        ("warpmuscle si", "simulate\n"),
        ("warpmuscle view fwalk_b", "fwalk_ball\nfwalk_box\nfwalk_bumps\n"),
    ):
        run = subprocess.run(
            [sys.executable, "-c", code], env=environment("bash", line), capture_output=True, text=True, check=True
        )
        assert run.stdout == said


def test_a_reader_that_has_gone_ends_a_completion_without_a_word():
    reader, writer = os.pipe()
    os.close(reader)
    code = "from warpmuscle.__main__ import main; main()"
    asked = environment("bash", "warpmuscle simulate w")
    run = subprocess.run([sys.executable, "-c", code], env=asked, stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (run.returncode, run.stderr) == (0, "")


def test_the_list_of_scenes_waits_for_no_command():
    code = "import sys; from warpmuscle.cli.quick import answered; sys.argv[1:] = ['scenes']; answered()"
    run = subprocess.run([sys.executable, "-X", "importtime", "-c", code], capture_output=True, text=True, check=True)
    assert set(scene_names()) <= set(run.stdout.split())
    assert "typer" not in run.stderr
