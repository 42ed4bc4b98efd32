"""The package as one meets it in an interpreter, and the program as one meets it in a shell."""

import os
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import warpmuscle as wm
from warpmuscle.formats import scene_names

ROOT = Path(__file__).parents[1]


def warpmuscle(*words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m warpmuscle`."""
    command = [sys.executable, "-m", "warpmuscle", *words]
    return subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, timeout=300)


def test_the_package_lists_what_it_offers_before_it_is_imported():
    code = "import warpmuscle; print(*dir(warpmuscle))"
    listed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300).stdout.split()
    assert set(wm.__all__) <= set(listed)
    assert [name for name in listed if not name.startswith("_")] == [n for n in sorted(wm.__all__) if n[0] != "_"]


def test_everything_that_is_listed_can_be_had():
    assert all(getattr(wm, name) is not None for name in dir(wm))


def test_the_version_is_that_of_the_installed_package():
    assert wm.__version__ == version("warpmuscle")


def test_a_wheel_has_every_package_and_all_that_lies_in_it():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {ROOT / "kernels": "warpmuscle.kernels", ROOT / "scenes": "warpmuscle.scenes"}
    for init in (ROOT / "warpmuscle").rglob("__init__.py"):
        folders[init.parent] = ".".join(init.parent.relative_to(ROOT).parts)
    assert sorted(settings["packages"]) == sorted(folders.values())
    for file in (file for base in ("warpmuscle", "kernels", "scenes") for file in (ROOT / base).rglob("*.*")):
        if file.suffix in (".py", ".pyc") or file.is_dir():
            continue
        package = next(folder for folder in file.parents if folder in folders)
        patterns = settings["package-data"].get(folders[package], [])
        assert any(file.relative_to(package).match(pattern) for pattern in patterns), file


def test_python_runs_the_package_and_it_tells_its_version():
    done = warpmuscle("--version")
    assert (done.returncode, done.stdout) == (0, f"warpmuscle {wm.__version__}\n")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_gets_a_script_for_completion(shell: str):
    done = warpmuscle("--show-completion", shell, _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1")
    assert done.returncode == 0, done.stderr
    assert f"_WARPMUSCLE_COMPLETE=complete_{shell}" in done.stdout


@pytest.mark.parametrize("words", ["info wa", "optimize fwalk wa", "view wa", "apply a.h5 --on wa", "throw --scene wa"])
def test_names_of_shipped_scenes_are_completed(words: str):
    line = f"warpmuscle {words}"
    count = len(line.split()) - 1
    done = warpmuscle(COMP_WORDS=line, COMP_CWORD=str(count), _WARPMUSCLE_COMPLETE="complete_bash")
    assert done.stdout.split() == [name for name in scene_names() if name.startswith("wa")]


def test_what_no_scene_begins_with_is_left_to_the_shell_which_names_files(tmp_path: Path):
    done = warpmuscle(COMP_WORDS="warpmuscle info ./", COMP_CWORD="2", _WARPMUSCLE_COMPLETE="complete_bash")
    assert done.stdout.strip() == ""
