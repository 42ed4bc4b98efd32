"""Modules of users, which Python imports from a folder for a while."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def importable_from(folder: Path) -> Iterator[None]:
    """Modules of this folder can be imported; those that were stay loaded."""
    sys.path.append(str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
