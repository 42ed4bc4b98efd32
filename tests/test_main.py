"""Ctrl-C while the program is still being imported ends it as it does later: one line and exit code 130."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from patience import PATIENCE
from warpmuscle.core.interruption import INTERRUPTED

# Python, in which Ctrl-C comes at the moment at which a module is looked for.
CTRL_C = """
import os, signal, sys

class Finder:
    def find_spec(name, path, target=None):
        if name == "{module}":
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.{handler})
sys.meta_path.insert(0, Finder)
sys.argv = ["warpmuscle", "{argument}"]
"""
MODULE = "import runpy; runpy.run_module('warpmuscle', run_name='__main__', alter_sys=True)"
WHERE = Path(__file__).parents[1] / "pyproject.toml"
SCRIPT = "from {0[0]} import {0[1]}; {0[1]}()".format(
    tomllib.loads(WHERE.read_text())["project"]["scripts"]["warpmuscle"].split(":")
)


def interrupted(
    start: str, module: str, handler: str = "default_int_handler", argument: str = "--help"
) -> subprocess.CompletedProcess[str]:
    code = CTRL_C.format(module=module, handler=handler, argument=argument) + start
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)


@pytest.mark.parametrize("start", [MODULE, SCRIPT], ids=["python -m", "script"])
@pytest.mark.parametrize(
    ("module", "argument"),
    [(name, "--help") for name in ("warpmuscle.cli", "typer", "rich", "warpmuscle.cli.view", "warpmuscle.core.shipped")]
    + [(name, "scenes") for name in ("warpmuscle.cli", "warpmuscle.core.shipped")],  # which imports no more
)
def test_ctrl_c_at_an_import_is_one_line_and_exit_code_130(start: str, module: str, argument: str):
    done = interrupted(start, module, argument=argument)
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "interrupted\n")


def test_ctrl_c_while_the_command_line_is_made_is_one_line_and_exit_code_130():
    patch = "import typer.main, signal; typer.main.get_command = lambda app: signal.raise_signal(signal.SIGINT); "
    done = interrupted(patch + SCRIPT, "")
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "interrupted\n")


def test_what_ignores_ctrl_c_in_the_background_of_a_script_goes_on_to_do_so():
    done = interrupted(SCRIPT, "typer", "SIG_IGN")
    assert (done.returncode, done.stderr) == (0, "")
    assert "simulate" in done.stdout
