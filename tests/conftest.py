"""What several tests need."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def reference_data() -> Path:
    """Folder of the original program's inputs and recordings and of measured data; not part of the project."""
    folder = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no reference data: {folder} is not a folder; WARPMUSCLE_REFERENCE_DATA names it")
    return folder
