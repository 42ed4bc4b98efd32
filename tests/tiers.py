"""The tier of a file of tests, by what it imports: nothing has to be kept up by hand.

A file is of the tier `fast` unless it, or what it imports from the folders that tests keep theirs in, imports what
compiles and launches kernels or starts processes. `tests/conftest.py` fails a fast test that launches a kernel.
"""

import ast
import re
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


SLOW_MODULES, SLOW_PREFIXES = frozenset(SLOW[1:]), tuple(f"{slow}." for slow in SLOW[1:])
# Strings and comments, which hold no statement, and imports at the begin of a line.
IMPORTS = re.compile(
    r""""{3}(?:\\.|[^\\])*?"{3}|'{3}(?:\\.|[^\\])*?'{3}|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|\#[^\n]*"""
    r"|^[ \t]*(import[ ][^\n#;]*|from[ ][^\n]*[ ]import[ ](?:\((?:[^)#]|#[^\n]*)*\)|[^\n#;(]*))",
    re.DOTALL | re.MULTILINE,
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
    seen, left, shared = set(), [path], shared_modules(folders)
    while left:
        file = left.pop()
        seen.add(file)
        for module, names in imports(file):
            if module in SLOW_MODULES or module.startswith(SLOW_PREFIXES) or (module == "warpmuscle" and not names):
                return module
            if module in shared and shared[module] not in seen:
                left.append(shared[module])
    return ""


@cache
def shared_modules(folders: tuple[str, ...]) -> dict[str, Path]:
    """Files in the folders of what tests share, by the name that each is imported by."""
    return {file.stem: file for folder in reversed(folders) for file in (ROOT / folder).glob("*.py")}


def import_statements(path: Path) -> list[ast.stmt]:
    """The import statements of a file, wherever they stand.

    Only these are parsed, a twentieth of what to parse all of it takes: each worker looks at each file of tests.
    """
    return ast.parse("\n".join(found[1] for found in IMPORTS.finditer(path.read_text("utf-8")) if found[1])).body


@cache
def imports(path: Path) -> list[tuple[str, tuple[str, ...]]]:
    """Modules that a file imports anywhere, each with what it takes from it; of `from a import b` also `a.b`."""
    return list(_imports(path))


def _imports(path: Path) -> Iterator[tuple[str, tuple[str, ...]]]:
    for node in import_statements(path):
        if isinstance(node, ast.Import):
            yield from ((alias.name, ()) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = tuple(alias.name for alias in node.names)
            yield node.module, names
            yield from ((f"{node.module}.{name}", names) for name in names)
