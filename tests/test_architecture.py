"""The order of packages: each imports only from those before it, however late it does so."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import tiers

ROOT = Path(__file__).parents[1]
# From the lowest to the highest. Those of one line know nothing of each other.
ORDER: tuple[tuple[str, ...], ...] = (
    ("kernels", "scenes"),
    ("core",),
    ("search", "synergy"),
    ("markers",),
    ("scene",),
    ("results",),
    ("model",),
    ("formats",),
    ("gait",),
    ("simulation",),
    ("optimization",),
    ("learning",),
    ("studies",),
    ("creatures", "walking"),
    ("inverse",),
    ("plots", "view"),
    ("video",),
    ("gym",),
    ("report",),
    ("throw", "sweep", "session"),
    ("examples",),
    ("cli",),
)
LEVEL = {package: level for level, packages in enumerate(ORDER) for package in packages}
LARGEST = 26  # modules of a package


def modules() -> dict[str, Path]:
    """Files of the package by the dotted names of their modules, without `warpmuscle`."""
    found = {}
    for file in (ROOT / "warpmuscle").rglob("*.py"):
        parts = file.relative_to(ROOT / "warpmuscle").with_suffix("").parts
        found[".".join(part for part in parts if part != "__init__")] = file
    return found


MODULES = modules()


@cache
def imported(file: Path) -> frozenset[str]:
    """Names of the project's own modules that a file imports anywhere, also within functions and for types alone."""
    return frozenset(_imported(file))


def _imported(file: Path) -> Iterator[str]:
    for node in tiers.import_statements(file):
        if isinstance(node, ast.Import):
            yield from (alias.name.removeprefix("warpmuscle.") for alias in node.names if own(alias.name))
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: imports name the whole path"
            if own(node.module or ""):
                base = (node.module or "").removeprefix("warpmuscle").removeprefix(".")
                for alias in node.names:
                    full = f"{base}.{alias.name}".removeprefix(".")
                    yield full if full in MODULES else base


def own(name: str) -> bool:
    return name == "warpmuscle" or name.startswith("warpmuscle.")


PACKAGED = [name for name in MODULES if name.split(".")[0] in LEVEL]


def level(module: str) -> int:
    return LEVEL.get(module.split(".")[0], len(ORDER))


@pytest.mark.parametrize("package", LEVEL)
def test_modules_import_from_packages_before_their_own(package: str):
    own_modules = [name for name in PACKAGED if name.split(".")[0] == package]
    assert own_modules
    wrong = [
        f"{name} imports {other}"
        for name in own_modules
        for other in imported(MODULES[name])
        if other.split(".")[0] != package and level(other) >= LEVEL[package]
    ]
    assert wrong == []


def test_no_modules_import_each_other_in_a_circle():
    graph = {name: imported(MODULES[name]) - {name, name.rpartition(".")[0]} for name in PACKAGED}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise AssertionError(" -> ".join(error.args[1])) from None


def test_every_package_has_its_place_and_is_not_too_large():
    assert {name.split(".")[0] for name in MODULES} - {"", "__main__"} == set(LEVEL)
    kernels = ROOT / "warpmuscle" / "kernels"  # whose paths are public
    for package in {file.parent for file in MODULES.values()} - {kernels}:
        assert len([file for file in MODULES.values() if file.parent == package]) <= LARGEST + 1, package
    assert {file.name for file in (ROOT / "warpmuscle").iterdir() if file.is_file()} == {
        "__init__.py",
        "__main__.py",
        "py.typed",
    }


def said(package: str) -> set[str]:
    """What the docstring of a package says that it may import: names, perhaps with "and all below"."""
    text = ast.get_docstring(ast.parse(MODULES[package].read_text())) or ""
    assert "To add:" in text, package
    listed = re.search(r"^May import: ([a-z_., ]+)\.$", text, re.MULTILINE)
    assert listed, f"{package} does not say what it may import"
    names = set(re.split(r", | and ", listed[1].removesuffix(" and all below"))) - {"nothing"}
    assert names <= set(MODULES), f"{package}: {names - set(MODULES)}"
    if "all below" in listed[1]:
        highest = max(LEVEL[name] for name in names)
        names |= {name for name, level in LEVEL.items() if level <= highest}
    return names


SAID = {name: said(name) for name, file in MODULES.items() if file.name == "__init__.py" and name}


@pytest.mark.parametrize("package", sorted(SAID))
def test_a_package_imports_nothing_but_what_its_docstring_says(package: str):
    of_parts = tuple(
        f"{name}." for name in SAID if name.startswith(f"{package}.")
    )  # which have docstrings of their own
    own_modules = [name for name in PACKAGED if f"{name}.".startswith(f"{package}.")]
    found = {
        other
        for name in own_modules
        if not f"{name}.".startswith(of_parts or ("-",))
        for other in imported(MODULES[name])
    }
    allowed = tuple(f"{name}." for name in (package, *SAID[package]))
    assert {other for other in found if not f"{other}.".startswith(allowed)} == set()


PAGE = (ROOT / "docs" / "architecture.md").read_text()


def test_the_page_on_the_architecture_draws_the_same_order():
    drawing = PAGE.split("```text\n")[1].split("```")[0]
    drawn = [tuple(line.split("  ")[0].split()) for line in drawing.splitlines() if line.strip()]
    assert drawn == list(reversed(ORDER))


@pytest.mark.parametrize("name", sorted(set(re.findall(r"`([a-z_]+(?:\.\w+)+)`", PAGE)) - {"__init__.py"}))
def test_what_the_page_on_the_architecture_names_is_there(name: str):
    module, _, attribute = name.rpartition(".")
    assert name in MODULES or attribute in defined(MODULES[module])


def defined(file: Path) -> set[str]:
    """Names that a module defines at its top."""
    names: set[str] = set()
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


def test_single_names_on_the_page_are_of_modules_or_of_what_they_define():
    named = set(re.findall(r"`([A-Za-z_]+)`", PAGE))
    assert len(named) > 40
    left = named - {part for name in MODULES for part in name.split(".")} - {"__init__"}
    for text in (file.read_text() for file in MODULES.values()):
        if not left.intersection(re.findall(r"\w+", text)):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                left.discard(node.name)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                left.discard(node.id)
    assert left == set()


def test_the_page_has_every_folder_of_kernels():
    folders = {file.parent.name for file in (ROOT / "warpmuscle" / "kernels").glob("*/__init__.py")}
    assert set(re.findall(r"^\| `kernels/(\w+)` \|", PAGE, re.MULTILINE)) == folders


def test_files_that_a_part_is_to_be_added_to_are_there():
    rows = (ROOT / "docs/tutorials/own-parts.md").read_text().split("| to add | where |")[1]
    named = re.findall(r"`((?:warpmuscle|kernels)/[\w/]+(?:\.py)?)/?`", rows)
    assert len(named) > 12
    paths = [path.replace("NAME", "lee") for path in named]
    assert [path for path in paths if not (ROOT / re.sub("^kernels/", "warpmuscle/kernels/", path)).exists()] == []


def test_files_that_contributors_are_led_to_are_there():
    named = re.findall(r"`?((?:tools|tests|docs)/[\w/]+\.(?:py|md))", (ROOT / "CONTRIBUTING.md").read_text())
    assert len(named) > 15
    assert [path for path in named if not (ROOT / path).is_file()] == []
