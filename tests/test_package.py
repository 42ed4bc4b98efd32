"""The package as one meets it in an interpreter, and the program as one meets it in a shell."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from setuptools import find_packages

import warpmuscle as wm
from patience import PATIENCE
from user_file import KNOWN, USER_FILE
from warpmuscle.formats import scene_names

ROOT = Path(__file__).parents[1]


def warpmuscle(*words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m warpmuscle`."""
    command = [sys.executable, "-m", "warpmuscle", *words]
    return subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, timeout=PATIENCE)


def test_the_package_lists_what_it_offers_before_it_is_imported():
    code = "import warpmuscle; print(*dir(warpmuscle))"
    listed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE
    ).stdout.split()
    assert set(wm.__all__) <= set(listed)
    assert [name for name in listed if not name.startswith("_")] == [n for n in sorted(wm.__all__) if n[0] != "_"]


def test_everything_that_is_listed_can_be_had():
    assert all(getattr(wm, name) is not None for name in dir(wm))


def test_the_version_is_that_of_the_installed_package():
    assert wm.__version__ == version("warpmuscle")


def test_a_wheel_has_every_package_and_all_that_lies_in_it():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    found = find_packages(str(ROOT), include=settings["packages"]["find"]["include"])
    folders = {ROOT.joinpath(*name.split(".")): name for name in found}
    assert folders.keys() == {init.parent for init in (ROOT / "warpmuscle").rglob("__init__.py")}
    for file in (ROOT / "warpmuscle").rglob("*.*"):
        if file.suffix in (".py", ".pyc") or file.is_dir():
            continue
        package = next(folder for folder in file.parents if folder in folders)
        patterns = settings["package-data"].get(folders[package], [])
        assert any(file.relative_to(package).match(pattern) for pattern in patterns), file


def test_nothing_needs_the_links_at_the_top(tmp_path: Path):
    """A checkout without links, as on Windows, has files there that hold a path."""
    for name in ("kernels", "scenes"):
        assert (ROOT / name).resolve() == ROOT / "warpmuscle" / name
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "warpmuscle", tmp_path / "warpmuscle", ignore=ignored)
    for name in ("kernels", "scenes"):
        (tmp_path / name).write_text(f"warpmuscle/{name}")
    code = "import warpmuscle as wm, warpmuscle.kernels as k; print(k.__file__); wm.load('walk56')"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()) == tmp_path / "warpmuscle" / "kernels" / "__init__.py"


def test_the_first_clone_on_the_path_brings_its_own_kernels(tmp_path: Path):
    """Also where another is installed."""
    copied, elsewhere = tmp_path / "clone", tmp_path / "elsewhere"
    elsewhere.mkdir()
    shutil.copytree(ROOT / "warpmuscle", copied / "warpmuscle", ignore=shutil.ignore_patterns("__pycache__"))
    packages = [f"import_module('warpmuscle.{name}').__file__" for name in ("kernels.step", "scenes")]
    code = f"from importlib import import_module; print({', '.join(packages)})"
    given = os.environ | {"PYTHONPATH": str(copied)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=elsewhere, env=given, capture_output=True, text=True, timeout=PATIENCE)
    assert done.stdout.count(str(copied)) == 2, done.stdout + done.stderr


def test_mypy_finds_the_types_of_what_is_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """From any folder, in the package and its kernels; what it knows of them is shown in test_style.py."""
    finder = pytest.importorskip("mypy.modulefinder", reason="no mypy: pip install mypy")
    options = pytest.importorskip("mypy.options").Options()
    monkeypatch.chdir(tmp_path)
    folders = [folder for some in finder.get_search_dirs(sys.executable) for folder in some]
    found = finder.FindModuleCache(finder.SearchPaths((), (), tuple(folders), ()), None, options)
    for name, file in (("warpmuscle", "__init__.py"), ("warpmuscle.kernels.muscle.muscle", "kernels/muscle/muscle.py")):
        assert found.find_module(name) == str(ROOT / "warpmuscle" / file)  # else why not, as without py.typed
    (tmp_path / "typeless").mkdir()
    (tmp_path / "typeless" / "__init__.py").touch()
    other = finder.FindModuleCache(finder.SearchPaths((), (), (str(tmp_path),), ()), None, options)
    assert not isinstance(other.find_module("typeless"), str)


def test_pyright_of_a_user_knows_the_types_of_what_is_installed(tmp_path: Path):
    pytest.importorskip("pyright", reason="no pyright: pip install pyright")
    (tmp_path / "mine.py").write_text(USER_FILE)
    own = ["--pythonpath", sys.executable]  # else it asks the `python` of the path
    command = [sys.executable, "-m", "pyright", *own, "mine.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    told = done.stdout + done.stderr
    assert done.returncode == 0, told
    for line in KNOWN:
        assert re.search(line, told), told


def test_python_runs_the_package_and_it_tells_its_version():
    done = warpmuscle("--version")
    assert (done.returncode, done.stdout) == (0, f"warpmuscle {wm.__version__}\n")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_gets_a_script_for_completion(shell: str):
    done = warpmuscle("--show-completion", shell, _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1")
    assert done.returncode == 0, done.stderr
    assert f"_WARPMUSCLE_COMPLETE=complete_{shell}" in done.stdout


@pytest.mark.parametrize(
    "words", ["info wa", "optimize fwalk wa", "view wa", "apply a.h5 --on wa", "throw fit --scene wa"]
)
def test_names_of_shipped_scenes_are_completed(words: str):
    line = f"warpmuscle {words}"
    count = len(line.split()) - 1
    done = warpmuscle(COMP_WORDS=line, COMP_CWORD=str(count), _WARPMUSCLE_COMPLETE="complete_bash")
    assert done.stdout.split() == [name for name in scene_names() if name.startswith("wa")]


def test_what_no_scene_begins_with_is_left_to_the_shell_which_names_files(tmp_path: Path):
    done = warpmuscle(COMP_WORDS="warpmuscle info ./", COMP_CWORD="2", _WARPMUSCLE_COMPLETE="complete_bash")
    assert done.stdout.strip() == ""
