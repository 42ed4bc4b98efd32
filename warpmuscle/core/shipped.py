"""Where the shipped scenes lie."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path


def scenes_folder() -> Path:
    """The folder of the scenes that come with the package.

    It is looked up, not imported: an imported `warpmuscle.scenes` would take the name of the function.
    """
    spec = find_spec("warpmuscle.scenes")
    assert spec is not None
    return Path((spec.submodule_search_locations or [""])[0])
