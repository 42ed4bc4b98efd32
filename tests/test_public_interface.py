"""What users may import suffices: three packages of studies import nothing else."""

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

import warpmuscle as wm
from warpmuscle.session.public import PUBLIC

ROOT = Path(__file__).parents[1] / "warpmuscle"
STUDIES = ("throw", "synergy", "markers")
FILES = [file for study in STUDIES for file in sorted((ROOT / study).rglob("*.py"))]
NAMES = [(module, name) for module, names in PUBLIC.items() for name in names]


def used(file: Path) -> Iterator[tuple[str, str]]:
    """Modules of the package, without `warpmuscle`, and names that a file imports, or uses of a module."""
    tree = ast.parse(file.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            assert not any(alias.name.split(".")[0] == "warpmuscle" for alias in node.names), ast.unparse(node)
        if not isinstance(node, ast.ImportFrom) or (node.module or "").split(".")[0] != "warpmuscle":
            continue
        module = (node.module or "").removeprefix("warpmuscle").removeprefix(".")
        for name in (alias.name for alias in node.names):
            whole = f"{module}.{name}"
            yield from of_module(tree, name, whole) if inspect.ismodule(value(module, name)) else [(module, name)]


def of_module(tree: ast.Module, name: str, module: str) -> list[tuple[str, str]]:
    """What is used of a module that was imported by a name."""
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    return [(module, node.attr) for node in nodes if isinstance(node.value, ast.Name) and node.value.id == name]


def value(module: str, name: str) -> object:
    """What a module of the package has by a name, which may be a module."""
    found = getattr(import_module(f"warpmuscle.{module}".rstrip(".")), name, None)
    return import_module(f"warpmuscle.{module}.{name}") if found is None else found


def is_public(module: str, name: str) -> bool:
    """Whether users may import a name: it is of the top level, or listed with its module."""
    if name in PUBLIC.get(module, ()):
        return True
    return name in wm.__all__ and getattr(wm, name) is value(module, name)


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(ROOT)))
def test_a_study_imports_nothing_but_what_users_may(file: Path):
    others = {(module, name) for module, name in used(file) if module.split(".")[0] not in STUDIES}
    assert sorted(f"{module}.{name}" for module, name in others if not is_public(module, name)) == []


def test_something_private_would_be_noticed(tmp_path: Path):
    file = tmp_path / "mine.py"
    file.write_text("from warpmuscle.core import hdf5\nfrom warpmuscle.results.layout import put\nhdf5._product")
    assert [is_public(*one) for one in used(file)] == [False, False]


@pytest.mark.parametrize(("module", "name"), NAMES, ids=lambda value: str(value))
def test_a_public_name_is_there_says_what_it_is_and_is_used(module: str, name: str):
    found = value(module, name)
    if inspect.isfunction(found) or (inspect.isclass(found) and found.__module__.startswith("warpmuscle")):
        assert inspect.getdoc(found)
    assert any((module, name) in set(used(file)) for file in FILES)
