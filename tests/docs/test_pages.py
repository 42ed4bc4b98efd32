"""The documentation is true: its blocks run, its commands parse, its tables of TOML are scenes, its words are spelt."""

import ast
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import jsonschema
import pytest
from pages import PAGES, ROOT, SHELL, Block, blocks, is_ours, split
from typer.main import get_command

from command_line import as_in_a_process
from patience import PATIENCE
from session import work_through
from warpmuscle.cli.program import app
from warpmuscle.core.decoding import to_type
from warpmuscle.creatures.description import CreatureMuscle, Segment
from warpmuscle.formats.schema import scene_schema
from warpmuscle.scene import trusted_code
from warpmuscle.studies import judge

BLOCKS = [block for page in PAGES for block in blocks(page)]
OURS = [(block, words) for block in BLOCKS if block.language in SHELL for words in block.commands if is_ours(words)]
TOOLS = [
    word
    for block in BLOCKS
    if block.language in SHELL
    for words in block.commands
    for word in words
    if word.startswith("tools/")
]
SCHEMA = jsonschema.Draft202012Validator(scene_schema())
COMMANDS = get_command(app).commands
TO_WORK_THROUGH = [page for page in PAGES if any(block.language in ("python", *SHELL) for block in blocks(page))]
MARKS = ("gpu", "long", "by hand")
# Pages that a newcomer reads first are worked through every time. The others take minutes, and have tests besides.
FIRST_READ = (
    "README.md", "docs/tutorials/first-walk.md", "docs/how-to/first-lines-of-python.md",
    "docs/how-to/continue-a-search.md", "docs/how-to/use-the-kernels.md", "docs/how-to/use-another-optimiser.md",
)  # fmt: skip
EVERY_PAGE = [
    pytest.param(page, id=name, marks=() if name in FIRST_READ else pytest.mark.long)
    for page in TO_WORK_THROUGH
    for name in [str(page.relative_to(ROOT))]
]


def named(block: Block) -> str:
    return str(block)


@pytest.mark.parametrize("page", EVERY_PAGE)
def test_what_a_page_shows_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setattr(judge, "RUNS", 2)
    with as_in_a_process(["warpmuscle"], tmp_path):
        work_through(page, marked=False)


def test_there_are_pages_to_work_through():
    assert len(OURS) > 60
    assert len(TO_WORK_THROUGH) > 15
    assert sum(page.name in [Path(name).name for name in FIRST_READ] for page in TO_WORK_THROUGH) == len(FIRST_READ)


@pytest.mark.parametrize(("block", "words"), OURS, ids=lambda value: str(value) if isinstance(value, Block) else "")
def test_commands_parse(block: Block, words: list[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(trusted_code, "trust_everything", lambda: None)
    if words[1].startswith("-"):
        return
    command, names = COMMANDS[words[1]], words[2:]
    while hasattr(command, "commands"):  # a group of them
        command, names = command.commands[names[0]], names[1:]
    command.make_context(words[1], names)


def test_an_option_that_is_not_there_would_be_noticed():
    with pytest.raises(Exception, match="No such option"):
        COMMANDS["simulate"].make_context("simulate", ["fwalk", "--nonsense"])


def test_tools_that_pages_name_are_there():
    assert len(TOOLS) > 5
    assert [path for path in TOOLS if not (ROOT / path).exists()] == []


def tool_commands(page: Path) -> list[list[str]]:
    """Words of the commands that start a tool on a page, in blocks and within its text, from the tool on."""
    spans = [
        " ".join(span.split())
        for span in re.findall(r"`([^`]+)`", re.sub("```.*?```", "", page.read_text(), flags=re.S))
    ]
    inline = [words for span in spans if "python tools/" in span for words in split(span)]
    shown = [words for block in blocks(page) if block.language in SHELL for words in block.commands]
    starts = [
        (words, [i for i, word in enumerate(words) if re.fullmatch(r"tools/[a-z_/\d]+\.py", word)])
        for words in inline + shown
    ]
    return [words[at[0] :] for words, at in starts if at]


@cache
def options_of(tool: Path) -> set[str]:
    """Options that a script, or what it imports from beside it, writes out or has Typer make of its arguments."""
    tree = ast.parse(tool.read_text())
    modules = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    beside = [file for module in modules if (file := tool.parent / f"{module}.py").exists()]
    return set().union(*(_options(one) for one in [tree, *(ast.parse(file.read_text()) for file in beside)]))


def _options(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("-"):
            yield from re.findall(r"(?<![\w-])--?[a-z][\w-]*", node.value)
        elif isinstance(node, ast.FunctionDef):
            given = node.args.args[len(node.args.args) - len(node.args.defaults) :] + node.args.kwonlyargs
            given += [one for one in node.args.args if one.annotation and "Option" in ast.unparse(one.annotation)]
            yield from (f"--{no}{argument.arg.replace('_', '-')}" for argument in given for no in ("", "no-"))


@pytest.mark.parametrize("page", [page for page in PAGES if tool_commands(page)], ids=lambda page: page.name)
def test_tools_have_the_options_that_pages_give_them(page: Path):
    wrong = [
        f"{words[0]} {word}"
        for words in tool_commands(page)
        for word in words[1:]
        if re.match("--?[a-z]", word) and word.partition("=")[0] not in options_of(ROOT / words[0])
    ]
    assert wrong == []


def test_an_option_that_a_tool_has_not_would_be_noticed():
    assert {"--population", "--json"} <= options_of(ROOT / "tools" / "bench_optimize.py")
    assert "--nonsense" not in options_of(ROOT / "tools" / "bench_optimize.py")
    page = ROOT / "docs" / "benchmarks.md"
    assert ["tools/bench_optimize.py", "walk56", "--population", "5000"] in tool_commands(page)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "toml"], ids=named)
def test_tables_of_toml_are_parts_of_scenes(block: Block):
    table = tomllib.loads(block.text)
    if "segments" in table:  # those of a creature
        for key, kind in (("segments", Segment), ("muscles", CreatureMuscle)):
            for name, part in table.get(key, {}).items():
                to_type(part, kind, f"{key}.{name}")
    elif not {"scene", "grid", "search"} & set(table):  # those of a sweep
        SCHEMA.validate(table)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "python"], ids=named)
def test_python_compiles(block: Block):
    compile(block.text, str(block), "exec")


def test_only_known_languages_and_marks_are_used():
    assert {block.language for block in BLOCKS} <= {"bash", "sh", "python", "toml", "text"}
    assert [str(block) for block in BLOCKS if block.mark and not block.mark.startswith(MARKS)] == []


def test_the_site_builds_without_a_warning(tmp_path: Path):
    pytest.importorskip("material", reason="no MkDocs: pip install mkdocs-material")
    words = shlex.split(f"-m mkdocs build --quiet --strict --site-dir {tmp_path}")
    variables = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(
        [sys.executable, *words], cwd=ROOT, env=variables, capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "reference" / "scene.html").stat().st_size > 50_000


def test_words_are_spelt(tmp_path: Path):
    checked = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs", "warpmuscle"]
    done = subprocess.run([sys.executable, "-m", "codespell_lib", *checked], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().split()) < 900
