"""Which test files may see a change of a module, those first that are likely to see it soon."""

from __future__ import annotations

import ast
from collections import deque
from pathlib import Path

LEFT_OUT = (
    "tests/docs/", "tests/gpu/", "tests/tools/", "tests/test_style.py", "tests/test_distribution.py",
    "tests/test_readme.py", "tests/test_architecture.py", "tests/test_short_texts.py", "tests/video/",
    "tests/report/", "tests/view/", "tests/plots/", "tests/learning/networks/", "tests/learning/test_env.py",
    "tests/learning/test_rsl_rl.py", "tests/learning/test_skrl.py", "tests/learning/test_training.py",
)  # fmt: skip  # without physics, or for which PyTorch has to be there
SLOW = ("tests/cli/", "tests/sweep/", "tests/optimization/", "tests/throw/", "tests/gym/")  # and see little of physics
SIMULATING = "warpmuscle.simulation.rollout"
FAR = 99  # steps from a test to a module that it does not import


def module_of(path: str) -> str:
    """Dotted name of a file of the repository, as imports have it."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


class Order:
    """Order of the test files of a repository, for any of its modules; it is read once, which takes seconds."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.imports = _imports(root)
        self.simulating = _distances(self.imports, SIMULATING)
        tests = (str(p.relative_to(root)) for p in sorted((root / "tests").rglob("test_*.py")))
        self.tests = [test for test in tests if not test.startswith(LEFT_OUT)]

    def of(self, path: str, line: int | None = None) -> list[str]:
        """Test files for a module: the one that mirrors it, then those of its folder, those of `SLOW` last.

        Before those of its folder come files that are called as its function in this line is, then as any of its
        functions is; called as the module alone are many, which count if they import it or are in its folder or
        above. Of as many steps of imports: first those that simulate nothing. Files that never import it come last,
        since scenes are run by name, too; files without physics are left out.
        """
        folder = path.removeprefix("warpmuscle/").rsplit("/", 1)[0]
        distance = _distances(self.imports, module_of(path))
        mirror = f"tests/{folder}/test_{Path(path).stem}.py"
        module, own, every = _words_of(self.root / path, line)

        def key(test: str) -> tuple[bool, bool, int, int, bool, bool, str]:
            elsewhere = not test.startswith(f"tests/{folder}/")
            slow = test.startswith(SLOW) and elsewhere
            called, far = _words(Path(test).stem.removeprefix("test_")), distance.get(test, FAR)
            near = 0 if called <= own else 1 if called <= every else 2 if not elsewhere else 3
            above = f"tests/{folder}/".startswith(f"{Path(test).parent}/")
            if called <= module and not above and far > 1:
                near = 3
            return test != mirror, slow, near, far, self.simulating.get(test, FAR) <= 1, elsewhere, test

        return sorted(self.tests, key=key)


def _words(name: str) -> set[str]:
    """Words of a name, without the s of plurals."""
    return {word.rstrip("s") for word in name.lower().split("_") if word}


def _words_of(path: Path, line: int | None) -> tuple[set[str], set[str], set[str]]:
    """Words of a module's name; with those of its function in a line; and with those of all its functions."""
    module = _words(path.stem)
    functions = [node for node in ast.parse(path.read_bytes()).body if isinstance(node, ast.FunctionDef)]
    here = [one for one in functions if line is not None and one.lineno <= line <= (one.end_lineno or 0)]
    own, every = ({word for one in some for word in _words(one.name)} for some in (here, functions))
    return module, module | own, module | every


def _distances(imports: dict[str, set[str]], wanted: str) -> dict[str, int]:
    """Steps from every module or test to the wanted one."""
    importers: dict[str, set[str]] = {}
    for module, of in imports.items():
        for other in of:
            importers.setdefault(other, set()).add(module)
    distance, waiting = {wanted: 0}, deque([wanted])
    while waiting:
        module = waiting.popleft()
        for importer in importers.get(module, ()):
            if importer not in distance:
                distance[importer] = distance[module] + 1
                waiting.append(importer)
    return distance


def _imports(root: Path) -> dict[str, set[str]]:
    """What every module, and every file of tests by its path, imports; helpers of tests by their bare names."""
    found: dict[str, set[str]] = {}
    for path in (root / "warpmuscle").rglob("*.py"):
        found[module_of(str(path.relative_to(root)))] = _imported(path)
    for path in (root / "tests").rglob("*.py"):
        test = path.name.startswith("test_")
        found[str(path.relative_to(root)) if test else path.stem] = _imported(path)
    return found


def _imported(path: Path) -> set[str]:
    """Names of modules that a file imports, wherever the import stands."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names
