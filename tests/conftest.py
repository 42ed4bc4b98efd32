"""What several tests need."""

import gc
import importlib
import os
import shutil
import signal
import sys
from collections import Counter
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest

import environment
import kernel_tests
import loaded_once
import tiers
from patience import PATIENCE
from warpmuscle.scene import trusted_code

environment.keep_byte_code(Path(__file__).parents[1])
environment.one_thread()

# Folders whose files have kinds of scenes of their own, and run them for moments.
BRIEF = {"creatures", "kernels", "model"}


def is_fast(path: Path, config: pytest.Config) -> bool:
    """Whether a file of tests is of the tier `fast`, see `tiers`."""
    return tiers.is_fast(path, tuple(map(str, config.getini("pythonpath"))))


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even import files of other tiers for `-m fast`."""
    if config.option.markexpr == "fast" and collection_path.is_file() and not is_fast(collection_path, config):
        return True
    return None


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> None:
    """Start Warp with the settings of tests before a file of them that uses it is imported."""
    if not is_fast(module_path, parent.config):
        kernel_tests.start()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what is fast, and put it last for parallel workers: short files even out what they have left to do.

    One process keeps the order in which files were given, for those who look for the first test that fails.
    """
    no_constants_for_hypothesis()
    for item in items:
        if is_fast(item.path, config) and item.get_closest_marker("long") is None:
            item.add_marker("fast")
    if not hasattr(config, "workerinput"):
        return
    tests_of = Counter(item.path for item in items)
    items.sort(key=lambda item: place(item.path, tests_of[item.path], config))


def no_constants_for_hypothesis() -> None:
    """Keep Hypothesis from parsing the whole package for numbers to try, for seconds in each worker.

    It has those of its own that are on the edge of what is allowed, and tests here give it ranges.
    """
    providers = sys.modules.get("hypothesis.internal.conjecture.providers")
    none = getattr(providers, "_local_constants", None)
    if hasattr(providers, "_get_local_constants") and none is not None:
        providers._get_local_constants = lambda: none


def place(path: Path, tests: int, config: pytest.Config) -> tuple[bool, bool, int, Path]:
    """Where a file of so many tests stands in line, whichever way it was found."""
    return is_fast(path, config), not starts_processes(path), -tests, path


def pytest_xdist_auto_num_workers() -> int | None:
    """One worker more than processors: while two wait for a kernel that one of them compiles, or for a process."""
    if os.environ.get("PYTEST_XDIST_AUTO_NUM_WORKERS"):
        return None
    return (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1) + 1


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    """Workers collect from the begin, the end or the middle: most files they then find rewritten by others."""
    report = yield
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    if isinstance(collector, pytest.Dir) and worker % 3 == 1:
        report.result.reverse()
    elif isinstance(collector, pytest.Dir) and worker % 3 == 2:
        middle = len(report.result) // 2
        report.result[:] = report.result[middle:] + report.result[:middle]
    return report


def pytest_collectstart(collector: pytest.Collector) -> None:
    """Look for no garbage while tests are collected, which makes a million objects that stay."""
    if isinstance(collector, pytest.Session):
        gc.disable()


def pytest_collection_finish() -> None:
    """Look for garbage from then on, but not among these, and seldom: most of what tests make goes without it."""
    loaded_once.start()
    gc.freeze()
    gc.set_threshold(20_000, 20)
    gc.enable()


def starts_processes(path: Path) -> bool:
    """Whether a file of tests says that it starts processes, each of which takes seconds."""
    return any(module == "subprocess" for module, _ in tiers.imports(path))


@pytest.fixture(autouse=True)
def no_kernels_in_fast_tests(request: pytest.FixtureRequest) -> Iterator[None]:
    """A test of the tier `fast` launches no kernel, and starts Warp only where another test has."""
    if request.node.get_closest_marker("fast") is None:
        yield
        return
    before, started = kernel_tests.loads(), has_started()
    yield
    if kernel_tests.loads() > before or has_started() > started:
        pytest.fail("a fast test launches no kernel; `import warp` in its file puts it into the tier of those that do")


def has_started() -> bool:
    """Whether Warp runs in this process."""
    return getattr(sys.modules.get("warp._src.context"), "runtime", None) is not None


@pytest.fixture(autouse=True)
def distrustful(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test begins without trust in all code: a command with `--trust` lasts as long as its process."""
    monkeypatch.setattr(trusted_code, "_everything", False)


@pytest.fixture(autouse=True)
def no_lines_for_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands within a test say no more on a slow machine than on a quick one, but for those of test_console.py."""
    console = sys.modules.get("warpmuscle.cli.console")
    if console is not None:
        for name in ("SILENCE", "LINES"):
            monkeypatch.setattr(console, name, PATIENCE)


@pytest.fixture(scope="module")
def unoptimized_kernels() -> Iterator[None]:
    """Have kernels for kinds of scenes compiled without optimisation, in a third of the time, to run 40 times as long.

    For files whose scenes are like no others', of few bodies and few steps. What a scene's step does is shown as well.
    """
    with kernel_tests.unoptimized():
        yield


@pytest.fixture
def unoptimized_test() -> Iterator[None]:
    """The same as `unoptimized_kernels` for one test of a file whose other tests run for long."""
    with kernel_tests.unoptimized():
        yield


@pytest.fixture
def optimized_test() -> Iterator[None]:
    """The opposite, for one test that runs for long in a file whose others do not."""
    with kernel_tests.optimized():
        yield


@pytest.fixture(scope="module", autouse=True)
def no_optimisation_of_what_is_brief(request: pytest.FixtureRequest) -> None:
    """Have `unoptimized_kernels` in the files of these folders that launch kernels and are not marked `optimized`."""
    folder = request.path.relative_to(Path(__file__).parent).parts[0]
    optimized = request.node.get_closest_marker("optimized") is not None
    if folder in BRIEF and not optimized and not is_fast(request.path, request.config):
        request.getfixturevalue("unoptimized_kernels")


@pytest.fixture(scope="session", autouse=True)
def shared_headers(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Have parallel workers compile Warp's headers once."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        kernel_tests.share_headers(tmp_path_factory.getbasetemp().parent / "headers")


@pytest.fixture(scope="session")
def reference_data() -> Path:
    """Folder of the original program's inputs and recordings and of measured data; not part of the project."""
    folder = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    folder = folder.resolve()
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder} is not a folder; WARPMUSCLE_REFERENCE_DATA names it")
    return folder


@pytest.fixture(scope="session")
def mujoco_oracle() -> Any:
    """The module of that name, for tests that compare with MuJoCo beside others that need it not."""
    pytest.importorskip("mujoco", reason="no MuJoCo: pip install mujoco")
    return importlib.import_module("mujoco_oracle")


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A real Chromium without a window, as Playwright drives it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install playwright")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no Chromium: apt-get install chromium")
    quiet = ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--disable-gpu", *quiet], timeout=1000.0 * PATIENCE
        )
        yield PatientBrowser(opened)
        opened.close()


class PatientBrowser:
    """A browser whose pages take the time that they need."""

    def __init__(self, browser: Any) -> None:
        self._browser = browser

    def new_page(self, **options: Any) -> Any:
        """See Playwright's `Browser.new_page`."""
        page = self._browser.new_page(**options)
        page.set_default_timeout(1000.0 * PATIENCE)
        return page

    def new_context(self, **options: Any) -> Any:
        """See Playwright's `Browser.new_context`."""
        context = self._browser.new_context(**options)
        context.set_default_timeout(1000.0 * PATIENCE)
        return context


@pytest.fixture
def hears_ctrl_c() -> Iterator[None]:
    """Hear Ctrl-C also where tests run in the background of a shell, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
