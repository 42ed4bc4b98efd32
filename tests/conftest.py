"""What several tests need."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import warp as wp

from warpmuscle.kernels import stages
from warpmuscle.kernels.curves import LEE
from warpmuscle.kernels.muscle_stage import HILL, RIGID, MuscleKind
from warpmuscle.kernels.scratch import capacity_of
from warpmuscle.kernels.step import step_kernel

SHARED = [(2, None), (9, None), (15, None), (2, MuscleKind(LEE, RIGID, HILL))]  # bodies, one a size class, and muscles


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what several test files use before parallel workers start, which then find it in Warp's cache."""
    wp.config.log_level = wp.LOG_WARNING
    wp.init()
    if not hasattr(session.config, "workerinput"):
        for bodies, muscles in SHARED:
            step_kernel(capacity_of(bodies), 1, 1, muscles).module.load("cpu")
        wp.load_module(stages, device="cpu")


@pytest.fixture(scope="session")
def reference_data() -> Path:
    """Folder of the original program's inputs and recordings and of measured data; not part of the project."""
    folder = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    folder = folder.resolve()
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder} is not a folder; WARPMUSCLE_REFERENCE_DATA names it")
    return folder


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A real Chromium without a window, as Playwright drives it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="no Playwright: pip install playwright")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no Chromium: apt-get install chromium")
    quiet = ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu", *quiet])
        yield opened
        opened.close()
