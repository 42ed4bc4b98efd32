"""Code that the scenes of a sweep name: trusted here, and carried to the workers of a cluster."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from warpmuscle.scene import Scene
from warpmuscle.scene.trusted_code import check_trusted, folders, named_code, trust


@dataclass(frozen=True)
class NamedCode:
    """What the user trusts, for a worker that may be on another machine."""

    scenes: tuple[Scene, ...] = ()  # those that name code
    folders: tuple[str, ...] = ()  # where modules are looked for
    files: tuple[tuple[str, bytes], ...] = ()  # the modules in these folders: path in the folder, and content


def named_by(scenes: Sequence[Scene]) -> NamedCode:
    """The code that scenes name; modules that it imports from elsewhere have to be installed on the workers.

    Raises:
        SceneError: a scene names code that the user has not said to trust.
    """
    naming: list[Scene] = []
    for scene in scenes:
        check_trusted(scene)
        if named_code(scene) and scene not in naming:
            naming.append(scene)
    entries = {entry for scene in naming for entry in named_code(scene).values()}
    files: dict[str, bytes] = {}
    for module in sorted({entry.partition(":")[0] for entry in entries}):
        files |= _files(module)
    places = tuple(str(folder.absolute()) for folder in folders()) if naming else ()
    return NamedCode(tuple(naming), places, tuple(files.items()))


def _files(module: str) -> dict[str, bytes]:
    """The file of a module and those of the packages it is in, from the first folder that has it."""
    parts = module.split(".")
    for folder in folders():
        base = folder.joinpath(*parts)
        own = [path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file()]
        if own:
            above = (folder.joinpath(*parts[:depth]) / "__init__.py" for depth in range(1, len(parts)))
            found = [*own, *(path for path in above if path.is_file())]
            return {str(path.relative_to(folder)): path.read_bytes() for path in found}
    return {}


@contextlib.contextmanager
def trusted_there(code: NamedCode) -> Iterator[None]:
    """Trust, in this process, what was trusted where the sweep began; its modules are found meanwhile."""
    if not code.scenes:
        yield
        return
    with tempfile.TemporaryDirectory(prefix="warpmuscle-code-") as own:
        for name, content in code.files:
            path = Path(own) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        for scene in code.scenes:
            for folder in (*(Path(place) for place in code.folders), Path(own)):
                trust(scene, folder)
        yield
