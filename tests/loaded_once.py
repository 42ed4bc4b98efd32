"""Shipped scenes as tests have them: each is read and checked once a process, and whoever reads it again gets a copy.

To read one takes 20 to 60 ms, and a copy 2 to 8. Where a test has changed how scenes are read, they are read as ever.
"""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

from warpmuscle.formats import toml

SCENES = Path(toml.__file__).resolve().parents[1] / "scenes"
READERS = "Source", "_layers", "_scene", "check_scene", "doubts_of", "to_type"  # of the module, which tests may replace


def start() -> None:
    """Have shipped scenes read once from now on; the next calls do nothing."""
    if not hasattr(toml.read, "as_ever"):
        toml.read = once(toml.read)


def once(read: Callable[..., Any]) -> Callable[..., Any]:
    """A reader of scenes that knows those of `SCENES` which it has read, and what was in doubt about them."""
    kept: dict[Path, tuple[Any, list[Any]]] = {}
    readers = {name: getattr(toml, name) for name in READERS}

    def found(path: str | Path, doubts: list[Any] | None = None) -> Any:
        place = Path(path).absolute()
        if SCENES not in place.parents or any(getattr(toml, name) is not one for name, one in readers.items()):
            return read(path, doubts)
        if place not in kept:
            told: list[Any] = []
            kept[place] = read(path, told), told
        scene, told = kept[place]
        if doubts is not None:
            doubts.extend(told)
        return copy.deepcopy(scene)

    found.as_ever = read
    return found
