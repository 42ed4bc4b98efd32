"""What several tests need."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import warp as wp


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart() -> None:
    """Keep Warp quiet, and have it compile no derivatives of small kernels, which nothing here takes."""
    wp.config.log_level, wp.config.enable_backward = wp.LOG_WARNING, False
    wp.init()


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
