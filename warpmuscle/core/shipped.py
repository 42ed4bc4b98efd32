"""Where the shipped scenes lie, what each folder of them is for, and what they say of themselves.

Nothing here reads or checks a whole scene.
"""

from __future__ import annotations

import re
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

FIRST_TABLE = re.compile(r"^[ \t]*\[", re.MULTILINE)
MOST_BASES = 8  # that are looked through for a description

# Folders in the order in which they are listed. Characters that scenes share are no scenes.
STUDIES = {
    "gaits": "walks, jogs and runs on 56 muscles, and scenes from which to search for one",
    "torques": "gaits driven by torques: fast to simulate, good for first tries and as a start for muscles",
    "steering": "walks that follow a commanded speed and heading (Coros 2010)",
    "creatures": "animals made from short descriptions; a search found muscles and gait together (Geijtenbeek 2013)",
    "reflexes": "walks by muscle reflexes (Geyer and Herr 2010)",
    "bergmann2017": "experiments of Bergmann 2017: arm muscles, walks on some muscles, and that program's own walks",
    "wang2012": "a walk on the 16 leg muscles of Wang 2012",
    "terrain": "walks on bumps, stairs and slopes",
    "worlds": "walks among objects, on treadmills and in water",
    "opensim": "converted models of OpenSim, and their gaits",
    "programs": "standing, squatting, walking and reaching by a quadratic programme over many muscles (after Lee 2014)",
    "throws": "arms that throw, for `warpmuscle throw` (Cruz Ruiz 2015)",
    "superseded": "older walks that later ones replace; they stay because published comparisons and pages use them",
}
CHARACTERS = "characters"


def scenes_folder() -> Path:
    """The folder of the scenes that come with the package.

    It is looked up, not imported: an imported `warpmuscle.scenes` would take the name of the function.
    """
    spec = find_spec("warpmuscle.scenes")
    assert spec is not None
    return Path((spec.submodule_search_locations or [""])[0])


def shipped_file(name: str) -> Path | None:
    """A shipped scene, character or part of one, by its name with or without `.toml`; None if there is none."""
    file = name if name.endswith(".toml") else f"{name}.toml"
    root = scenes_folder()
    paths = (root / folder / file for folder in (*STUDIES, CHARACTERS))
    return next((path for path in paths if path.is_file()), None)


def moved_scene(path: Path) -> str:
    """What to write in place of a path of before to a shipped file; "" if it is none.

    Shipped scenes lay in one folder called `scenes`.
    """
    if path.parent.name != "scenes" or path.exists() or shipped_file(path.name) is None:
        return ""
    return f'shipped scenes have folders of their own now; write the name alone, "{path.stem}"'


def shipped_scenes(beginning: str = "") -> dict[str, Path]:
    """Files of the shipped scenes by their names, in order; characters that scenes share are not among them.

    Args:
        beginning: of the names of those that are asked for.
    """
    found = (path for path in scenes_folder().rglob("*.toml") if path.stem.startswith(beginning))
    files = sorted(found, key=lambda path: path.stem)
    return {path.stem: path for path in files if is_scene(path)}


def scene_groups(scenes: dict[str, Path] | None = None) -> dict[str, list[str]]:
    """Names of the shipped scenes by the study that they belong to, see `STUDIES`.

    Args:
        scenes: all of them, by name, where they have been looked through already.
    """
    found = shipped_scenes() if scenes is None else scenes
    return {study: [name for name, path in found.items() if path.parent.name == study] for study in STUDIES}


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
