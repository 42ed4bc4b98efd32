"""Where the shipped scenes lie, and what each folder of them is for."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

# Folders in the order in which they are listed. Characters that scenes share are no scenes.
STUDIES = {
    "gaits": "walks, jogs and runs on 56 muscles, and where to begin a search for one",
    "torques": "gaits that torques drive: fast, for trying out and for searches on muscles to start from",
    "reflexes": "walks by muscle reflexes (Geyer and Herr 2010)",
    "bergmann2017": "experiments of Bergmann 2017: muscles of arms, and walks on some muscles or of that program",
    "wang2012": "a walk on the 16 leg muscles of Wang 2012",
    "opensim": "models of OpenSim, as converted, and their gaits",
    "throws": "arms that throw, for `warpmuscle throw` (Cruz Ruiz 2015)",
    "superseded": "walks that later ones replace; kept because published comparisons and pages rest on them",
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
