"""A copy of the repository in which mutations are tried, one after another."""

from __future__ import annotations

import compileall
import hashlib
import os
import py_compile
import re
import shutil
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import chain, repeat
from pathlib import Path
from typing import Any

from mutations.changes import Mutation
from mutations.sessions import Sessions
from mutations.tests_of import Order

TOOLS = Path(__file__).parents[1]
COPIED = ("warpmuscle", "tests", "tools", "docs", "pyproject.toml", "README.md", "setup.py")
# As `pytest -v` writes them; what stands in brackets may have spaces.
FAILED = re.compile(r"^(\S+?\.py::.+?) (?:FAILED|ERROR) +\[ *\d+%\]$", re.MULTILINE)
NOT_IMPORTED = re.compile(r"^ERROR (\S+?\.py)(?: - .*)?$", re.MULTILINE)
RUNNING = re.compile(r"^(tests/\S+?\.py::\w+(?:::\w+)*(?:\[.*\])?)", re.MULTILINE)  # a crash may write after it
BRIEF = "tests/kernels/", "tests/model/"  # as in tests/conftest.py
OPTIMIZED = re.compile(r"\b(optimized_test|mark\.optimized)\b")
BATCHES = 1, 3, 8, 16, 32  # test files of a session of pytest, which imports all of them first; of the rest the last
NOTHING_RAN = 5  # code of pytest where all tests of a session are left out
HANGS = 3.0  # times as long as without the mutation, at least, and this many seconds more, is "hangs"
MARGIN = 30.0


@dataclass(frozen=True)
class Outcome:
    """What became of a mutation."""

    mutation: Mutation
    status: str  # caught, survived, or unfinished: no test failed within the time that it had
    by: str  # the test that failed, or the one that ran when the time was over
    seconds: float
    cpu: float  # s, of all processes

    def as_dict(self) -> dict[str, Any]:
        """For a file of results."""
        return asdict(self)


@dataclass(frozen=True)
class _Run:
    """One session of pytest."""

    code: int | None  # None: stopped
    output: str
    seconds: float
    cpu: float
    silent: float  # s since it last wrote something, as it was stopped

    @property
    def failed(self) -> str:
        match = FAILED.search(self.output) or NOT_IMPORTED.search(self.output)
        return match[1] if match else ""

    @property
    def running(self) -> str:
        names = RUNNING.findall(self.output)
        return str(names[-1]).strip() if names else ""


class Trial:
    """A folder with a copy of what tests need; Warp's folder of compiled kernels is shared with others."""

    def __init__(self, root: Path, folder: Path, kernels: Path) -> None:
        self.folder = folder / "tree"
        shutil.rmtree(folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for name in COPIED:
            if (root / name).is_dir():
                shutil.copytree(root / name, self.folder / name, ignore=shutil.ignore_patterns("__pycache__"))
            elif (root / name).exists():
                shutil.copy(root / name, self.folder / name)
        # What was compiled is known by its content: a mutation may have the size and the second of its original.
        checked = py_compile.PycInvalidationMode.CHECKED_HASH
        for name in ("warpmuscle", "tests"):
            compileall.compile_dir(self.folder / name, quiet=2, invalidation_mode=checked)
        self.home = folder
        self.kernels = kernels
        (self.home / "temporary").mkdir()
        self.sessions = Sessions(self.folder, self._environment())
        self.order = Order(self.folder)
        self.passes = kernels / "passes" / _digest(self.folder)

    def try_one(self, mutation: Mutation, limit: float, most: int | None = None) -> Outcome:
        """Apply a mutation, run the tests that may see it until one fails, and take it back.

        Args:
            limit: s, for all of them. most: test files, at most.
        """
        begin, cpu = time.monotonic(), 0.0
        path = self.folder / mutation.path
        original = path.read_bytes()
        changed = mutation.applied(original)
        status, by = "survived", ""
        for batch in _batches(self.order.of(mutation.path, mutation.line)[:most]):
            path.write_bytes(changed)
            status, by, spent = self._batch(batch, path, original, begin + limit)
            cpu += spent
            if status != "survived":
                break
        return Outcome(mutation, status, by, time.monotonic() - begin, cpu)

    def _batch(self, tests: list[str], path: Path, original: bytes, end: float) -> tuple[str, str, float]:
        """Status, test and CPU time after these files of tests; `path` is changed, and `original` again afterwards."""
        changed, cpu, left_out = path.read_bytes(), 0.0, list[str]()
        brief = all(map(self._is_brief, tests))
        while True:
            path.write_bytes(changed)
            try:
                run = self._pytest(tests, end - time.monotonic(), left_out, brief)
            finally:
                path.write_bytes(original)
            cpu += run.cpu
            if run.code in (0, NOTHING_RAN):
                return "survived", "", cpu
            if run.code is not None and not (run.failed or run.running):
                return "caught", f"code {run.code} in the start of pytest", cpu
            # Where pytest tells nothing of a test that failed, its process has crashed in one, or was stopped.
            suspect = run.failed or run.running
            if run.code is None and not run.failed and (not suspect or run.silent <= MARGIN):
                return "unfinished", suspect, cpu
            known = self._unchanged(suspect, brief)
            cpu += known.cpu
            if known.code == 0:
                hangs = run.silent > HANGS * known.seconds + MARGIN
                caught = run.failed or run.code is not None or hangs
                crash = "" if run.failed or run.code is None else f"code {run.code} in "
                return "caught" if caught else "unfinished", crash + suspect, cpu
            if run.code is None or time.monotonic() >= end:
                return "unfinished", suspect, cpu
            left_out.append(suspect)  # fails here without the mutation; a file is one that cannot be imported
            tests = [test for test in tests if test != suspect]
            if not tests:
                return "survived", "", cpu

    def check(self) -> None:
        """Raise RuntimeError with what pytest says if it cannot run tests at all, as where a package is missing."""
        run = self._pytest(["tests/core/test_pose.py"], 600.0, [])
        if run.code != 0:
            raise RuntimeError(f"no test can run here: {run.output.strip()[-500:]}")

    def _is_brief(self, test: str) -> bool:
        """Whether a file of tests has its kernels compiled without optimisation; here those of all files, too."""
        return test.startswith(BRIEF) and not OPTIMIZED.search((self.folder / test).read_text())

    def _unchanged(self, test: str, brief: bool) -> _Run:
        """The same test without the mutation; what passed once passes for all copies."""
        known = self.passes / (re.sub(r"\W+", "-", test) + "-brief" * brief)
        if known.exists():
            return _Run(0, "", float(known.read_text()), 0.0, 0.0)
        run = self._pytest([test], 600.0, [], brief)
        if run.code == 0:
            known.parent.mkdir(parents=True, exist_ok=True)
            known.write_text(str(run.seconds))
        return run

    def _pytest(self, tests: list[str], limit: float, left_out: list[str], brief: bool = False) -> _Run:
        """Run test files, or tests, in this order until one fails."""
        arguments = [
            "-x",
            "-v",
            "-n",
            "0",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:faulthandler",
            "--tb",
            "no",
            "-p",
            "mutations.compiling",
        ]
        arguments += ["--unoptimized"] if brief else []
        arguments += [f"--deselect={test}" for test in left_out]
        temporary, written = self.home / "temporary", self.home / "output"
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir(exist_ok=True)
        written.touch()
        begin = time.monotonic()
        code, cpu = self.sessions.run([*arguments, *tests], written, limit)
        silent = time.time() - written.stat().st_mtime
        return _Run(code, written.read_text(errors="replace"), time.monotonic() - begin, cpu, silent)

    def _environment(self) -> dict[str, str]:
        """What sessions find: no reference data, and no GPU."""
        paths = [str(self.folder), str(TOOLS), *filter(None, [os.environ.get("PYTHONPATH")])]  # and of this process
        return {
            **{name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"},
            "PYTHONPATH": os.pathsep.join(paths), "WARP_CACHE_PATH": str(self.kernels),
            "WARPMUSCLE_REFERENCE_DATA": str(self.home / "absent"), "TMPDIR": str(self.home / "temporary"),
            "MUTATIONS_HEADERS": str(self.home / "headers"),
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "CUDA_VISIBLE_DEVICES": "",
        }  # fmt: skip


def _batches(tests: list[str]) -> Iterator[list[str]]:
    """Few files first: to import all that might run takes longer than most mutations live."""
    begin = 0
    for size in chain(BATCHES, repeat(BATCHES[-1])):
        if begin >= len(tests):
            return
        yield tests[begin : begin + size]
        begin += size


def _digest(folder: Path) -> str:
    """Of all Python files: what passed in another tree may fail in this one."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]
