"""Modules of users, which Python imports from a folder for a while."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest


@contextmanager
def importable_from(folder: Path) -> Iterator[None]:
    """Modules of this folder can be imported; those that were stay loaded."""
    sys.path.append(str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))


def module_of(name: str, text: str) -> Any:
    """A fixture of a file of tests: all of them can import this module."""

    @pytest.fixture(scope="module", autouse=True)
    def module(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
        folder = tmp_path_factory.mktemp("theirs")
        (folder / f"{name}.py").write_text(text)
        with importable_from(folder):
            yield

    return module
