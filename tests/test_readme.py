"""README.md: its Python runs, its commands and options exist, and what it names is there."""

import re
import runpy
import shlex
from pathlib import Path

import pytest
from typer.main import get_command

from warpmuscle.cli import app
from warpmuscle.kernels.objective_terms import TERMS

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text()
COMMANDS = get_command(app).commands


def blocks(language: str) -> list[str]:
    """Code blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", TEXT, flags=re.DOTALL)


def shell_lines() -> list[str]:
    """Commands of the README's shell blocks, without comments."""
    lines = (line.split("  #")[0] for block in blocks("sh") for line in block.splitlines())
    return [part.strip() for line in lines for part in line.split("&&") if part.strip()]


def own_commands() -> list[str]:
    """Those of this program."""
    return [line for line in shell_lines() if Path(shlex.split(line)[0]).name == "warpmuscle"]


@pytest.mark.parametrize("code", blocks("python"), ids=lambda code: code.split("\n")[0])
def test_python_of_the_readme_runs(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "readme.py").write_text(code)  # Warp reads the source of kernels from their file
    runpy.run_path("readme.py")


def test_the_readme_has_commands():
    assert len(own_commands()) > 10


@pytest.mark.parametrize("line", own_commands())
def test_commands_of_the_readme_are_there_with_their_options(line: str):
    name, *words = shlex.split(line)[1:]
    assert name in COMMANDS
    command = COMMANDS[name]
    known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    asked = {word.split("=")[0] for word in words if re.fullmatch(r"-{1,2}[a-zA-Z].*", word)}
    assert asked <= known | {"--help"}


@pytest.mark.parametrize("line", [line for line in shell_lines() if re.search(r"python3? tools/\S+\.py", line)])
def test_tools_of_the_readme_are_there(line: str):
    assert all((ROOT / path).exists() for path in re.findall(r"tools/[\w/]+\.py", line) if "NAME" not in path)


def test_the_readme_lists_all_terms_of_the_objective_and_no_others():
    table = TEXT.partition("| term of `[objective]` |")[2].partition("\n\n")[0]
    listed = [name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert sorted(listed) == sorted(TERMS)


def test_files_that_the_readme_names_are_there():
    linked = re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT)
    named = re.findall(r"`((?:tools|tests|scenes|kernels|warpmuscle)/[\w/]+\.(?:py|toml|json|png|gif))`", TEXT)
    missing = [path for path in (*linked, *named) if "NAME" not in path and not (ROOT / path).exists()]
    assert len(linked) > 10
    assert missing == []
