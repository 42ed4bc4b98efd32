"""A copy of the repository in which mutations are tried, one after another."""

from __future__ import annotations

import compileall
import os
import py_compile
import re
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mutations.changes import Mutation
from mutations.tests_of import ordered_tests

COPIED = ("warpmuscle", "tests", "tools", "docs", "pyproject.toml", "README.md", "setup.py")
# As `pytest -v` writes them; what stands in brackets may have spaces.
FAILED = re.compile(r"^(\S+?\.py::.+?) (?:FAILED|ERROR) +\[ *\d+%\]$", re.MULTILINE)
NOT_IMPORTED = re.compile(r"^ERROR (\S+?\.py)(?: - .*)?$", re.MULTILINE)
RUNNING = re.compile(r"^(tests/\S+?\.py::.+?)(?: (?:PASSED|FAILED|ERROR|SKIPPED|XFAIL|XPASS).*)?$", re.MULTILINE)
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

    def try_one(self, mutation: Mutation, limit: float, most: int | None = None) -> Outcome:
        """Apply a mutation, run the tests that may see it until one fails, and take it back.

        Args:
            limit: s, for all of them. most: test files, at most.
        """
        begin, cpu, left_out = time.monotonic(), 0.0, list[str]()
        tests = ordered_tests(self.folder, mutation.path, mutation.line)[:most]
        path = self.folder / mutation.path
        original = path.read_bytes()
        while True:
            path.write_bytes(mutation.applied(original))
            try:
                run = self._pytest(tests, limit - (time.monotonic() - begin), left_out)
            finally:
                path.write_bytes(original)
            cpu += run.cpu
            suspect = run.failed or (run.running if run.code is None else "")
            status = "survived" if run.code == 0 else "unfinished"
            if run.failed or (suspect and run.silent > MARGIN):
                known = self._unchanged(suspect)
                cpu += known.cpu
                if run.failed and known.code != 0 and time.monotonic() - begin < limit:
                    left_out.append(suspect)  # fails here without the mutation; a file is one that cannot be imported
                    tests = [test for test in tests if test != suspect]
                    continue
                hangs = run.code is None and run.silent > HANGS * known.seconds + MARGIN
                status = "caught" if known.code == 0 and (run.failed or hangs) else "unfinished"
            elif run.code not in (0, None):  # a crash of the process, of which pytest tells nothing
                status, suspect = "caught", f"code {run.code} in {run.running or 'the start of pytest'}"
            return Outcome(mutation, status, suspect, time.monotonic() - begin, cpu)

    def check(self) -> None:
        """Raise RuntimeError with what pytest says if it cannot run tests at all, as where a package is missing."""
        run = self._pytest(["tests/core/test_pose.py"], 600.0, [])
        if run.code != 0:
            raise RuntimeError(f"no test can run here: {run.output.strip()[-500:]}")

    def _unchanged(self, test: str) -> _Run:
        """The same test without the mutation; what passed once passes for all copies."""
        known = self.kernels / "passes" / re.sub(r"\W+", "-", test)
        if known.exists():
            return _Run(0, "", float(known.read_text()), 0.0, 0.0)
        run = self._pytest([test], 600.0, [])
        if run.code == 0:
            known.parent.mkdir(parents=True, exist_ok=True)
            known.write_text(str(run.seconds))
        return run

    def _pytest(self, tests: list[str], limit: float, left_out: list[str]) -> _Run:
        """Run test files, or tests, in this order until one fails."""
        command = [sys.executable, "-m", "pytest", "-x", "-v", "-n", "0", "-p", "no:cacheprovider", "--tb", "no"]
        command += [f"--deselect={test}" for test in left_out]
        temporary = self.home / "temporary"
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir()
        paths = [str(self.folder), *filter(None, [os.environ.get("PYTHONPATH")])]  # where packages of the session are
        environment = {
            **os.environ, "PYTHONPATH": os.pathsep.join(paths), "WARP_CACHE_PATH": str(self.kernels),
            "WARPMUSCLE_REFERENCE_DATA": str(self.home / "absent"), "TMPDIR": str(temporary),
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "CUDA_VISIBLE_DEVICES": "",
        }  # fmt: skip
        written = self.home / "output"
        before, begin = _children(), time.monotonic()
        with written.open("wb") as file:
            process = subprocess.Popen(
                [*command, *tests], cwd=self.folder, env=environment, stdout=file, stderr=file, start_new_session=True
            )
            try:
                code: int | None = process.wait(max(limit, 1.0))
            except subprocess.TimeoutExpired:
                code = None
            silent = time.time() - written.stat().st_mtime
            with suppress(ProcessLookupError):
                os.killpg(process.pid, 9)  # also what tests have started and a crash has left
            process.wait()
        output = written.read_text(errors="replace")
        return _Run(code, output, time.monotonic() - begin, _children() - before, silent)


def _children() -> float:
    """CPU seconds of the processes that this one has started and that have ended."""
    times = os.times()
    return times.children_user + times.children_system
