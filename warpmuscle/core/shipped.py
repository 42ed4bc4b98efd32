"""Where the shipped scenes lie, and what they say of themselves, without what reads and checks a whole scene."""

from __future__ import annotations

import re
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

FIRST_TABLE = re.compile(r"^[ \t]*\[", re.MULTILINE)
MOST_BASES = 8  # that are looked through for a description


def scenes_folder() -> Path:
    """The folder of the scenes that come with the package.

    It is looked up, not imported: an imported `warpmuscle.scenes` would take the name of the function.
    """
    spec = find_spec("warpmuscle.scenes")
    assert spec is not None
    return Path((spec.submodule_search_locations or [""])[0])


def shipped_scenes() -> dict[str, Path]:
    """Files of the shipped scenes by their names, in order; characters that scenes share are not among them."""
    files = sorted(scenes_folder().rglob("*.toml"), key=lambda path: path.stem)
    return {path.stem: path for path in files if is_scene(path)}


def is_scene(path: Path) -> bool:
    """Whether a TOML file claims to be a scene and not, say, a character that scenes share."""
    return "name" in heading(path)


def description(path: Path, scenes: dict[str, Path]) -> str:
    """What a shipped scene says of itself, or else the scene that it is based on; empty if none does.

    Args:
        path: its file. scenes: all of them, by name.
    """
    for _ in range(MOST_BASES):
        said = heading(path)
        if "description" in said or "base" not in said:
            return str(said.get("description", ""))
        name = str(said["base"])
        beside = path.parent / name
        path = beside if beside.is_file() else scenes.get(name.removesuffix(".toml"), beside)
    return ""


def heading(path: Path) -> dict[str, Any]:
    """Values that stand before the first table of a TOML file; none if it cannot be read."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
        for table in FIRST_TABLE.finditer(text):
            try:
                return tomllib.loads(text[: table.start()])
            except tomllib.TOMLDecodeError:  # a list or a text of several lines, in which a line begins so
                continue
        return tomllib.loads(text)
    except (OSError, ValueError, RecursionError):
        return {}
