"""What several tests need."""

import importlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from shared_kernels import compile_all, settings
from warpmuscle.scene import trusted_code


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what many test files use before parallel workers start; a process by itself compiles what it uses."""
    settings()
    if session.config.pluginmanager.hasplugin("dsession"):  # what makes a process the controller of xdist's workers
        compile_all()


@pytest.fixture(autouse=True)
def distrustful(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test begins without trust in all code: a command with `--trust` lasts as long as its process."""
    monkeypatch.setattr(trusted_code, "_everything", False)


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
        opened = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu", *quiet])
        yield opened
        opened.close()
