"""Nothing in the current folder runs: neither this process nor any that it starts imports from there."""

import importlib.metadata
import subprocess
import sys
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from patience import PATIENCE
from small_result import walk_result
from warpmuscle.results.result import write
from warpmuscle.synergy.c3d import read_c3d

NEVER = {"builtins", "marshal", "sys", "time"}  # which no folder can replace


@pytest.fixture
def poisoned(tmp_path, monkeypatch) -> Path:
    """The current folder, with a module of every name that there is, each of which leaves a mark where it runs."""
    names = set(sys.stdlib_module_names) | set(importlib.metadata.packages_distributions()) | {"sitecustomize"}
    names |= {"usercustomize", "ray", "ezc3d", "numpy"}
    folder = tmp_path / "folder"
    folder.mkdir()
    for name in names - NEVER:
        mark = f"import posix\nposix.open({str(tmp_path / f'{name}.ran')!r}, posix.O_CREAT)\n"
        (folder / f"{name}.py").write_text(mark.replace("\\\n", "\n") + "raise SystemExit('this should not run')\n")
    (folder / "matplotlibrc").write_text("text.usetex: True\nfont.size: 40\n")
    monkeypatch.chdir(folder)
    return folder


def ran(folder: Path) -> list[str]:
    """Which of its modules ran."""
    return sorted(path.stem for path in folder.parent.glob("*.ran"))


def test_mark_is_left_where_a_process_does_import_from_the_current_folder(poisoned):
    subprocess.run([sys.executable, "-c", "import numpy"], capture_output=True)
    assert ran(poisoned)


def test_reading_a_c3d_file_imports_nothing_from_the_current_folder(poisoned):
    content = ezc3d.c3d()
    content["parameters"]["ANALOG"]["RATE"]["value"] = [1000]
    content["parameters"]["ANALOG"]["LABELS"]["value"] = ["BIC"]
    content["parameters"]["POINT"]["RATE"]["value"] = [100]
    content["parameters"]["POINT"]["LABELS"]["value"] = ["marker"]
    content["data"]["points"] = np.zeros((4, 1, 5))
    content["data"]["analogs"] = np.ones((1, 1, 50))
    content.write("emg.c3d")
    names, rate, values = read_c3d(Path("emg.c3d"))
    assert (names, rate, values.shape) == (("BIC",), 1000.0, (50, 1))
    assert not ran(poisoned)


# Commands one after the other, each of which imports what those before it did not need.
COMMANDS = """
import sys
from warpmuscle.cli.program import main

for command in (
    "simulate fwalk --duration 0.2 -o run.h5 --plot run.png", "plot run.h5 --what joints -o joints.svg",
    "report run.h5", "export run.h5 -o run.csv", "video run.h5 -o run.mp4",
):
    sys.argv = ["warpmuscle", *command.split()]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise
"""


def test_commands_import_nothing_from_the_current_folder(poisoned):
    """As the installed script starts them: without the current folder among those of modules."""
    done = subprocess.run([sys.executable, "-P", "-c", COMMANDS], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    files = {file.name for file in poisoned.iterdir()}
    assert {"run.h5", "run.png", "joints.svg", "run.csv", "run.mp4"} <= files
    assert not ran(poisoned)


def test_module_as_a_command_takes_no_package_from_the_current_folder(tmp_path, monkeypatch):
    for name in ("numpy", "h5py", "typer", "rich", "msgspec", "matplotlib"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('this should not run')\n")
    monkeypatch.chdir(tmp_path)
    done = subprocess.run([sys.executable, "-m", "warpmuscle", "info", "fwalk"], capture_output=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr


def test_figures_do_not_follow_a_matplotlibrc_of_the_current_folder(poisoned, tmp_path):
    write(tmp_path / "run.h5", walk_result())
    for folder in (poisoned, tmp_path):
        done = subprocess.run(
            [sys.executable, "-P", "-c", "from warpmuscle.__main__ import main; main()",
             "plot", str(tmp_path / "run.h5"), "--what", "joints", "-o", str(folder / "joints.svg")],
            cwd=folder, capture_output=True, text=True, timeout=PATIENCE,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    assert (poisoned / "joints.svg").read_bytes() == (tmp_path / "joints.svg").read_bytes()
