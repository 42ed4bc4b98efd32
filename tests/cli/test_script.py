"""How scripts in `tools` end: with the program's exit codes, and with one line for what a user can mend."""

import subprocess
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
SCRIPT = """
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error

def main(how: str) -> None:
    if how == "mendable":
        raise Error("walk.h5: holds no policy")
    if how == "defect":
        raise KeyError("a mistake of the script")
    print("did", how)

run_script(main)
"""


@pytest.mark.parametrize(
    ("arguments", "code", "printed", "said"),
    [
        (["its work"], 0, "did its work\n", ""),
        (["mendable"], 2, "", "error: walk.h5: holds no policy\n"),
        ([], 2, "", "error: missing argument"),
        (["defect"], 1, "", "KeyError"),
    ],
)
def test_a_script_ends_with_one_line_unless_it_is_itself_wrong(arguments, code, printed, said, tmp_path):
    path = tmp_path / "script.py"
    path.write_text(SCRIPT)
    run = subprocess.run([sys.executable, str(path), *arguments], capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (code, printed)
    assert said in run.stderr
    assert ("Traceback" in run.stderr) == (code == 1)


def test_no_tool_is_run_otherwise():
    assert [path.name for path in TOOLS.rglob("*.py") if "typer.run(" in path.read_text()] == []
