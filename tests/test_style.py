"""Formatting, linting and types of the whole project."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from user_file import KNOWN, USER_FILE

ROOT = Path(__file__).parents[1]
LONGEST = 90  # lines, and a function has fewer
BRANCHES = 25  # of a function, at most
# What mypy cannot follow in device code: Warp's decorators are not typed, its vectors have no operators, and types are
# made at run time. Arguments of calls, names, results and annotations are checked.
KERNELS_CONFIG = """
[mypy]
strict = True
follow_imports = silent
disable_error_code =
    attr-defined, empty-body, index, misc, no-any-return, no-untyped-def, operator, untyped-decorator, valid-type
[mypy-warp.*]
follow_imports = skip
"""


@pytest.mark.parametrize("tool", [("ruff", "check"), ("ruff", "format", "--check")], ids=" ".join)
def test_tool_has_nothing_to_say(tool):
    done = subprocess.run([sys.executable, "-m", *tool], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_has_nothing_to_say_of_the_package_and_tells_users_its_types(tmp_path):
    """In one run, for all of the package is read either way; how somebody new would use it, and what is told then."""
    (tmp_path / "mine.py").write_text(USER_FILE)
    files = "warpmuscle", "tests/first_guesses.py", str(tmp_path / "mine.py")
    # What is known of each module is kept by who runs mypy by hand; to write it takes a tenth of the time.
    cache = [] if (ROOT / ".mypy_cache").exists() else ["--cache-dir", os.devnull]
    done = subprocess.run([sys.executable, "-m", "mypy", *cache, *files], cwd=ROOT, capture_output=True, text=True)
    told = done.stdout + done.stderr
    assert done.returncode == 0, told
    for line in KNOWN:
        assert re.search(line, told), told


def test_mypy_has_nothing_to_say_of_kernels_as_far_as_warp_is_typed(tmp_path):
    (tmp_path / "mypy.ini").write_text(KERNELS_CONFIG)
    options = ["--config-file", str(tmp_path / "mypy.ini"), "--cache-dir", os.devnull, "-p", "warpmuscle.kernels"]
    done = subprocess.run([sys.executable, "-m", "mypy", *options], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@cache
def functions(folder):
    """Every function of a folder, with a name that says where it is."""
    return [
        (f"{file.relative_to(ROOT)}:{node.lineno} {node.name}", node)
        for file in (ROOT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.FunctionDef)
    ]


def branches(function):
    """McCabe's complexity with logical operators and comprehensions, and with that of functions within."""
    count = 1
    for node in ast.walk(function):
        match node:
            case ast.BoolOp():
                count += len(node.values) - 1
            case ast.comprehension():
                count += 1 + len(node.ifs)
            case ast.For() | ast.While():
                count += 1 + bool(node.orelse)
            case ast.If() | ast.IfExp() | ast.ExceptHandler() | ast.Assert() | ast.match_case() | ast.Lambda():
                count += 1
            case ast.FunctionDef():
                count += node is not function
    return count


def test_functions_fit_on_two_screens():
    too_long = [name for name, node in functions("warpmuscle") if node.end_lineno - node.lineno + 1 >= LONGEST]
    assert too_long == []


@pytest.mark.parametrize("folder", ["warpmuscle", "tools"])
def test_functions_have_few_branches(folder):
    assert [name for name, node in functions(folder) if branches(node) > BRANCHES] == []


def test_branches_are_those_that_a_reader_has_to_follow():
    text = """
def outer(a, b):
    for x in a:
        if x and b or not a:
            return [y for y in x if y]
    def inner(c):
        return 1 if c else 2
    return inner
"""
    assert branches(ast.parse(text).body[0]) == 1 + 1 + 1 + 2 + 2 + 1 + 1
