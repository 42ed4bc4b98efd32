"""The tier of a file of tests, by what it imports: nothing has to be kept up by hand.

A file is of the tier `fast` unless it, or what it imports from the folders that tests keep theirs in, imports what
compiles and launches kernels or starts processes. `tests/conftest.py` fails a fast test that launches a kernel.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Packages whose functions launch kernels, `warpmuscle` itself as `wm` among them, and what takes as long.
SLOW = (
    *("warpmuscle", "warp", "mujoco", "opensim", "playwright", "runpy", "subprocess", "multiprocessing"),
    "warpmuscle.model.build",  # puts arrays on a device, for which Warp has to start
    *(
        f"warpmuscle.{package}"
        for package in (
            *("kernels", "simulation", "optimization", "learning", "studies", "inverse", "view", "gym", "report"),
            *("throw", "sweep", "session", "examples", "cli"),
        )
    ),
)


@cache
def is_fast(path: Path, folders: tuple[str, ...]) -> bool:
    """Whether a file is of the tier `fast`.

    Args:
        folders: relative to the root, where tests find the modules that they share, as `pythonpath` in pyproject.toml.
    """
    return slow_import(path, folders) == ""


def slow_import(path: Path, folders: tuple[str, ...]) -> str:
    """What a file imports that keeps it out of the tier `fast`; empty if there is none."""
    seen, left = set(), [path]
    while left:
        file = left.pop()
        seen.add(file)
        for module, names in imports(file):
            if module in SLOW[1:] or module.startswith(tuple(f"{slow}." for slow in SLOW[1:])):
                return module
            if module == "warpmuscle" and not names:
                return module
            shared = (ROOT / folder / f"{module}.py" for folder in folders)
            left.extend(file for file in shared if file.exists() and file not in seen)
    return ""


@cache
def imports(path: Path) -> list[tuple[str, tuple[str, ...]]]:
    """Modules that a file imports anywhere, each with what it takes from it; of `from a import b` also `a.b`."""
    return list(_imports(ast.parse(path.read_text())))


def _imports(tree: ast.AST) -> Iterator[tuple[str, tuple[str, ...]]]:
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, ()) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = tuple(alias.name for alias in node.names)
            yield node.module, names
            yield from ((f"{node.module}.{name}", names) for name in names)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All statements of a file, however deep; expressions, which are most of it, hold no imports."""
    left = [tree]
    while left:
        node = left.pop()
        yield node
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            left.extend(getattr(node, part, ()))
