"""Formatting, linting and types of the whole project."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LONGEST = 90  # lines, and a function has fewer
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


MYPY = "mypy", "warpmuscle", "tests/first_guesses.py"  # the package, and how somebody new would use it


@pytest.mark.parametrize("tool", [("ruff", "check"), ("ruff", "format", "--check"), MYPY], ids=" ".join)
def test_tool_has_nothing_to_say(tool):
    done = subprocess.run([sys.executable, "-m", *tool], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_has_nothing_to_say_of_kernels_as_far_as_warp_is_typed(tmp_path):
    (tmp_path / "mypy.ini").write_text(KERNELS_CONFIG)
    options = ["--config-file", str(tmp_path / "mypy.ini"), "--cache-dir", os.devnull, "-p", "warpmuscle.kernels"]
    done = subprocess.run([sys.executable, "-m", "mypy", *options], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_functions_fit_on_two_screens():
    too_long = [
        f"{file.relative_to(ROOT)}:{node.lineno} {node.name}"
        for file in (ROOT / "warpmuscle").rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno + 1 >= LONGEST
    ]
    assert too_long == []
